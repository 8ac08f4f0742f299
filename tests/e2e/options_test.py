#!/usr/bin/env python3
"""Every option of every verb with values that are none: the exit code of a wrong use, one line that names the option."""
import re
import shutil

from harness import Harness

VERBS = {
    "scan": ("sphere", "-o", "o.ply", "--points", "300"),
    "slice": ("s.ply", "-o", "work2"),
    "normals": ("work",),
    "fit": ("work",),
    "tree": ("work", "-o", "o.slim"),
    "build": ("s.ply", "-o", "o.slim"),
    "info": ("m.slim",),
    "render": ("m.slim", "-o", "o.png", "--size", "64x48"),
    "measure": ("m.slim", "s.ply"),
    "smooth": ("m.slim", "s.ply", "-o", "os.ply"),
    "run": ("job.toml", "-o", "out"),
    "plan": ("job.toml",),
    "report": ("report.toml", "-o", "page"),
}
NONSENSE = ("nonsense", "", "nan", "-inf", "1e400", "-7", "1,,2", "0x10", "a\nb", "99999999999999999999")
# What of these is a value of the option (a name of a file to be, a title, a number that is large but sound).
TAKES_TEXT = {"unit", "name", "lines_ply", "lines_obj", "output", "work"}
SOUND = {("seed", "99999999999999999999"), ("lambda", "99999999999999999999"), ("most", "99999999999999999999"),
         ("ao_distance", "99999999999999999999"), ("ortho_width", "99999999999999999999")}
harness = Harness("slim", *(f"slim-{verb}" for verb in VERBS))
run, check = harness.run, harness.check


def wrong(verb, key, value):
    """Refused (2), or for what a file holds (3), in one line with the option's name, or its key's."""
    option = "--" + key.replace("_", "-")
    result = run(f"slim-{verb}", *VERBS[verb], f"{option}={value}")
    said = f"{verb} {option}={value!r}: exit {result.code}: {result.err[-300:]}"
    if key in TAKES_TEXT or (key, value) in SOUND:
        check(result.code in (0, 2, 3, 5), said)
        made = harness.folder / (value or "nothing")  # the name of another option's value, too
        if made.is_dir():
            shutil.rmtree(made)
        return
    check(result.code in (2, 3), said)
    errors = [line for line in result.err.splitlines() if ": error: " in line]
    check(len(errors) == 1 and result.err.rstrip().splitlines()[-1] == errors[0], f"not one line: {said}")
    # Of a file that is read, its name is enough: it was asked for once.
    names = (option, f"-o {value}") if result.code == 2 else (option, value.replace("\n", "\\n"))
    check(any(name in result.err for name in names), f"does not name the option: {said}")


def impossible():
    """Values of the right kind that cannot be."""
    for verb, words, expected in (
            ("render", ("--crop", "0,0,999,9"), "--crop"), ("render", ("--crop", "1,1,0,0"), "--crop"),
            ("render", ("--tile", "4/3"), "--tile"), ("render", ("--share", "0/2"), "--share"),
            ("render", ("--frame", "4", "--turntable", "3"), "--frame"),
            ("render", ("--size", "99999x9"), "--size"), ("render", ("--range", "mean=2:1"), "--range"),
            ("render", ("--aov", "mean", "--range", "mean=nan"), "--range"),
            ("render", ("--supersample", "2", "--antialias"), "--antialias"),
            ("render", ("--camera", "0,0,0,0,0,0"), "--camera"), ("render", ("--light", "sun power=nan"), "--light"),
            ("render", ("--material", "mirror=7"), "--material"), ("render", ("--ao",), "--ao"),
            ("fit", ("--memory", "1"), "--memory"), ("tree", ("--memory", "1"), "--memory"),
            ("slice", ("--memory", "1"), "--memory"), ("scan", ("--offset", "1e300,0,0"), "--offset"),
            ("normals", ("--slice", "99"), "--slice"), ("fit", ("--slice", "99"), "--slice"),
            ("build", ("--quiet", "--verbose"), "--quiet")):
        result = run(f"slim-{verb}", *VERBS[verb], *words)
        check(result.code == 2 and expected in result.err, f"{verb} {words}: exit {result.code}: {result.err[-300:]}")
    result = run("slim", "build", "s.ply", "-o", "none.slim", "--sensors", "none.json")
    check(result.code == 3 and "none.json: cannot be opened" in result.err and "slice:" not in result.err,
          f"sensors that are not there are told before the cloud is read: {result.err}")
    result = run("slim", "normals", "work", "--sensors", ".")
    check(result.code == 3 and "internal" not in result.err, f"a folder of sensors: {result.code} {result.err}")


def misspelt():
    """A slip in a word of fixed ones: the nearest is told, and --json has it in a place of its own."""
    slips = (("camera", "fornt", "front"), ("aov", "shadde", "shaded"), ("lines", "crset", "crest"), ("up", "Y", "y"),
             ("mode", "raytarce", "raytrace"), ("background", "wihte", "white"), ("same_range", "fornt", "front"),
             ("range", "maen=3", "mean"), ("light", "kye", "key"), ("light", "sun azimut=3", "azimuth"),
             ("light", "sun shadows=onn", "on"), ("material", "color=sacn", "scan"), ("material", "colr=scan", "color"),
             ("contours", "nnoe", "none"), ("ground_height", "atuo", "auto"), ("ground_color", "shdow", "shadow"),
             ("truth_shape", "shpere", "sphere"), ("format", "ppng", "png"), ("job", "curvatrue", "curvature"))
    beside = {"contours": ("--aov", "hillshade"), "ground_height": ("--ground", "--mode", "raytrace"),
              "ground_color": ("--ground", "--mode", "raytrace"), "truth_shape": ("--aov", "truth_distance"),
              "same_range": ("--aov", "mean"), "range": ("--aov", "mean")}
    for key, value, meant in slips:
        option = "--" + key.replace("_", "-")
        result = run("slim", "render", *VERBS["render"], f"{option}={value}", *beside.get(key, ()), "--json")
        error = result.json().get("error", {})
        said = f"{option} {value}: {result.code} {error}"
        check(result.code == 2 and error.get("option") == option, said)
        check(key == "job" or error.get("key") == key, said)
        check(error.get("hint") == f"did you mean '{meant}'?" and error["hint"] in error["message"], said)
    result = run("slim", "render", *VERBS["render"], "--path", "front; bcak", "--frames", "3")
    check("did you mean 'back'?" in result.err and "keyframe 2" in result.err, result.err)


run("slim", "scan", "sphere", "-o", "s.ply", "--points", 1500)
run("slim", "build", "s.ply", "-o", "m.slim", "--work", "work", "--t-mdl", 0.05)
(harness.folder / "job.toml").write_text("[input]\nfiles = ['s.ply']\n[[view]]\nsize = '64x48'\n")
(harness.folder / "report.toml").write_text("[[experiment]]\nname = 'e'\n[[experiment.step]]\nname = 'c'\nrun = 'scan'\n"
                                            "args = 'sphere --points 300'\n[experiment.columns]\np = 'c.points'\n")
for verb in VERBS:
    text = run(f"slim-{verb}", "--print-config").out
    for key, default in re.findall(r"^([a-z_]+) = (.*)$", text, re.M):
        for value in NONSENSE if default not in ("true", "false") else ("maybe", "7"):
            wrong(verb, key, value)
    for value in NONSENSE[:6]:
        wrong(verb, "threads", value)
    wrong(verb, "config", "nonsense")
    wrong(verb, "config", ".")
impossible()
misspelt()
harness.end()
