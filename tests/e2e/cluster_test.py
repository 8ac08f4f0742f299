#!/usr/bin/env python3
"""`slim plan --format slurm` against a sbatch that runs each job at once, and `--format snakemake` by
Snakemake where it is installed: the bytes of `slim run`, what depends on what, resources, names that need
quoting, resumption."""
import os
import shutil
import subprocess

from fake_slurm import FakeSlurm
from harness import Harness

harness = Harness("slim", "slim-scan", "slim-slice", "slim-normals", "slim-fit", "slim-build", "slim-render",
                  "slim-measure", "slim-run", "slim-plan")
run, check = harness.run, harness.check

JOB = """
[input.scan]
shape = "bumpy"
points = 20000
noise = 0.0002
[fit]
t_mdl = 0.02
slices = 3
memory = "256MiB"
normals = "NORMALS"
[render]
size = "120x90"
[[view]]
camera = "front"
aovs = ["shaded", "mean"]
[[view]]
name = "corner"
camera = "iso"
PERCENTILE
[measure]
[output]
dir = "FOLDER"
aovs = ["k1"]
"""
# A folder whose name needs quoting in every language there is.
place = harness.folder / "a job"
place.mkdir()
out = place / "it's all, %j $HOME"
job = place / "job.toml"

submit = FakeSlurm(harness).submit


def write_job(normals="auto", percentile="", folder=out.name):
    text = JOB.replace("NORMALS", normals).replace("PERCENTILE", percentile)
    job.write_text(text.replace("FOLDER", folder))


def contents():
    """What must be the same however it was made: the model and the pictures."""
    return {f.name: f.read_bytes() for f in sorted(out.iterdir()) if f.suffix in (".slim", ".png", ".ply")}


def plan(form, *options):
    printed = run("slim", "plan", job, "--format", form, *options)
    check(printed.code == 0, f"plan --format {form}: {printed.err}")
    return printed.out


write_job()
check(run("slim", "run", job, "-q", seconds=300).code == 0, "slim run fails")
by_run = contents()
check(len(by_run) == 5, f"slim run made {list(by_run)}")
shutil.rmtree(out)

script = plan("slurm", "--threads", "2", "--memory", "800M")
jobs, done = submit(script, "--partition=short")
check(done.returncode == 0, f"the script ends with {done.returncode}: {done.stderr[-1500:]}")
wanted = ["scan", "slice", "normals", "coarse", "fit", "build", "measure", "render", "page"]
check(sorted(jobs) == sorted(f"slim-{n}" for n in wanted), f"jobs {list(jobs)}")
if not harness.failures:
    check(contents() == by_run, "slurm and slim run differ")
    for name in ("index.html", "measure.json"):
        check((out / name).exists(), f"slurm did not make {name}")
    for name, asked in jobs.items():
        check(asked["mem"] == "800M" and asked["cpus-per-task"] == "2", f"{name} asks for {asked}")
        check(asked["partition"] == "short", f"{name}: the option of sbatch did not get there")
    for name, size in {"normals": 3, "fit": 3, "render": 2}.items():
        check(jobs[f"slim-{name}"].get("array") == f"0-{size - 1}", f"{name}: array {jobs[f'slim-{name}']}")
    for name, others in {"slice": ["scan"], "coarse": ["normals"], "fit": ["coarse"], "build": ["fit"],
                         "render": ["build"], "measure": ["build"],
                         "page": ["build", "measure", "render"]}.items():
        numbers = [jobs[f"slim-{other}"]["number"] for other in others]
        check(jobs[f"slim-{name}"]["dependency"] == ":".join(["afterok", *numbers]),
              f"{name} waits for {jobs[f'slim-{name}'].get('dependency')}, not for {others}")
again = run("slim", "run", job, "--json", "-q").json()
redone = [step["name"] for step in again["steps"] if not step["up_to_date"]]
check(not redone, f"after the script, slim run does {redone} again")

# Without --memory a job asks for more than the points take; what fails stops the script.
script = plan("slurm")
check("--mem=1024M" in script, "a job asks for less than a view takes")
large = plan("slurm", "--set", "fit.memory=2GiB")
check("--mem=2816M" in large, "memory of a job is not that of [fit], a quarter and 256 MiB")
check("--cpus-per-task=4 " in script and script == subprocess.run(
    [harness.bin / "slim", "plan", job, "--format", "slurm"], env={**os.environ, "SLIM_THREADS": "1"},
    capture_output=True, text=True).stdout, "the script depends on the machine that prints it")
(out / "model.slim").unlink()
(out / "model.slim").mkdir()
jobs, done = submit(script)
check("slim-fit" in jobs and "slim-build" not in jobs and "slim-page" not in jobs and done.returncode != 0,
      f"a build that fails: {done.returncode}, {list(jobs)}")
(out / "model.slim").rmdir()

# sbatch takes one way to ask for memory: the reader's.
for option, own in (("--mem-per-cpu=2G", None), ("--mem=3G", "3G"), ("--mem-bind=local", "1024M")):
    jobs, done = submit(script, option)
    check(jobs and all(asked.get("mem") == own for asked in jobs.values()), f"{option}: {jobs} {done.stderr}")

# Estimated normals take their signs from the slice before: one job, in order.
write_job(normals="estimate")
check(run("slim", "run", job, "-q", seconds=300).code == 0, "slim run fails")
estimated = contents()
shutil.rmtree(out)
jobs, done = submit(plan("slurm"))
check(done.returncode == 0, f"estimated normals: {done.stderr[-1500:]}")
check("slim-normals" in jobs and "array" not in jobs["slim-normals"], "estimated normals as an array job")
check(contents() == estimated, "estimated normals: slurm and slim run differ")

refused = run("slim", "plan", job, "--format", "make", "--memory", "1GiB")
check(refused.code == 2 and "--memory" in refused.err, f"make takes --memory in silence: {refused.err}")
write_job(folder="{all}")
refused = run("slim", "plan", job, "--format", "snakemake")
check(refused.code == 2 and "braces" in refused.err, f"snakemake takes a path with braces: {refused.err}")
check(run("slim", "plan", job, "--format", "slurm").code == 0, "slurm refuses a path with braces")
write_job()


def snakemake(*options):
    """The rules that it ran, by name."""
    (place / "Snakefile").write_text(plan("snakemake", "--threads", "1"))
    done = subprocess.run(["snakemake", "-s", place / "Snakefile", "--cores", "2", "-d", harness.folder,
                           *options], capture_output=True, text=True, timeout=300, stdin=subprocess.DEVNULL)
    check(done.returncode == 0, f"snakemake ends with {done.returncode}: {done.stderr[-2500:]}")
    ran = [line.split()[1].rstrip(":") for line in done.stderr.splitlines()
           if line.startswith(("rule ", "checkpoint ", "localrule "))]
    return {name: ran.count(name) for name in ran}


if not shutil.which("snakemake"):
    print("Snakemake is not installed: its file was not run")
    check("checkpoint slice:" in plan("snakemake"), "no checkpoint")
else:
    ALL = {"scan_1": 1, "slice": 1, "normals": 3, "coarse": 1, "fit": 3, "build": 1, "measure_2": 1,
           "render_3": 1, "render_4": 1, "page": 1}
    for normals, bytes_of_run in (("estimate", estimated), ("auto", by_run)):
        shutil.rmtree(out)
        write_job(normals=normals)
        ran = snakemake()
        ran.pop("all", None)
        check(ran == ALL, f"snakemake ran {ran}")
        check(contents() == bytes_of_run, f"normals {normals}: snakemake and slim run differ")
    check(not snakemake(), "snakemake ran something a second time")
    (out / "corner.k1.png").unlink()
    ran = snakemake()
    ran.pop("all", None)
    check(ran == {"render_4": 1, "page": 1}, f"a picture is missing: snakemake ran {ran}")
    job.write_text(job.read_text().replace("[output]", "[output]\ntitle = 'Another'"))
    ran = snakemake()
    ran.pop("all", None)
    check(ran == {"page": 1} and "Another" in (out / "index.html").read_text(), f"another title: snakemake ran {ran}")
    write_job(percentile="percentile = 90")
    ran = snakemake()
    ran.pop("all", None)
    check(ran == {"render_4": 1, "page": 1}, f"one view changed: snakemake ran {ran}")
harness.end()
