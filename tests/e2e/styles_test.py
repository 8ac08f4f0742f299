#!/usr/bin/env python3
"""Every ready style on a scan it does not know, without editing: pictures, legends and a page in a folder of their own; and
what `slim run` and `slim plan` make of clouds on the command line."""
import re

from harness import SOURCE, Harness

harness = Harness("slim", "slim-scan", "slim-build", "slim-render", "slim-measure", "slim-run", "slim-plan")
run, check = harness.run, harness.check

# Style: some of what it must leave in scan_<style>/.
STYLES = {
    "plate": ["front.shaded.png", "bottom.shaded.png"],
    "curvature": ["front.mean.png", "iso.dir1.png", "back.k2.legend.svg", "measure.json"],
    "linework": ["front.lines.svg", "front_crest.lines.png", "reflection.reflection.png"],
    "terrain": ["map.hillshade.png", "map.contours.svg", "air.hillshade.png", "curvature.mean.png"],
    "comparison": ["front.environment.png", "front.matcap.png", "front_lines.lines.svg", "measure.json"],
    "film": ["turn.shaded_0001.png", "turn.mean_0072.png"],
}


def every_style():
    check({path.stem for path in (SOURCE / "configs/styles").glob("*.toml")} == set(STYLES), "styles that no test knows")
    for style, files in STYLES.items():
        result = run("slim", "run", style, "scan.ply", "--set", "render.size=200x160", seconds=200)
        check(result.code == 0, f"{style}: exit {result.code}: {result.err}")
        if style == "linework":  # of creases that a smooth scan has none of
            check("warning" not in result.err, f"linework warns of an ordinary scan: {result.err}")
        for name in [*files, "index.html", "model.slim"]:
            check((harness.folder / f"scan_{style}" / name).exists(), f"{style} leaves no {name}")
        if style == "film":
            check("ffmpeg -framerate 24 -i " in result.out and "turn.mean_%04d.png" in result.out, result.out)
            page = (harness.folder / "scan_film/index.html").read_text()
            check("turn.mean_0001.png" in page and "turn.mean_0002.png" not in page, "the page shows every picture of the film")
        page = (harness.folder / f"scan_{style}/index.html").read_text()
        check("scan.ply; diagonal L = " in page and "render.size=200x160" in page, f"{style}: the page names no scan")
        again = run("slim", "run", style, "scan.ply", "--set", "render.size=200x160", "--json").json()
        redone = [step["name"] for step in again["steps"] if not step["up_to_date"]]
        check(not redone, f"{style}: nothing changed, yet {redone} ran again")


def folders_and_names():
    result = run("slim", "run", "plate", "scan.ply", "-o", "else where", "--set", "render.size=64x64", "--set", "fit.degree=1")
    check(result.code == 0 and (harness.folder / "else where/top.shaded.png").exists(), result.err)
    own = run("slim", "run", "plate", "--print-config")
    styles = harness.bin.parent.parent / "configs" / "styles"
    check(own.code == 0 and own.out == (styles / "plate.toml").read_text(), f"a style's own file: {own.out} {own.err}")
    whole = run("slim", "run", "plate", "scan.ply", "--print-config").out
    check("scan.ply" in whole and "schema_version" in whole, f"a style with a cloud: {whole}")
    for words in (["--print-config", "--set", "fit.degree=1"], ["--print-config", "-o", "x"], []):
        check(run("slim", "run", "plate", *words).code == 2, f"a style without a cloud, {words}")
    wrong = run("slim", "run", "plates", "scan.ply")
    check(wrong.code == 2 and "plate" in wrong.err, wrong.err)
    # Edges are for the build to find: sharp surfels scratch a smooth scan.
    explained = run("slim", "plan", "linework", "scan.ply", "--explain")
    check("--sharp=on" not in explained.out and 'sharp = "auto"' in explained.out, explained.out)
    explained = run("slim", "plan", "plate", "scan.ply", "--explain")
    check("scan_plate/model.slim" in explained.out and "third derivatives" in explained.out, explained.out)
    make = run("slim", "plan", "plate", "scan.ply", "--format", "make")
    check(make.code == 0 and "scan_plate" in make.out, make.err)


def headers_say_what_works():
    """Every change that the head of a style names is taken."""
    n = 0
    for style in STYLES:
        head = (SOURCE / f"configs/styles/{style}.toml").read_text().split("[input]")[0]
        for setting in re.findall(r"--set ('[^']*'|[^\s)]+)", head):
            planned = run("slim", "plan", style, "scan.ply", "--explain", "--set", setting.strip("'"))
            check(planned.code == 0, f"{style}: --set {setting}: {planned.err}")
            n += 1
    check(n >= 7, f"{n} changes in the heads of styles")
    explained = run("slim", "plan", "terrain", "scan.ply", "--explain", "--set", "render.contours=2").out
    check("--contours=2" in explained, explained)


result = run("slim", "scan", "bumpy", "--points", "6000", "-o", "scan.ply")
check(result.code == 0, result.err)
every_style()
folders_and_names()
headers_say_what_works()
harness.end()
