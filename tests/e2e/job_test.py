#!/usr/bin/env python3
"""A small job from scan to page: what it writes, that it does only what changed, and that a killed
build resumes; the model's bytes for several numbers of threads."""
import os
import pathlib
import re
import signal
import subprocess
import time

from harness import Harness

harness = Harness("slim", "slim-scan", "slim-build", "slim-render", "slim-measure", "slim-run", "slim-plan")
run, check = harness.run, harness.check

JOB = """
[input.scan]
shape = "bumpy"
points = 20000
noise = 0.0002
[fit]
t_mdl = 0.02
[render]
size = "SIZE"
truth_shape = "bumpy"
[[view]]
camera = "front"
[[view]]
name = "corner"
camera = "iso"
aovs = ["shaded"]
size = "200x150"
[measure]
[output]
dir = "out"
aovs = ["shaded", "mean", "truth_distance"]
"""


def write_job(size="240x180"):
    (harness.folder / "job.toml").write_text(JOB.replace("SIZE", size))


def steps(result):
    return {step["name"]: step for step in result["steps"]}


def run_job():
    result = run("slim", "run", "job.toml", "--json", "-q", seconds=300)
    check(result.code == 0, f"slim run: exit {result.code}: {result.err}")
    return result.json()


def whole_job():
    write_job()
    done = steps(run_job())
    check(list(done) == ["scan", "build", "measure", "view front", "view corner"], f"steps {list(done)}")
    measured = done["measure"]["result"]
    for key in ("points", "missed", "l2", "max", "normal_rms_deg", "leaves", "bytes", "k1_rms", "k2_rms",
                "mean_curvature_rms", "k1_rms_x_diagonal"):
        check(key in measured, f"measure does not say {key}")
    check(measured["points"] == 20000, f"measured {measured['points']} points")
    check(0 < measured["l2"] < 1e-3, f"l2 is {measured['l2']}")
    page = (harness.folder / "out/index.html").read_text()
    pictures = re.findall(r'<img src="([^"]+)"', page)
    check(len(pictures) == 4, f"the page shows {pictures}")
    for picture in pictures:
        check((harness.folder / "out" / picture).exists(), f"the page shows {picture}, which is not there")
    check(str(harness.folder) not in page, "the page holds an absolute path")


def same_pictures_of_a_model():
    """`slim render MODEL --job` draws the bytes that `slim run` drew, with its input gone."""
    text = JOB.replace("SIZE", "240x180").replace('shape = "bumpy"\npoints', 'shape = "torus"\npoints', 1)
    (harness.folder / "view.toml").write_text(text)
    result = run("slim", "render", "out/model.slim", "-o", "drawn", "--job", "view.toml", "--json")
    check(result.code == 0, f"render --job: exit {result.code}: {result.err}")
    answer = result.json()
    check([step["name"] for step in answer["steps"]] == ["view front", "view corner"], f"steps {answer['steps']}")
    names = sorted(pathlib.Path(file).name for file in answer["files"])
    check("corner.shaded.png" in names and "front.mean.png" in names, f"files {names}")
    for name in names:
        check((harness.folder / "drawn" / name).read_bytes() == (harness.folder / "out" / name).read_bytes(),
              f"{name} is not what slim run drew")
    again = run("slim", "render", "out/model.slim", "-o", "drawn", "--job", "view.toml", "--json").json()
    check(all(step["up_to_date"] for step in again["steps"]), "nothing changed, yet a view is drawn again")
    sized = run("slim", "render", "out/model.slim", "-o", "sized", "--job", "view.toml", "--size", "64x48",
                "--aov", "depth", "--json").json()
    sizes = {(step["result"]["width"], step["result"]["height"]) for step in sized["steps"]}
    check(sizes == {(64, 48)} and sorted(pathlib.Path(f).name for f in sized["files"]) ==
          ["corner.depth.legend.svg", "corner.depth.png", "front.depth.legend.svg", "front.depth.png"],
          f"options do not win over the job: {sized['files']}, {sizes}")
    (harness.folder / "one.toml").write_text('[[view]]\ncamera = "top"\nsize = "64x48"\n')
    one = run("slim", "render", "out/model.slim", "-o", "one.png", "--job", "one.toml", "--json").json()
    check(one["files"] == ["one.png"], f"a file of one view: {one['files']}")
    exr = run("slim", "render", "out/model.slim", "-o", "exr", "--job", "view.toml", "--format", "exr", "--json")
    made = {pathlib.Path(f).name for f in exr.json().get("files", [])}
    check(exr.code == 0 and {"front.exr", "front.png", "corner.exr"} <= made, f"EXRs in a folder: {exr.out}")
    usual = run("slim", "render", "--print-config").out
    (harness.folder / "whole.toml").write_text(usual.replace('"1600x1200"', '"80x60"'))
    whole = run("slim", "render", "out/model.slim", "-o", "whole", "--job", "view.toml", "--config", "whole.toml", "--json")
    check(whole.code == 0 and [(s["result"]["width"], len(s["result"]["files"])) for s in whole.json()["steps"]] ==
          [(80, len(s["result"]["files"])) for s in answer["steps"]], f"a whole --config beside --job: {whole.out}{whole.err}")
    (harness.folder / "cut.toml").write_text("".join(line for line in usual.replace('"1600x1200"', '"80x60"').splitlines(True)
                                                     if not line.startswith(("aov = ", "fov = "))))
    cut = run("slim", "render", "out/model.slim", "-o", "cut", "--job", "view.toml", "--config", "cut.toml", "--json")
    check(cut.code == 0 and [len(s["result"]["files"]) for s in cut.json()["steps"]] ==
          [len(s["result"]["files"]) for s in answer["steps"]], f"one of which lines were taken out: {cut.out}{cut.err}")
    (harness.folder / "short.toml").write_text('size = "1600x1200"\n')  # as by default, and meant
    (harness.folder / "small.toml").write_text('[render]\nsize = "20x15"\n[[view]]\naovs = ["depth"]\n')
    short = run("slim", "render", "out/model.slim", "-o", "short", "--job", "small.toml", "--config", "short.toml", "--json")
    check(short.code == 0 and [s["result"]["width"] for s in short.json()["steps"]] == [1600],
          f"a short --config beside --job: {short.out}{short.err}")
    (harness.folder / "lined.toml").write_text('[[view]]\nname = "a"\naovs = ["lines"]\n[[view]]\nname = "b"\naovs = ["lines"]\n')
    (harness.folder / "no_folder").write_text("")
    refused = {
        ("-o", "no_folder/x", "--job", "view.toml"): "-o no_folder/x: no_folder is no folder",
        ("-o", "x", "--job", "lined.toml", "--lines-ply", "e.txt"): "--lines-ply: expected a name ending in .ply, found e.txt",
        ("-o", "x.png", "--job", "view.toml"): "view.toml: its 2 views cannot all be x.png",
        ("-o", "x", "--job", "view.toml", "--share", "1/2"): "--share divides one picture",
        ("-o", "x", "--job", "view.toml", "--aov", "e1"): "--aov e1 needs third derivatives",
        ("-o", "x", "--job", "view.toml", "--sun", "3,4"): "--sun is for the aov hillshade",
        ("-o", "x", "--job", "view.toml", "--size", "big"): "--size: expected WIDTHxHEIGHT",
        ("-o", "x", "--job", "view.toml", "--range", "x"): "--range: expected A > 0",
        ("-o", "x", "--job", "view.toml", "--crop", "0,0,9999,9"): "--crop: expected x,y,w,h",
        ("-o", "x", "--job", "view.toml", "--ao"): "--ao needs rays",
        ("-o", "x", "--job", "view.toml", "--name", "n"): "--name: a second view of the name 'n'",
        ("-o", "x", "--job", "view.toml", "--camera", "top", "--name", "a/b"): "--name: expected a name without '/'",
        ("-o", "x", "--job", "none.toml"): "none.toml: cannot read",
        ("-o", "x", "--job", "out/model.slim"): "out/model.slim: a model, not a job",
    }
    for words, expected in refused.items():
        result = run("slim", "render", "out/model.slim", *words, "--json")
        message = result.json()["error"]["message"]
        at = message.find(expected)
        check(result.code == 2 and (at == 0 if expected[0] == "-" else at >= 0), f"{words}: {result.out}")
    check(run("slim", "render", "none.slim", "-o", "x", "--job", "view.toml").code == 3, "a missing model")
    added = run("slim", "render", "out/model.slim", "-o", "x", "--job", "view.toml", "--mode", "raytrace",
                "--add", "gone.slim", "--json")
    message = added.json()["error"]["message"]
    check(added.code == 3 and "gone.slim: cannot be opened" in message.split("(view")[0] and "(view " in message,
          f"a file that an option named is the option's, not the job's: {added.out}")


def left_out_in_a_line():
    """A run names what nothing asks for in one line, a program is told why."""
    (harness.folder / "two.toml").write_text('[input]\nfiles = ["out/cloud.ply"]\n[render]\nsize = "64x48"\n[output]\n'
                                             'dir = "two"\n[[view]]\ncamera = "top"\n[[view]]\ncamera = "iso"\n')
    result = run("slim", "run", "two.toml", "--json")
    check(result.code == 0 and result.err.count("left out: ") == 1 and "rays" in result.err, f"two views: {result.err}")
    check(any(line.startswith("rays: no view") for line in result.json()["left_out"]), f"reasons: {result.out}")


def explained():
    """A job that run refuses is explained, with the fault; no plan is made of it."""
    (harness.folder / "crest.toml").write_text('[input]\nfiles = ["out/cloud.ply"]\n[fit]\ndegree = 2\n[[view]]\nlines = ["crest"]\n')
    told = run("slim", "plan", "crest.toml", "--explain")
    fault = "crest.toml:6: lines crest need third derivatives"
    check(told.code == 0 and fault in told.out and "build: slim build" in told.out, f"{told.code} {told.out} {told.err}")
    check(fault in run("slim", "plan", "crest.toml", "--explain", "--json").json()["refused"][0], "refused in --json")
    for words in (("plan", "crest.toml"), ("run", "crest.toml")):
        result = run("slim", *words)
        check(result.code == 2 and fault in result.err, f"{words}: {result.code} {result.err}")


def parts_of_a_step():
    """What a step was refused for reaches a program in its parts, of run as of render --job."""
    (harness.folder / "cut.toml").write_text('[input]\nfiles = ["out/cloud.ply"]\n[output]\ndir = "cut"\n'
                                            '[[view]]\nmode = "raytrace"\nadd = ["out"]\n')
    for words in (("run", "cut.toml"), ("render", "out/model.slim", "-o", "x", "--job", "cut.toml")):
        result = run("slim", *words, "--json", "-q")
        error = result.json()["error"]
        check(result.code == 2 and error.get("file", "").endswith("out") and "view front: " in error["message"] and
              error.get("expected", "").startswith("a model"), f"{words}: {result.out}")
        check("\n" not in result.err.strip() and result.err.strip().endswith(error["message"]), f"{words}: {result.err}")


def only_what_changed():
    again = steps(run_job())
    redone = [name for name, step in again.items() if not step["up_to_date"]]
    check(not redone, f"nothing changed, yet {redone} ran again")
    write_job("241x180")
    again = steps(run_job())
    redone = [name for name, step in again.items() if not step["up_to_date"]]
    check(redone == ["view front"], f"one view changed, and {redone} ran again")


def threads_agree():
    reference = None
    for threads in (1, 2, 7):
        model = harness.folder / f"t{threads}.slim"
        result = run("slim-build", "out/cloud.ply", "-o", model, "--t-mdl", "0.02", "--threads", threads)
        check(result.code == 0, result.err)
        data = model.read_bytes()
        reference = reference or data
        check(data == reference, f"{threads} threads make another model")


def killed_build_resumes():
    result = run("slim-scan", "sculpture", "--points", "300000", "-o", "big.ply", "-q", seconds=120)
    check(result.code == 0, result.err)
    command = ["slim-build", "big.ply", "-o", "big.slim", "--slices", "2"]  # of one slice nothing would be kept
    child = subprocess.Popen([harness.bin / command[0], *command[1:]], cwd=harness.folder,
                             stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    slice_done = harness.folder / "big.slim.work/slice.done.json"
    for _ in range(1000):
        time.sleep(0.01)
        if slice_done.exists():
            break
    child.send_signal(signal.SIGTERM)
    _, err = child.communicate(timeout=60)
    check(child.returncode == 143, f"killed build: exit {child.returncode}: {err.decode()}")
    check(not (harness.folder / "big.slim").exists(), "a killed build left a model")
    check(slice_done.exists(), "a killed build forgot the slices it had")
    resumed = run(*command, seconds=300)
    check(resumed.code == 0 and "slice: up to date" in resumed.err, f"resumed: {resumed.err}")
    fresh = run("slim-build", "big.ply", "-o", "fresh.slim", "--slices", "2", seconds=300)
    check(fresh.code == 0, fresh.err)
    same = (harness.folder / "big.slim").read_bytes() == (harness.folder / "fresh.slim").read_bytes()
    check(same, "a resumed build makes another model")
    check(not (harness.folder / "big.slim.work").exists(), "the work folder is still there")


def child_of(process):
    """The process id of its one child, as soon as there is one."""
    children = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children")
    for _ in range(1000):
        found = children.read_text().split()
        if found:
            return int(found[0])
        time.sleep(0.005)
    raise SystemExit("slim run starts no child")


def a_killed_run_takes_its_child_along():
    """Else it works on and holds the folder: the next run would end with 75."""
    (harness.folder / "long.toml").write_text("[input]\nfiles = ['big.ply']\n"
                                              "[fit]\nt_mdl = 0.00001\nsharp = 'on'\ndegree = 'auto'\n")
    command = [harness.bin / "slim-run", "long.toml", "-q", "--threads", "1"]  # seconds, at the least
    parent = subprocess.Popen(command, cwd=harness.folder, stdout=subprocess.DEVNULL)
    child = child_of(parent)
    time.sleep(0.3)
    parent.kill()
    parent.wait()
    ended = False
    for _ in range(200):
        state = pathlib.Path(f"/proc/{child}/stat")
        ended = not state.exists() or state.read_text().rsplit(")", 1)[1].split()[0] == "Z"
        if ended:
            break
        time.sleep(0.005)
    check(ended, "slim run was killed and its child works on")
    if not ended:
        os.kill(child, signal.SIGKILL)


def plan():
    printed = run("slim", "plan", "job.toml", "--format", "make")
    check(printed.code == 0 and "slim-build" in printed.out, f"plan: {printed.err}")
    explained = run("slim", "plan", "job.toml", "--explain")
    check("Left out" in explained.out and "depth" in explained.out, explained.out)


def resolved():
    """--print-config prints all that could be written, and what it prints is the same job."""
    written = JOB.replace("SIZE", "240x180")
    (harness.folder / "asked.toml").write_text("schema_version = 1\n" + written)
    printed = run("slim", "run", "asked.toml", "--print-config", "--set", "fit.degree=3")
    check(printed.code == 0, f"--print-config: {printed.err}")
    for line in ("schema_version = 1", "[input.scan]", 'shape = "bumpy"', "[fit]", 'degree = 3', "t_mdl = 0.02",
                 "normals = ", "[measure]", "tolerance = ", 'size = "240x180"', "supersample = 1", 'name = "front"',
                 'size = "200x150"', 'aovs = ["shaded"]', 'title = "asked"'):
        check(line in printed.out, f"--print-config lacks {line}")
    (harness.folder / "again.toml").write_text(printed.out)
    again = run("slim", "run", "again.toml", "--print-config")
    check(again.out == printed.out, f"what --print-config prints is another job: {again.err}")
    pictures = []
    for name, more in (("asked.toml", ["--set", "fit.degree=3"]), ("again.toml", ["--force"])):
        ran = run("slim", "run", name, "-q", *more, seconds=300)
        check(ran.code == 0, f"{name} does not run: {ran.err}")
        out = harness.folder / "out"
        pictures.append({f.name: f.read_bytes() for f in sorted(out.glob("*.png"))})
    check(pictures[0] == pictures[1] and len(pictures[0]) > 2, "the printed job draws other pictures")
    check(run("slim", "run", "--print-config").out.count("\n[") == 0, "without a job: the options of run")


def schema():
    job = harness.folder / "schema.toml"
    for said, expected in (("2", "version 1, found 2"), ("'1'", "version 1, found 1"), ("[1]", "version 1")):
        job.write_text(f"schema_version = {said}\n[input]\nfiles = ['nowhere.ply']\n")
        result = run("slim", "run", "schema.toml", "--json")
        check(result.code == 2 and "schema.toml:1: schema_version" in result.err and expected in result.err, result.err)
    job.write_text("shcema_version = 1\n[input]\nfiles = ['nowhere.ply']\n")
    result = run("slim", "run", "schema.toml", "--json")
    check(result.code == 2 and "'schema_version'" in result.err, result.err)


def wrong_jobs():
    job = harness.folder / "wrong.toml"
    job.write_text("[input]\nfiles = ['nowhere.ply']\n[fit]\ndegre = 2\n")
    result = run("slim", "run", "wrong.toml", "--json")
    check(result.code == 2 and "wrong.toml:4" in result.err and "'degree'" in result.err, result.err)
    job.write_text("[input]\nfiles = ['nowhere.ply']\n")
    result = run("slim", "run", "wrong.toml", "--json")
    check(result.code == 3 and "nowhere.ply" in result.json()["error"]["message"], result.err)
    for verb in ("run", "plan"):
        result = run("slim", verb, "nowhere.toml", "--json")
        check(result.code == 2 and "nowhere.toml" in result.json()["error"]["message"],
              f"{verb} without its job file: {result.code} {result.err}")


whole_job()
same_pictures_of_a_model()
left_out_in_a_line()
explained()
parts_of_a_step()
only_what_changed()
threads_agree()
killed_build_resumes()
a_killed_run_takes_its_child_along()
plan()
resolved()
schema()
wrong_jobs()
harness.end()
