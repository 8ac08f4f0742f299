#!/usr/bin/env python3
"""Feature lines from a scan to files: against the truth of analytic shapes, and what options promise."""
import math
import re
import xml.etree.ElementTree as ElementTree

from harness import Harness

harness = Harness("slim", "slim-scan", "slim-build", "slim-render", "slim-run")
run, check = harness.run, harness.check
SIZE = ("--size", "400x400")


def build(shape, degree, points=40000):
    model = f"{shape}{degree}.slim"
    if not (harness.folder / f"{shape}.ply").exists():
        run("slim", "scan", shape, "-o", f"{shape}.ply", "--points", points)
    done = run("slim", "build", f"{shape}.ply", "-o", model, "--degree", degree, "--t-mdl", 0.003)
    check(done.code == 0, f"build {shape}: {done.err}")
    return model


def lines_of(model, *options):
    size = () if "--size" in options else SIZE
    done = run("slim", "render", model, "-o", "x.png", *size, "--json", *options)
    check(done.code == 0, f"render {model} {options}: {done.err}")
    return done.json()["lines"]


def shapes():
    torus = build("torus", 3)
    for camera in ("top", "iso"):
        found = lines_of(torus, "--up", "z", "--camera", camera, "--lines", "crest,parabolic,contour")
        for kind in ("ridge", "valley"):
            check(found[kind]["polylines"] == 0, f"torus, {camera}: false crest lines {found}")
    top = lines_of(torus, "--up", "z", "--camera", "top", "--lines", "parabolic")["parabolic"]["length"]
    check(abs(top / (2 * math.pi) - 1) < 0.03, f"parabolic circle of the torus: {top}")
    cyclide = lines_of(build("cyclide", 3), "--up", "z", "--camera", "iso", "--lines", "crest")
    for kind in ("ridge", "valley"):
        check(cyclide[kind]["polylines"] == 0, f"cyclide: false crest lines {cyclide}")
    # x 1, y 0.7, z 0.4: the sharpest section is z = 0, seen along x as a straight line.
    ellipsoid = lines_of(build("ellipsoid", 3), "--up", "z", "--camera", "right", "--ortho", "--lines",
                         "crest,suggestive,parabolic")
    check(2.0 < ellipsoid["ridge"]["length"] < 2.75, f"ridge of the ellipsoid: {ellipsoid}")
    check(ellipsoid["valley"]["polylines"] == 0, f"valleys of the ellipsoid: {ellipsoid}")
    sphere = lines_of(build("sphere", 3), "--lines", "contour,suggestive,crest,parabolic")
    check([kind for kind in sphere if sphere[kind]["polylines"]] == ["contour"], f"sphere: {sphere}")


def false_parabolics():
    """Where K is 0 all over, its zeros are noise; a torus with as much keeps its circle whole."""
    for shape, true_length in (("cylinder", 0), ("plane", 0), ("sphere", 0), ("torus", 2 * math.pi)):
        run("slim", "scan", shape, "-o", f"{shape}_n.ply", "--points", 100000, "--noise", 0.0005)
        done = run("slim", "build", f"{shape}_n.ply", "-o", f"{shape}_n.slim", "--degree", 3)
        check(done.code == 0, f"build {shape}_n: {done.err}")
        for camera, size in (("top", 500), ("iso", 500), ("iso", 1500)):
            found = lines_of(f"{shape}_n.slim", "--up", "z", "--camera", camera, "--size", f"{size}x{size}", "--lines",
                             "contour,parabolic")["parabolic"]
            if camera == "top" or true_length == 0:
                check(abs(found["length"] - true_length) <= 0.08 * true_length, f"{shape}, {camera}, {size}: {found}")
            if true_length > 0:
                check(found["polylines"] == 1, f"{shape}, {camera}, {size}: {found}")


def false_crests():
    """Torus and cyclide have no crest lines at any size, nor nearer by, nor with noise that stays below 0.05 %."""
    for shape, noise in (("torus", 0), ("torus", 0.0005), ("cyclide", 0), ("cyclide", 0.0003)):
        name = f"{shape}_{noise}"
        run("slim", "scan", shape, "-o", f"{name}.ply", "--points", 100000, "--noise", noise)
        done = run("slim", "build", f"{name}.ply", "-o", f"{name}.slim", "--degree", 3)
        check(done.code == 0, f"build {name}: {done.err}")
        for camera, size, zoom in (("top", 400, 1), ("top", 1600, 1), ("iso", 1600, 1), ("iso", 600, 4), ("top", 3000, 1)):
            found = lines_of(f"{name}.slim", "--up", "z", "--camera", camera, "--size", f"{size}x{size}", "--zoom", zoom,
                             "--lines", "crest")
            for kind in ("ridge", "valley"):
                check(found[kind]["length"] == 0, f"{name}, {camera}, {size} pixels, zoom {zoom}: false {kind}s {found}")


def crests_at_any_size():
    """The same ridge of the ellipsoid in small and large pictures."""
    model = build("ellipsoid", 3)
    for size in (400, 1600, 3000):
        found = lines_of(model, "--up", "z", "--camera", "right", "--ortho", "--size", f"{size}x{size}", "--lines", "crest")
        check(1.9 < found["ridge"]["length"] < 2.75, f"ridge of the ellipsoid in {size} pixels: {found}")
        check(found["valley"]["length"] == 0, f"valleys of the ellipsoid in {size} pixels: {found}")


def files():
    sculpture = build("sculpture", 3)
    done = run("slim", "render", sculpture, "-o", "s.exr", *SIZE, "--up", "z", "--aov", "shaded,lines", "--lines",
               "contour,suggestive,crest", "--lines-ply", "s.ply", "--lines-obj", "s.obj", "--json")
    check(done.code == 0, f"files: {done.err}")
    result = done.json()
    for name in ("s.lines.svg", "s.ply", "s.obj", "s.exr"):
        check(name in result["files"] and (harness.folder / name).exists(), f"{name}: {result['files']}")
    n_lines = sum(kind["polylines"] for kind in result["lines"].values())
    check(n_lines > 10, f"sculpture: {result['lines']}")
    svg = ElementTree.parse(harness.folder / "s.lines.svg").getroot()
    check(svg.get("width", "").endswith("mm"), f"svg width {svg.get('width')}")
    groups = {g.get("id"): len(g) for g in svg if g.tag.endswith("g")}
    check(set(groups) == {"contour", "suggestive", "crest-ridge", "crest-valley"}, f"groups {groups}")
    check(sum(groups.values()) == n_lines, f"{groups} but {n_lines} lines")
    obj = (harness.folder / "s.obj").read_text()
    check(len(re.findall(r"^l ", obj, re.M)) == n_lines, "lines in the OBJ")
    head = (harness.folder / "s.ply").read_bytes().split(b"end_header\n")[0].decode()
    n_vertices = int(re.search(r"element vertex (\d+)", head)[1])
    check(len(re.findall(r"^v ", obj, re.M)) == n_vertices and "element edge" in head, "vertices")
    # Bytes for any number of threads.
    before = {name: (harness.folder / name).read_bytes() for name in ("s.lines.svg", "s.ply", "s.png")}
    run("slim", "render", sculpture, "-o", "s.exr", *SIZE, "--up", "z", "--aov", "shaded,lines", "--lines",
        "contour,suggestive,crest", "--lines-ply", "s.ply", "--lines-obj", "s.obj", "--threads", 1, "--force")
    for name, data in before.items():
        check((harness.folder / name).read_bytes() == data, f"{name} depends on threads")
    again = run("slim", "render", sculpture, "-o", "s.exr", *SIZE, "--up", "z", "--aov", "shaded,lines", "--lines",
                "contour,suggestive,crest", "--lines-ply", "t.ply")
    check(again.code == 0 and (harness.folder / "t.ply").exists(), "another --lines-ply is not up to date")


def edges():
    """A cube, and the edge of two planes at 100 to 150 degrees: from points to creases."""
    def cloud(name, points):
        (harness.folder / name).write_text("".join(" ".join(f"{v:.9g}" for v in p) + "\n" for p in points))

    grid = [(i + 0.5) / 20 - 1 for i in range(40)]
    points = []
    for axis in range(3):
        for sign in (-1, 1):
            for u in grid:
                for v in grid:
                    p, n = [0, 0, 0], [0, 0, 0]
                    p[axis] = n[axis] = sign
                    p[(axis + 1) % 3], p[(axis + 2) % 3] = u, v
                    points.append(p + n)
    cloud("cube.xyz", points)
    done = run("slim", "build", "cube.xyz", "-o", "cube.slim", "--sharp", "on")
    check(done.code == 0, f"cube: {done.err}")
    # Along (2, 1, 1.5) three faces are seen, nine edges; one of axis a looks as long as its part across the view.
    eye, width, pixels = (2, 1, 1.5), 4, 400
    unit = [x / math.hypot(*eye) for x in eye]
    seen = sum(3 * 2 * math.sqrt(1 - x * x) for x in unit) * pixels / width
    found = lines_of("cube.slim", "--lines", "crease", "--ortho-width", width, "--camera",
                     ",".join(str(x) for x in (*eye, 0, 0, 0, 0, 0, 1)))
    convex = found["convex_crease"]
    check(convex["polylines"] == 9 and abs(convex["length_px"] - seen) < 9 * 2, f"cube, {seen} pixels: {found}")
    check(abs(convex["strength"] - 90) < 0.2 and found["concave_crease"]["polylines"] == 0, f"cube: {found}")
    for degrees in (100, 120, 140, 150):
        half = math.radians(degrees / 2)
        points = []
        for side in (-1, 1):
            for u in grid:
                for v in grid:
                    t = 0.5 * (1 + v)
                    points.append((side * t * math.sin(half), u, -t * math.cos(half),
                                   side * math.cos(half), 0, math.sin(half)))
        cloud("roof.xyz", points)
        done = run("slim", "build", "roof.xyz", "-o", "roof.slim", "--sharp", "on", "--force")
        check(done.code == 0, f"roof of {degrees}: {done.err}")
        found = lines_of("roof.slim", "--lines", "crease,contour", "--ortho-width", width, "--camera",
                         "0,0,5,0,0,0,0,1,0", "--force")
        if degrees == 150:  # an edge, but too blunt for a line
            check(found["convex_crease"]["polylines"] == 0, f"roof of {degrees}: {found}")
            continue
        convex = found["convex_crease"]
        # The surface goes on a little beyond its last points, and the edge with it.
        check(convex["polylines"] == 1 and 195 < convex["length_px"] < 260, f"roof of {degrees}: {found}")
        check(abs(convex["strength"] - (180 - degrees)) < 0.2, f"roof of {degrees}: {found}")


def options():
    quadratic = build("sphere", 2)
    wrong = run("slim", "render", quadratic, "-o", "x.png", *SIZE, "--lines", "crest")
    check(wrong.code == 2 and "--degree 3" in wrong.err, f"crest of quadrics: {wrong.err}")
    both = run("slim", "render", quadratic, "-o", "x.png", *SIZE, "--lines", "crest,contour", "--json")
    check(both.code == 0 and set(both.json()["lines"]) == {"contour"} and "--degree 3" in both.err,
          f"crest and contour of quadrics: {both.err}")
    wrong = run("slim", "render", quadratic, "-o", "x.png", *SIZE, "--lines", "crease")
    check(wrong.code == 2 and "--sharp on" in wrong.err, f"creases of a smooth model: {wrong.err}")
    both = run("slim", "render", quadratic, "-o", "x.png", *SIZE, "--lines", "crease,contour", "--json", "--force")
    check(both.code == 0 and set(both.json()["lines"]) == {"contour"} and "--sharp on" in both.err,
          f"crease and contour of a smooth model: {both.err}")
    for option, name in (("--lines-ply", "x.png"), ("--lines-obj", "x.ply"), ("--lines-ply", "x.slim")):
        wrong = run("slim", "render", quadratic, "-o", "x.png", "--lines", "contour", option, name)
        check(wrong.code == 2 and "expected a name ending in" in wrong.err, f"{option} {name}: {wrong.err}")
    wrong = run("slim", "render", quadratic, "-o", "x.png", "--lines-ply", "x.ply")
    check(wrong.code == 2 and "--lines" in wrong.err, f"--lines-ply alone: {wrong.err}")
    wrong = run("slim", "render", quadratic, "-o", "x.png", "--lines", "crests")
    check(wrong.code == 2 and "crest" in wrong.err, f"--lines crests: {wrong.err}")
    plain = run("slim", "render", quadratic, "-o", "y.png", *SIZE, "--json").json()
    check("lines" not in plain and not (harness.folder / "y.lines.svg").exists(), "lines unasked")
    bare = run("slim", "render", quadratic, "-o", "z.png", *SIZE, "--aov", "lines", "--json").json()
    check(set(bare["lines"]) == {"contour", "suggestive"}, f"--aov lines alone: {bare}")


def brute():
    model = build("torus", 2)
    view = ("--up", "z", "--camera", "iso", "--lod", 0, "--lines", "contour,parabolic,suggestive,reflection")
    fast, slow = lines_of(model, *view), lines_of(model, *view, "--mode", "brute")
    for kind in slow:
        a, b = fast[kind]["length"], slow[kind]["length"]
        check(abs(a - b) <= 0.02 * b, f"{kind}: forward {a}, brute {b}")


def job():
    (harness.folder / "job.toml").write_text("""
[input.scan]
shape = "bumpy"
points = 20000
[fit]
degree = 3
[render]
size = "200x200"
lines = ["contour", "crest"]
[[view]]
name = "front"
aovs = ["shaded", "lines"]
lines_obj = "lines.obj"
[[view]]
name = "iso"
camera = "iso"
lines = ["suggestive"]
[output]
dir = "out"
""")
    done = run("slim", "run", "job.toml")
    check(done.code == 0, f"run: {done.err}")
    out = harness.folder / "out"
    for name in ("front.shaded.png", "front.lines.png", "front.lines.svg", "iso.lines.svg"):
        check((out / name).exists(), f"job: no {name}")
    check((harness.folder / "lines.obj").exists(), "job: no lines.obj")
    check('id="suggestive"' in (out / "iso.lines.svg").read_text(), "the view's own lines win")
    check('href="front.lines.svg"' in (out / "index.html").read_text(), "page without the drawing")
    flat = run("slim", "run", "job.toml", "--set", "fit.degree=2")
    check(flat.code == 0 and "crest lines need" in flat.err and "degree = 3 in [fit]" in flat.err and
          "--degree" not in flat.err, f"a job is told of its keys: {flat.err}")


shapes()
false_parabolics()
false_crests()
crests_at_any_size()
files()
edges()
options()
brute()
job()
harness.end()
