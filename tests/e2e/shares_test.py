#!/usr/bin/env python3
"""Films and large pictures that plans divide: by make, by a sbatch that runs each job at once, and by
Snakemake where it is installed. The bytes of `slim run`, which draws each view in one go; what is drawn again
after which change."""
import os
import shutil
import subprocess

from fake_slurm import FakeSlurm
from harness import Harness

harness = Harness("slim", "slim-scan", "slim-slice", "slim-normals", "slim-fit", "slim-build", "slim-render",
                  "slim-run", "slim-plan")
run, check = harness.run, harness.check
submit = FakeSlurm(harness).submit

JOB = """
[input.scan]
shape = "bumpy"
points = 10000
noise = 0.0002
[fit]
t_mdl = 0.02
degree = 3
[render]
size = "120x90"
PERCENTILE
[[view]]
name = "front"
[[view]]
name = "spin"
turntable = 5
shares = 2
aovs = ["shaded", "mean"]
lines = ["contour"]
[[view]]
name = "path"
path = "front; iso zoom 2"
frames = 4
shares = 3
aovs = ["k1"]
same_range = ["front", "iso"]
[[view]]
name = "wall"
size = "321x333"
camera = "iso"
shares = 3
aovs = ["shaded", "mean"]
lines = ["contour", "crest"]
[output]
dir = "FOLDER"
"""
place = harness.folder / "a job"
place.mkdir()
out = place / "it's all, $HOME"
job = place / "job.toml"


def write_job(percentile=95, folder=out.name):
    job.write_text(JOB.replace("FOLDER", folder).replace("PERCENTILE", f"percentile = {percentile}"))


def contents():
    """What must be the same however it was made: the model, pictures, legends, lines."""
    return {f.name: f.read_bytes() for f in sorted(out.iterdir()) if f.suffix in (".slim", ".png", ".svg", ".ply")}


def plan(form, *options):
    printed = run("slim", "plan", job, "--format", form, *options)
    check(printed.code == 0, f"plan --format {form}: {printed.err}")
    return printed.out


def nothing_left(by):
    again = run("slim", "run", job, "--json", "-q").json()
    redone = [step["name"] for step in again["steps"] if not step["up_to_date"]]
    check(not redone, f"after {by}, slim run does {redone} again")


write_job()
explained = run("slim", "plan", job, "--explain").out
check(explained.count("in plans") == 3 and "in plans 3 tasks and one that joins: shares = 3" in explained,
      f"--explain says of shares: {explained}")
check(run("slim", "run", job, "-q", seconds=300).code == 0, "slim run fails")
whole = contents()
check(len(whole) > 20 and not list(out.glob("*.shares")), f"slim run made {list(whole)}")

# Slurm.
shutil.rmtree(out)
jobs, done = submit(plan("slurm"))
check(done.returncode == 0, f"the script ends with {done.returncode}: {done.stderr[-1500:]}")
check(contents() == whole, "slurm and slim run differ")
check(jobs["slim-render"]["array"] == "0-8", f"views: {jobs['slim-render'].get('array')}")  # 1 + 2 + 3 + 3
check(jobs["slim-join"]["array"] == "0-2", f"joins: {jobs['slim-join'].get('array')}")
check(jobs["slim-join"]["dependency"] == "afterok:" + jobs["slim-render"]["number"],
      f"joins wait for {jobs['slim-join']['dependency']}")
check(jobs["slim-page"]["dependency"].split(":")[-1] == jobs["slim-join"]["number"],
      f"the page waits for {jobs['slim-page']['dependency']}")
nothing_left("slurm")


def make(*options):
    """How often make calls slim-render to draw, a share and to join; and its result."""
    done = subprocess.run(["make", "-C", place, *options], capture_output=True, text=True, timeout=300,
                          env={**os.environ, "SLIM_THREADS": "1"})
    lines = [line for line in done.stdout.splitlines() if "/slim-render'" in line]
    shares, joins = (sum(f"'--{word}=" in line for line in lines) for word in ("share", "join"))
    check(done.returncode == 0, f"make ends with {done.returncode}: {done.stderr[-1500:]}")
    return len(lines) - shares - joins, shares, joins


if not shutil.which("make"):
    print("make is not installed: its file was not run")
else:
    shutil.rmtree(out)
    (place / "Makefile").write_text(plan("make"))
    called = make("-j2")
    check(called == (1, 8, 3), f"make drew {called}")
    check(contents() == whole, "make and slim run differ")
    called = make("-j2")
    check(called == (0, 0, 0), f"a second time make drew {called}")
    nothing_left("make")
    # A picture of a film is drawn with its share, a tiled one put together again.
    (out / "spin.mean_0004.png").unlink()
    called = make("-j2")
    check(called == (0, 1, 1), f"a picture of a film is missing: make drew {called}")
    (out / "wall.mean.png").unlink()
    called = make("-j2")
    check(called == (0, 0, 1), f"a tiled picture is missing: make drew {called}")
    check(contents() == whole, "what was missing came back with other bytes")
    write_job(percentile=90)
    called = make("-j2")
    check(called == (0, 8, 3), f"other ranges: make drew {called}")  # the shaded view takes none
    check(contents() != whole, "other ranges draw the same")
    write_job()
    make("-j2")
    check(contents() == whole, "changed there and back: other bytes")

if not shutil.which("snakemake"):
    print("Snakemake is not installed: its file was not run")
else:
    def snakemake():
        """The rules that it ran."""
        (place / "Snakefile").write_text(plan("snakemake", "--threads", "1"))
        done = subprocess.run(["snakemake", "-s", place / "Snakefile", "--cores", "2", "-d", harness.folder],
                              capture_output=True, text=True, timeout=300, stdin=subprocess.DEVNULL)
        check(done.returncode == 0, f"snakemake ends with {done.returncode}: {done.stderr[-2500:]}")
        return [line.split()[1].rstrip(":") for line in done.stderr.splitlines()
                if line.startswith(("rule ", "localrule "))]

    shutil.rmtree(out)
    ran = snakemake()
    check(sum("_share_" in name for name in ran) == 8, f"snakemake ran {ran}")
    check(contents() == whole, "snakemake and slim run differ")
    check(not snakemake(), "snakemake ran something a second time")
    nothing_left("snakemake")
    (out / "spin.mean_0004.png").unlink()
    ran = sorted(set(snakemake()) - {"all"})
    check(ran == ["page", "render_3", "render_3_share_2"], f"a picture of a film is missing: snakemake ran {ran}")
    check(contents() == whole, "what was missing came back with other bytes")
harness.end()
