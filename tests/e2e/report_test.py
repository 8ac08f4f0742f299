#!/usr/bin/env python3
"""slim report: the page is whole and fetches nothing, a second run does nothing, bands that are left fail by name, the
rest goes on where a step fails; and the quick report of configs/report passes. In Chromium if it is installed."""
import html.parser
import json
import re
import shutil
import subprocess
import time

from harness import SOURCE, Harness

SMALL = """
title = "Small & <plain>"
[values]
points = 3000
[[experiment]]
name = "sweep"
title = "A sweep"
[experiment.grid]
degree = [1, 2]
t = [0.1, 0.01]
[[experiment.step]]
name = "cloud"
run = "scan"
args = "sphere --points {points} --pattern uniform --seed {seed}"
[[experiment.step]]
name = "fit"
run = "build"
args = "{cloud} --degree {degree} --t-mdl {t}"
[[experiment.step]]
name = "m"
run = "measure"
args = "{fit} {cloud}"
[[experiment.step]]
name = "view"
run = "render"
args = "{fit} --size 60x50 --no-legend"
when = "t == 0.01"
[experiment.columns]
"leaves" = "m.leaves"
"L2 / L" = "m.l2"
"text" = "if(degree == 1, 'a,b', 'c')"
[[experiment.plot]]
title = "leaves over T"
x = "t"
y = "m.leaves"
series = "degree {degree}"
theory = "-2/(degree+2)"
most_slope = "0.1"
[[experiment.picture]]
of = "view"
caption = "degree {degree}"
[[experiment.check]]
name = "L2 of the sphere"
value = "m.l2"
most = "MOST"
[[experiment]]
name = "case"
row = "7"
expected = "exit 3"
found = "exit {b.exit}"
pass = "b.exit == 3"
[[experiment.step]]
name = "nothing"
run = "text"
text = "# no points\\n"
[[experiment.step]]
name = "b"
run = "build"
args = "{nothing}"
exit = [3]
"""


class Page(html.parser.HTMLParser):
    """Every address that a browser would load or follow; counts of elements; the text."""

    def __init__(self, text):
        super().__init__()
        self.addresses, self.tags, self.text = [], {}, ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags[tag] = self.tags.get(tag, 0) + 1
        self.addresses += [v for k, v in attributes if k in ("src", "href", "data", "srcset", "action", "xlink:href")]
        self.addresses += re.findall(r"url\(([^)]*)\)", " ".join(v or "" for _, v in attributes))

    def handle_data(self, data):
        self.text += data


h = Harness("slim-report", "slim-scan", "slim-build", "slim-measure", "slim-render", "slim-smooth", "slim-info")


def report(name, text, folder, *more, **options):
    file = h.folder / f"{name}.toml"
    file.write_text(text)
    return h.run("slim-report", file, "-o", folder, "--json", "--threads", "1", *more, **options)


def check_nothing_outside(text, what):
    page = Page(text)
    outside = [a for a in page.addresses if not a.startswith(("data:", "#"))]
    h.check(not outside, f"{what}: addresses outside the page: {outside[:3]}")
    h.check("@import" not in text and "script" not in page.tags, f"{what}: has scripts or imports")
    return page


def test_page():
    done = report("small", SMALL.replace("MOST", "0.1"), "out")
    if not h.check(done.code == 0, f"small report ends with {done.code}: {done.err[-500:]}"):
        return
    said = done.json()
    h.check(said["steps_run"] == 13 and said["steps_reused"] == 3, f"a step that rows share is run once: {said}")
    h.check(said["failed"] == 0 and said["passed"] == 7, f"4 checks, 2 slopes and a case: {said}")
    text = (h.folder / "out/index.html").read_text()
    page = check_nothing_outside(text, "small report")
    h.check(page.tags.get("svg") == 1 and page.tags.get("img") == 2, f"one plot, two pictures: {page.tags}")
    h.check("Small & <plain>" in page.text, "the title is shown as it is")
    h.check(all(word in page.text for word in ("-0.50", "-0.67", "exit 3", "leaves over T")), "slopes of theory, the case")
    lines = (h.folder / "out/small.sweep.csv").read_text().splitlines()
    h.check(lines[0] == "degree,t,leaves,L2 / L,text" and len(lines) == 5, f"the CSV: {lines[:2]}")
    h.check(lines[1].endswith('"a,b"'), "a comma in a cell is quoted")
    data = json.loads((h.folder / "out/report.json").read_text())
    h.check(data["files"][0]["experiments"][0]["plots"][0]["curves"][1]["theory"] == -0.5, "theory in the JSON")
    h.check({"version", "machine", "seed", "configurations"} <= set(data["provenance"]), "where it comes from")
    in_chromium(h.folder / "out/index.html", plots=1, pictures=2)


def test_resume():
    before = {f: f.read_bytes() for f in (h.folder / "out").glob("*.*") if f.suffix != ".json" or f.name == "report.json"}
    stamps = {f: f.stat().st_mtime_ns for f in (h.folder / "out/steps").iterdir()}
    said = report("small", SMALL.replace("MOST", "0.1"), "out").json()
    h.check(said["steps_run"] == 0 and said["steps_reused"] == 16, f"a second run does nothing: {said}")
    h.check(stamps == {f: f.stat().st_mtime_ns for f in (h.folder / "out/steps").iterdir()}, "no step's file is touched")
    h.check(all(f.read_bytes() == data for f, data in before.items()), "page, CSV and JSON are the same bytes")
    model = next((h.folder / "out/steps").glob("fit-*.slim"))
    model.unlink()
    said = report("small", SMALL.replace("MOST", "0.1"), "out").json()
    h.check(said["steps_run"] == 1, f"a lost output is made again, alone: {said}")
    said = report("small", SMALL.replace("MOST", "0.1"), "out", "--set", "values.points=2000").json()
    h.check(said["steps_run"] == 11, f"another number of points makes what depends on it: {said}")
    one = h.folder / "stopped"
    child = subprocess.Popen([h.bin / "slim-report", h.folder / "small.toml", "-o", one, "--threads", "1"],
                             stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    for _ in range(600):
        if len(list(one.glob("steps/*.step.json"))) >= 3:
            break
        time.sleep(0.02)
    child.terminate()
    h.check(child.wait(20) == 143, "SIGTERM ends it with 143")
    said = report("small", SMALL.replace("MOST", "0.1"), "stopped").json()
    h.check(said["steps_reused"] >= 5 and said["steps_run"] <= 11, f"what was done before the stop counts: {said}")


def test_stale():
    """What decides a step's figures or verdict and is not in its words."""
    tools = h.folder / "tools"
    tools.mkdir()
    for verb in ("scan", "build", "measure", "report"):
        shutil.copy(h.bin / f"slim-{verb}", tools)
    file = h.folder / "stale.toml"
    text = """
[[experiment]]
name = "e"
[[experiment.step]]
name = "c"
run = "scan"
args = "sphere --points 500"
[[experiment.step]]
name = "b"
run = "build"
args = "{c}"
[[experiment.step]]
name = "m"
run = "measure"
args = "{b} {c} --truth=%s" """ % (h.folder / "own.truth")
    file.write_text(text)
    h.run("slim-scan", "sphere", "--points", "500", "-o", "own.ply")

    def again():
        done = subprocess.run([tools / "slim-report", file, "-o", h.folder / "stale", "--json", "--threads", "1"],
                              capture_output=True, text=True)
        if not h.check(done.stdout.startswith("{"), f"says what it did: {done.stderr[-300:]}"):
            return None, done.returncode
        return json.loads(done.stdout).get("steps_run"), done.returncode

    h.check(again() == (3, 0) and again() == (0, 0), "three steps, then none")
    truth = bytearray((h.folder / "own.truth").read_bytes())
    truth[24:32] = bytes(8)
    (h.folder / "own.truth").write_bytes(truth)
    h.check(again() == (1, 0), "a file named within a word, --truth=FILE, counts by its bytes")
    with open(tools / "slim-measure", "ab") as program:
        program.write(b"\0")
    h.check(again() == (1, 0), "another program of the same version is run")
    file.write_text(text + "\nexit = [3]\n")
    h.check(again()[1] == 5, "a step that was done as expected is not, once another code is")


def test_bands():
    done = report("small", SMALL.replace("MOST", "1e-9"), "out")
    h.check(done.code == 5, f"a band that is left ends with 5, not {done.code}")
    h.check("L2 of the sphere (degree 1, t 0.1): found" in done.err, f"the figure is named: {done.err[-300:]}")
    h.check("figures left their bands" in done.err and "failed:" not in done.err, f"no step failed: {done.err[-400:]}")
    page = Page((h.folder / "out/index.html").read_text())
    h.check("4 FAILED" in page.text, "the page counts what failed")
    known = SMALL.replace("MOST", "1e-9").replace('name = "L2 of the sphere"', 'name = "L2"\nknown = "too strict"')
    done = report("small", known, "out")
    h.check(done.code == 0 and done.json()["known_failures"] == 4, "a failure that is known does not end with 5")
    slope = SMALL.replace("MOST", "1").replace('most_slope = "0.1"', 'most_slope = "-3"')
    done = report("small", slope, "out")
    h.check(done.code == 5 and "slope of leaves over T (degree 1)" in done.err, "the band of a slope counts")
    case = SMALL.replace("MOST", "1").replace('pass = "b.exit == 3"', 'pass = "b.exit == 0"')
    done = report("small", case, "out")
    h.check(done.code == 5 and "case 7: found exit 3, expected exit 3: not so: b.exit == 0" in done.err, done.err[-300:])


def test_failures():
    text = SMALL.replace("MOST", "1").replace("--t-mdl {t}", "--t-mdl {if(t == 0.1, -1, t)}")
    done = report("fails", text, "fails")
    h.check(done.code == 5 and "step fit (degree 1, t 0.1): ended with 2" in done.err, done.err[-400:])
    lines = (h.folder / "fails/fails.sweep.csv").read_text().splitlines()
    h.check(lines[1].startswith("1,0.1,,,") and lines[2].count(",,") == 0, f"the other rows have their figures: {lines}")
    text = SMALL.replace("MOST", "1") + """
[[experiment]]
name = "peer"
row = "8"
expected = "anything"
found = "{p.exit}"
pass = "p.exit == 0"
[[experiment.step]]
name = "p"
run = "command"
program = "no_such_program_here"
"""
    done = report("peer", text, "peer")
    h.check(done.code == 0 and done.json()["not_run"] == 1, "a program that is missing is nobody's failure")
    h.check("no_such_program_here is not installed" in (h.folder / "peer/index.html").read_text(), "and is said")
    for change, expected in ((('run = "scan"', 'run = "scam"'), "scan"), (('x = "t"', 'x = "t +"'), "small.toml:"),
                             (("[experiment.grid]", "[experiment.gird]"), "'grid'"), (('of = "view"', 'of = "vew"'), "no step 'vew'"),
                             (('x = "t"', 'x = "tt"'), "unknown name 'tt'")):
        done = report("small", SMALL.replace("MOST", "1").replace(*change, 1), "wrong")
        h.check(done.code == 2 and expected in done.err, f"{change[1]}: {done.code} {done.err[-200:]}")
    done = report("small", SMALL.replace("MOST", "1"), "wrong", "--set", "values.pionts=5")
    h.check(done.code == 2 and "did you mean 'points'?" in done.err, f"a value that no file has: {done.err[-300:]}")


def test_wrong_column():
    text = SMALL.replace("MOST", "0.1").replace('"leaves" = "m.leaves"', '"leaves" = "m.leeves"')
    wrong = report("column", text, "column")
    message = wrong.json().get("error", {}).get("message", "")
    h.check(wrong.code == 2 and "column.toml:" in message and "'leeves'" in message and "'leaves'" in message,
            f"a column that names no result ends with {wrong.code}: {message}")


JOB = """
[input.scan]
shape = "bumpy"
points = 3000
[fit]
degree = DEGREE
t_mdl = 0.05
[render]
size = "60x50"
legend = false
[[view]]
camera = "front"
[output]
dir = "elsewhere"
"""


def test_jobs():
    """Ordinary jobs are rows: what `slim run` makes of them, in the report's folder, measured."""
    for name, degree in (("plain", 1), ("curved", 2)):
        (h.folder / f"{name}.toml").write_text(JOB.replace("DEGREE", str(degree)))
    command = ("slim-report", "plain.toml", "curved.toml", "-o", "jobs", "--json", "--threads", "1")
    done = h.run(*command)
    if not h.check(done.code == 0, f"a report of jobs ends with {done.code}: {done.err[-500:]}"):
        return
    h.check(done.json()["steps_run"] == 8 and done.json()["failed"] == 0, f"two jobs of four steps: {done.json()}")
    rows = [line.split(",") for line in (h.folder / "jobs/jobs.rows.csv").read_text().replace('"normals, deg"', "angle")
            .replace('"slice, s"', "slice").replace('"normals, s"', "normals").replace('"fit, s"', "fit")
            .replace('"tree, s"', "tree").replace('"build, s"', "build").replace('"front, ms a frame"', "frame").splitlines()]
    table = [dict(zip(rows[0], row)) for row in rows[1:]]
    h.check([row["job"] for row in table] == ["plain", "curved"], f"a row for each job: {rows}")
    for row in table:
        h.check(float(row["points"]) > 2000 and float(row["leaves"]) > 10 and float(row["bytes"]) > 1000, f"a model: {row}")
        h.check(0 < float(row["L2 / L"]) < float(row["max / L"]) and 0 < float(row["completeness"]) <= 1, f"errors: {row}")
        h.check(all(float(row[key]) > 0 for key in ("fit", "build", "points / s", "frame")), f"times: {row}")
    h.check(float(table[1]["leaves"]) < float(table[0]["leaves"]), "quadrics need fewer leaves than planes")
    measured = json.loads((h.folder / "jobs/jobs/plain/measure.json").read_text())
    h.check(float(table[0]["L2 / L"]) == measured["l2"], f"L2 is what slim measure says: {table[0]['L2 / L']}")
    page = check_nothing_outside((h.folder / "jobs/index.html").read_text(), "report of jobs")
    h.check(page.tags.get("svg") == 2 and page.tags.get("img") == 2, f"two plots, two pictures: {page.tags}")
    h.check(not (h.folder / "elsewhere").exists(), "a report writes into its own folder")
    table_before, page_before = ((h.folder / "jobs" / f).read_text() for f in ("jobs.rows.csv", "report.json"))
    run = table[0]["timed in the run of"]
    h.check(run.startswith("20") and run == table[1]["timed in the run of"], f"fresh steps are of this run: {run}")
    manifest = json.loads((h.folder / "jobs/jobs/plain/model.slim.done.json").read_text())
    h.check(float(table[0]["build"]) == manifest["seconds"], f"seconds are the manifest's: {table[0]['build']}")
    time.sleep(1.1)  # runs are told apart by the second
    again = h.run(*command).json()
    table_after, page_after = ((h.folder / "jobs" / f).read_text() for f in ("jobs.rows.csv", "report.json"))
    h.check(table_after == table_before and page_after == page_before, "steps that are reused have other times")
    h.check(again["steps_run"] == 0 and again["steps_reused"] == 8, f"nothing changed, yet {again['steps_run']} steps run")
    changed = h.run(*command, "--set", "fit.t_mdl=0.1").json()
    h.check(changed["steps_run"] == 6, f"another T_MDL: build, measure and view of both: {changed}")
    runs = json.loads((h.folder / "jobs/report.json").read_text())["runs"]
    h.check(len(runs) == 2 and runs[run] == 2, f"the scans are of the first run: {runs}")
    wrong = h.run(*command, "--set", "fit.tmdl=0.1")
    h.check(wrong.code == 2 and "'t_mdl'" in wrong.err, f"an unknown key of jobs: {wrong.err}")
    (h.folder / "broken.toml").write_text(JOB.replace("DEGREE", "2").replace("points = 3000", "points = 1"))
    broken = h.run("slim-report", "broken.toml", "plain.toml", "-o", "jobs", "--json", "--threads", "1")
    message = broken.json()["error"]["message"]
    h.check(broken.code == 5 and "broken" in message, f"a job that fails: {broken.out}")
    h.check("1 step failed: " in message and "bands" not in message, f"it has no figures: {message}")
    h.check("plain" in (h.folder / "jobs/jobs.rows.csv").read_text(), "the other job goes on")


def test_cap():
    text = SMALL.replace("MOST", "1").replace("t = [0.1, 0.01]", "t = [0.01]\npoints = [1000, 2000, 50000000]")
    done = report("cap", text, "cap", "--cap", "2000")
    lines = (h.folder / "cap/cap.sweep.csv").read_text().splitlines()
    h.check(done.code == 0 and len(lines) == 5, f"rows above the cap are left out: {done.err[-200:]} {lines}")
    text = text.replace('title = "A sweep"', 'title = "A sweep"\nwhen = "points < 1500"')
    done = report("cap", text, "cap")
    lines = (h.folder / "cap/cap.sweep.csv").read_text().splitlines()
    h.check(done.code == 0 and len(lines) == 3, f"rows that `when` does not mean are left out: {done.err[-200:]} {lines}")


def test_earlier_times():
    text = SMALL.replace("MOST", "1").replace('"text" =', '"fit, s" = "fit.seconds"\n"text" =')
    report("times", text, "times")
    time.sleep(1.1)  # runs are told apart by the second
    report("times", text.replace("t = [0.1, 0.01]", "t = [0.1, 0.01, 0.05]"), "times")
    lines = (h.folder / "times/times.sweep.csv").read_text().splitlines()
    runs = [line.split(",")[-1] for line in lines[1:]]
    h.check(lines[0].endswith(",timed in the run of") and runs[0] == runs[1] < runs[2], f"runs of the rows: {lines}")
    page = (h.folder / "times/index.html").read_text()
    h.check(page.count("&dagger;</span></td>") == 4, "times of the earlier run are marked, of four rows")


PROBE = """<script>addEventListener('load', () => { const p = [...document.querySelectorAll('svg.plot')].filter(s =>
 s.querySelectorAll('g.curve path').length && s.getBoundingClientRect().width > 100).length;
 const i = [...document.images].filter(x => x.complete && x.naturalWidth > 0).length;
 const f = performance.getEntriesByType('resource').map(e => e.name).filter(n => !n.startsWith('data:'));
 document.title = 'probe ' + JSON.stringify({plots: p, pictures: i, fetched: f}); });</script></body>"""


def in_chromium(page, plots, pictures):
    chromium = shutil.which("chromium")
    if not chromium:
        print("skipped: the page in a browser (Debian package chromium is not installed)")
        return
    probed = h.folder / "probed.html"
    probed.write_text(page.read_text().replace("</body>", PROBE))
    command = [chromium, "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking",
               f"--user-data-dir={h.folder / 'chromium'}", "--virtual-time-budget=10000", "--dump-dom", probed.as_uri()]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    except subprocess.TimeoutExpired:
        h.check(False, "chromium does not end")
        return
    found = re.search(r"<title>probe (.*?)</title>", done.stdout)
    if h.check(found, f"chromium shows the page: {done.stderr[-300:]}"):
        said = json.loads(found.group(1))
        h.check(said == {"plots": plots, "pictures": pictures, "fetched": []}, f"in chromium: {said}")


def test_quick():
    start = time.monotonic()
    done = h.run("slim-report", SOURCE / "configs/report/quick.toml", "-o", "quick", "--json", seconds=600)
    if not h.check(done.code == 0, f"the quick report ends with {done.code}: {done.err[-1500:]}"):
        return
    said = done.json()
    print(f"quick report: {said['steps_run']} steps in {time.monotonic() - start:.0f} s, {said['passed']} figures in their bands")
    h.check(said["known_failures"] == 0 and said["not_run"] == 0, f"all of it is run: {said}")
    page = check_nothing_outside((h.folder / "quick/index.html").read_text(), "quick report")
    in_chromium(h.folder / "quick/index.html", plots=page.tags["svg"], pictures=page.tags["img"])


test_page()
test_resume()
test_stale()
test_bands()
test_failures()
test_wrong_column()
test_jobs()
test_cap()
test_earlier_times()
test_quick()
h.end()
