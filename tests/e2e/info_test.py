#!/usr/bin/env python3
"""slim info knows our files by kind; pictures say how large they print; a truth that is none is refused."""
import random
import re
import struct

from harness import Harness

harness = Harness("slim", "slim-scan", "slim-build", "slim-render", "slim-measure", "slim-info", "slim-slice",
                  "slim-plan", "slim-report")
run, check, folder = harness.run, harness.check, harness.folder


def info(name, **expected):
    result = run("slim", "info", name, "--json")
    if not check(result.code == 0, f"info {name}: exit {result.code}: {result.err}"):
        return {}
    answer = result.json()
    for key, value in expected.items():
        check(answer.get(key) == value, f"info {name}: {key} is {answer.get(key)}, not {value}")
    check(answer.get("about", "-"), f"info {name}: nothing is said of it")
    check("about" in run("slim", "info", name).out, f"info {name}: no sentence for people")
    return answer


def chunk(name, tag):
    data = (folder / name).read_bytes()
    at = 8
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == tag:
            return data[at + 8:at + 8 + length]
        at += 12 + length
    return None


def kinds():
    picture = info("x.png", kind="png", width=64, height=48, channels=["R", "G", "B"])
    check(picture.get("metadata", {}).get("slim:units") == "mm", f"metadata of x.png: {picture.get('metadata')}")
    data = info("y.exr", kind="exr", width=64, height=48)
    check("curvature.mean" in data.get("channels", []), f"channels of y.exr: {data.get('channels')}")
    info("c.truth", kind="truth", points=6000, cloud="c.ply")
    check("feature lines" in info("x.lines.svg", kind="svg").get("about", ""), "x.lines.svg")
    job = info("job.toml", kind="job", tables=["input", "view"], views=1, keys=1, input={"files": ["c.ply"]})
    check(job.get("view_list") == [{"name": "front", "aovs": ["shaded"], "lines": []}], f"views of a job: {job}")
    (folder / "long.toml").write_text("[input.scan]\nshape = 'torus'\n[fit]\ndegree = 3\n[render]\ncamera = 'iso'\n"
                                      "[[view]]\naovs = ['mean', 'k1']\n[[view]]\nname = 'b'\nlines = 'crest'\n"
                                      "[output]\naovs = ['depth']\ndir = 'out/x'\n")
    long = info("long.toml", kind="job", views=2, keys=8, fit={"degree": 3}, scan={"shape": "torus"})
    check([v["name"] for v in long.get("view_list", [])] == ["iso", "b"], f"names of views: {long}")
    told = run("slim", "info", "long.toml").out
    for part in ("shape = torus", "degree = 3", "iso: mean, k1; b: depth, lines crest", "dir = out/x"):
        check(part in told, f"a job does not say '{part}': {told}")
    (folder / "options.toml").write_text("size = '9x9'\nzoom = 2\n")
    info("options.toml", kind="toml", keys=2, options={"size": "9x9", "zoom": 2})
    check("2: size, zoom" in run("slim", "info", "options.toml").out, "keys of options")
    check(info("x.lines.svg").get("paths", 0) > 0, "paths of x.lines.svg")
    (folder / "drawn.svg").write_text('<svg><defs><linearGradient id="a"/></defs><line x1="0"/><line\nx1="1"/><path d=""/>'
                                      '<polyline points=""/><textPath/><text>a</text><path/></svg>\n')
    info("drawn.svg", kind="svg", paths=5, texts=1)
    info("page.html", kind="html", html_tables=0)
    lines = info("x.obj", kind="obj", faces=0)
    check(lines.get("lines", 0) > 0 and "--lines-obj" in lines.get("about", ""), f"x.obj: {lines}")
    (folder / "broken.png").write_bytes((folder / "x.png").read_bytes()[:20])
    check(run("slim", "info", "broken.png").code == 3, "a picture that is cut off")
    check(run("slim", "info", "none.png").code == 3, "a picture that is not there")


def records():
    """What verbs write for programs and for other tools says what it is, with counts."""
    info("x.ply", kind="lines", edges=info("x.ply").get("edges"), points=info("x.obj").get("vertices"))
    check(info("x.ply").get("edges", 0) > 0, "edges of x.ply")
    check("--per-point" in info("points.ply", kind="cloud", points=6000).get("about", ""), "points.ply")
    table = info("rep/small.rows.csv", kind="table", rows=2)
    check(table.get("columns", [])[:3] == ["n", "points, all", "s"], f"columns: {table}")
    info("rep/report.json", kind="report", experiments=1, rows=2)
    step = next((folder / "rep" / "steps").glob("*.step.json"))
    info(step.relative_to(folder), kind="step", files=4)
    info(str(step.relative_to(folder)).replace(".step.json", ".log"), kind="log", errors=0)
    info("rep/index.html", kind="html", html_tables=1)
    info("small.toml", kind="report", experiments=1, experiment_names=["rows"])
    check("1: rows" in run("slim", "info", "small.toml").out, "experiments of a report")
    info("m.slim.done.json", kind="manifest", outputs=1)
    info("c.scans.json", kind="scans", scans=8)
    info("w/plan.json", kind="plan", slices=2)
    info("measured.json", kind="result")
    for name, counted in (("make", "rules"), ("slurm", "jobs"), ("snakemake", "rules")):
        (folder / f"plan.{name}").write_text(run("slim", "plan", "job.toml", "--format", name).out)
        check(info(f"plan.{name}", kind="workflow", format=name).get(counted, 0) > 0, f"{counted} of plan.{name}")
    (folder / "cloud.csv").write_text("x;y;z\n1;2;3\n")
    check(run("slim", "info", "cloud.csv", "--json").json().get("kind") == "cloud", "a cloud in a CSV")
    (folder / "plain.csv").write_text("1,2,3\n4,5,6\n")
    check(run("slim", "info", "plain.csv", "--json").json().get("points") == 2, "a cloud of numbers in a CSV")
    for text in ('"x","y","z"\n1,2,3\n4,5,6\n', "\ufeffx,y,z\n1,2,3\n4,5,6\n"):
        (folder / "named.csv").write_text(text, encoding="utf-8")
        check(run("slim", "info", "named.csv", "--json").json().get("kind") == "cloud", f"a cloud in {text!r}")
    for text in ("a,b\n1,2\n3,4\n\n", "a,b\r\n1,2\r\n3,4\r\n\r\n \r\n", "\ufeffa,b\n1,2\n3,4\n", "a\n1\n2\n\n"):
        (folder / "rows.csv").write_text(text, encoding="utf-8", newline="")
        table = info("rows.csv", kind="table", rows=2)
        check(table.get("columns", [""])[0] == "a", f"columns of {text!r}: {table}")
    for text, row in (("a,b\n1,2\n1\n", "row 2"), ('a,b\n1,"2\n', "row 1")):
        (folder / "ragged.csv").write_text(text)
        result = run("slim", "info", "ragged.csv")
        check(result.code == 3 and row in result.err, f"{text!r}: {result.code} {result.err}")


def short_for_people():
    """Manifests and pictures hold all options: for programs; a person is told what was made of what."""
    manifest = run("slim", "info", "m.slim.done.json").out
    check(len(manifest.splitlines()) < 16 and "t_mdl" not in manifest, f"a manifest: {manifest}")
    for part in ("slim build", "c.ply, c.scans.json", "m.slim\n", "finished", "seconds", "--json"):
        check(part in manifest, f"a manifest does not say {part}: {manifest}")
    for name in ("x.png", "y.exr"):
        picture = run("slim", "info", name).out
        check(len(picture.splitlines()) < 40 and "ortho_width" not in picture, f"{name}: {picture}")
        check("slim:camera" in picture and "--json" in picture, f"{name}: {picture}")
    whole = info("m.slim.done.json", kind="manifest").get("contents", {})
    check("t_mdl" in whole.get("config", "") and whole.get("result", {}).get("leaves", 0) > 0, f"--json: {whole}")
    check("ortho_width" in info("x.png").get("metadata", {}).get("slim:config", ""), "--json of a picture")
    (folder / "edited.done.json").write_text('{"stage": "build", "config_hash": 1, "inputs": [3], "outputs": "x"}')
    check(run("slim", "info", "edited.done.json").code == 0, "an edited manifest")


def unknown():
    """What is of no known kind: what it seems to be, and which kinds there are."""
    (folder / "README.md").write_text("# SLIM\n\nWords.\n")
    (folder / "program").write_bytes(b"\x7fELF\x02\x01\x01\x00")
    for name, seems in (("README.md", "text that begins '# SLIM'"), ("program", "7f 45 4c 46")):
        result = run("slim", "info", name)
        check(result.code == 3 and seems in result.err and ".slim" in result.err and "PLY" in result.err, result.err)
    (folder / "words.txt").write_text("no numbers\n")  # the name is a cloud's
    check("expected numbers" in run("slim", "info", "words.txt").err, "a text that is named as a cloud")
    (folder / "broken.json").write_text('{"a": 1,\n "b": }\n')
    result = run("slim", "info", "broken.json")
    check(result.code == 3 and "broken.json:2: byte 15: expected JSON, found '}'" in result.err, result.err)


def printed_size():
    """One metre of the model: pixels over the width in mm, within the rounding of a whole number."""
    result = run("slim", "render", "m.slim", "--ortho", "--scale-bar", "--unit", "mm", "--size", "640x480", "-o", "o.png",
                 "--json").json()
    per_metre, again, unit = struct.unpack(">IIB", chunk("o.png", b"pHYs") or bytes(9))
    check(unit == 1 and per_metre == again == round(1000 / result["pixel_size"]), f"pHYs {per_metre}: {result['pixel_size']}")
    for name, options in (("p.png", []), ("q.png", ["--ortho"]), ("r.png", ["--ortho", "--unit", "ell"])):
        run("slim", "render", "m.slim", "--size", "64x48", "-o", name, *options)
        check(chunk(name, b"pHYs") is None, f"{name} of an unknown scale has a printed size")
    for i in (1, 2):
        run("slim", "render", "m.slim", "--ortho", "--unit", "mm", "--size", "640x480", "-o", "s.png", "--share", f"{i}/2")
    run("slim", "render", "m.slim", "--ortho", "--unit", "mm", "--size", "640x480", "-o", "s.png", "--join", "2")
    run("slim", "render", "m.slim", "--ortho", "--unit", "mm", "--size", "640x480", "-o", "t.png")
    check((folder / "s.png").read_bytes() == (folder / "t.png").read_bytes(), "shares do not join to the picture")


def drawn_size():
    """Drawings are as large as the model where the picture says how it prints at 1 : 1."""
    def width(*options):
        result = run("slim", "render", "m.slim", "--size", "640x480", "--lines", "contour", "-o", "d.png", "--json", *options)
        svg = (folder / "d.lines.svg").read_text()
        return float(re.search(r'width="([0-9.]+)mm"', svg).group(1)), result.json().get("pixel_size")

    drawn, pixel = width("--ortho", "--unit", "cm")
    check(abs(drawn - 640 * pixel * 10) < 0.01, f"{drawn} mm of 640 pixels of {pixel} cm")
    drawn, pixel = width("--ortho", "--unit", "ell")
    check(abs(drawn - 640 * 25.4 / 96) < 0.01, f"{drawn} mm of an unknown scale")


def false_truths():
    """What is no truth is refused by its row; the cloud's own stays."""
    truth = folder / "c.truth"
    whole = truth.read_bytes()
    check(run("slim", "measure", "m.slim", "c.ply").code == 0, "the scan's own truth")
    random.seed(3)
    cases = {"noise": random.randbytes(len(whole)),
             "curvature": whole[:40 * 7 + 24] + struct.pack("<d", float("nan")) + whole[40 * 7 + 32:],
             "normal": whole[:40 * 7] + struct.pack("<d", 3.0) + whole[40 * 7 + 8:]}
    for name, data in cases.items():
        truth.write_bytes(data)
        result = run("slim", "measure", "m.slim", "c.ply", "--json")
        row = "row 0" if name == "noise" else "row 7"
        message = result.json().get("error", {}).get("message", "")
        check(result.code == 3 and "c.truth" in message and row in message and "found" in message, f"{name}: {result.out}")
        check(run("slim", "info", "c.truth").code == 3, f"{name}: info takes it")
    truth.write_bytes(whole)


def not_a_pipe():
    for words in (("render", "m.slim", "-o", "-"), ("build", "c.ply", "-o", "-")):
        result = run("slim", *words)
        check(result.code == 2 and "standard output" in result.err and not (folder / "-").exists(), f"{words}: {result.err}")


run("slim", "scan", "bumpy", "--points", 6000, "-o", "c.ply")
run("slim", "build", "c.ply", "-o", "m.slim", "--t-mdl", 0.05)
run("slim", "render", "m.slim", "--size", "64x48", "--unit", "mm", "--lines", "contour", "--lines-obj", "x.obj",
    "--lines-ply", "x.ply", "-o", "x.png")
run("slim", "render", "m.slim", "--size", "64x48", "--aov", "mean", "-o", "y.exr")
(folder / "job.toml").write_text("[input]\nfiles = ['c.ply']\n[[view]]\n")
(folder / "page.html").write_text("<html></html>")
head = (folder / "x.ply").read_bytes()[:1000]
check(b"property float scalar_strength\nproperty float quality\n" in head, "lines in space have no quality")
(folder / "small.toml").write_text("""[[experiment]]
name = "rows"
[experiment.grid]
n = [500, 600]
[[experiment.step]]
name = "scan"
run = "scan"
args = "sphere --points {n}"
[experiment.columns]
"points, all" = "scan.points"
"s" = "scan.seconds"
""")
run("slim", "report", "small.toml", "-o", "rep")
run("slim", "slice", "c.ply", "-o", "w", "--slices", 2)
run("slim", "measure", "m.slim", "c.ply", "--per-point", "points.ply", "-o", "measured.json")
kinds()
records()
short_for_people()
unknown()
printed_size()
drawn_size()
false_truths()
not_a_pipe()
harness.end()
