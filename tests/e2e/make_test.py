#!/usr/bin/env python3
"""`slim plan --format make`, driven by real make: what is made again after which change, slices side by
side, resumption after kill -9, and the bytes of `slim run`."""
import os
import shutil
import signal
import subprocess
import sys
import time

from harness import Harness

harness = Harness("slim", "slim-scan", "slim-slice", "slim-normals", "slim-fit", "slim-build", "slim-render",
                  "slim-measure", "slim-run", "slim-plan")
run, check = harness.run, harness.check
if not shutil.which("make"):
    print("skipped: make is not installed")
    sys.exit(77)

JOB = """
[input.scan]
shape = "bumpy"
points = POINTS
noise = 0.0002
[fit]
t_mdl = T_MDL
slices = 3
normals = "NORMALS"
[render]
size = "240x180"
[[view]]
camera = "front"
aovs = ["shaded", "mean"]
[[view]]
name = "corner"
camera = "iso"
percentile = PERCENTILE
[measure]
[output]
dir = "out, all"
aovs = ["k1"]
"""
# A folder whose name needs quoting, here and there in other ways.
place = harness.folder / "a job (50%): x=1"
place.mkdir()
out = place / "out, all"
STEPS = ("scan", "slice", "normals", "fit", "build", "measure", "render", "run")


def write_job(points=20000, t_mdl=0.02, normals="auto", percentile=95, name="job.toml"):
    text = JOB.replace("POINTS", str(points)).replace("T_MDL", str(t_mdl))
    (place / name).write_text(text.replace("NORMALS", normals).replace("PERCENTILE", str(percentile)))


def make(*options, folder=harness.folder):
    """Runs make from elsewhere; how often it called each of our programs, and its result."""
    done = subprocess.run(["make", "-C", place, *options], cwd=folder, capture_output=True, text=True,
                          timeout=300)
    lines = [line for line in done.stdout.splitlines() if line.startswith("'")]
    return {step: n for step in STEPS if (n := sum(f"/slim-{step}'" in line for line in lines))}, done


def expect(counts, what, *options, samples=0):
    """samples: of the whole cloud, which slices whose normals are estimated share."""
    called, done = make(*options)
    check(done.returncode == 0, f"{what}: make ends with {done.returncode}: {done.stderr[-1500:]}")
    check(called == counts, f"{what}: expected {counts}, make called {called}")
    # The build joins what the slices' rules made, and does none of it again.
    for stage in ("slice", "normals", "fit"):
        found = done.stderr.count(f"slim-build: {stage}: up to date")
        wanted = ALL[stage] + (samples if stage == "normals" else 0) if "build" in counts else 0
        check(found == wanted, f"{what}: the build found {found} of {wanted} {stage} up to date")


def wait_for_end(group):
    """What make had called may still be ending, at work on a busy disk, and hold the folder's lock."""
    for _ in range(1000):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return
        time.sleep(0.01)


def contents():
    """What must be the same however it was made: the model and the pictures."""
    return {f.name: f.read_bytes() for f in sorted(out.iterdir()) if f.suffix in (".slim", ".png", ".ply")}


write_job()
printed = run("slim", "plan", place / "job.toml", "--format", "make")
check(printed.code == 0, printed.err)
(place / "Makefile").write_text(printed.out)
ALL = {"scan": 1, "slice": 1, "normals": 3, "fit": 4, "build": 1, "measure": 1, "render": 2, "run": 1}
expect(ALL, "the first time", "-j2")
expect({}, "a second time")
check(make("-q")[1].returncode == 0, "make -q says that something is to be done")
made = contents()
check(len(made) == 5, f"made {list(made)}")
for name in ("index.html", "measure.json"):
    check((out / name).exists(), f"make did not make {name}")

again = run("slim", "run", place / "job.toml", "--json", "-q").json()
redone = [step["name"] for step in again["steps"] if not step["up_to_date"]]
check(not redone, f"after make, slim run does {redone} again")
expect({}, "after slim run")

# Another view: this view and the page; another t_mdl: all that follows from the fit. make notices itself.
write_job(percentile=90)
expect({"render": 1, "run": 1}, "one view changed")
write_job(percentile=90, t_mdl=0.03)
expect({"fit": 4, "build": 1, "measure": 1, "render": 2, "run": 1}, "t_mdl changed", "-j2")
write_job(percentile=90, t_mdl=0.03, normals="estimate")
expect({key: n for key, n in ALL.items() if key not in ("scan", "slice")}, "normals changed", "-j2", samples=1)
write_job()
expect({key: n for key, n in ALL.items() if key not in ("scan", "slice")}, "all changed back", "-j2")
check(contents() == made, "changed there and back: other bytes")

# What is missing is made again, and only that.
(out / "corner.k1.png").unlink()
expect({"render": 1, "run": 1}, "a picture removed")
check(contents() == made, "the picture that was removed came back with other bytes")

# The same bytes as slim run, which cuts into the same slices in one go.
shutil.rmtree(out)
check(run("slim", "run", place / "job.toml", "-q", seconds=300).code == 0, "slim run fails")
check(contents() == made, "make and slim run differ")

# kill -9 at several moments, then make goes on: the bytes of an undisturbed one.
write_job(points=60000)
shutil.rmtree(out)
expect(ALL, "a larger job", "-j2")
undisturbed = contents()
shutil.rmtree(out)
for wait in (0.05, 0.2, 0.4, 0.6, 0.9):
    child = subprocess.Popen(["make", "-j2", "-C", place], stdout=subprocess.DEVNULL,
                             stderr=subprocess.DEVNULL, start_new_session=True)
    time.sleep(wait)
    os.killpg(child.pid, signal.SIGKILL)
    child.wait()
    wait_for_end(child.pid)
called, done = make("-j2")
check(done.returncode == 0, f"after kill -9: {done.stderr[-1500:]}")
check(contents() == undisturbed, "after kill -9: other bytes")
expect({}, "after a resumed make")

# A job that is wrong by now stops make with its line.
write_job()
(place / "job.toml").write_text((place / "job.toml").read_text().replace("camera", "camra", 1))
called, done = make()
check(done.returncode != 0 and "job.toml:" in done.stderr and "camera" in done.stderr, done.stderr)
check(not called, f"a wrong job: make called {called}")
# What make cannot name is refused.
for name in ("a|b", "a;b", "a\\b"):
    (harness.folder / name).mkdir()
    (harness.folder / name / "job.toml").write_text((place / "job.toml").read_text().replace("camra", "camera"))
    refused = run("slim", "plan", f"{name}/job.toml", "--format", "make")
    check(refused.code == 2 and "a Makefile cannot name a path with" in refused.err, f"{name}: {refused.code} {refused.err}")
harness.end()
