#!/usr/bin/env python3
"""Folders for outputs that are missing: made by every verb, and gone again if it fails. How failures are told."""
import resource
import subprocess

from harness import Harness

harness = Harness("slim", "slim-scan", "slim-build", "slim-slice", "slim-normals", "slim-render", "slim-smooth",
                  "slim-measure", "slim-run", "slim-report")
run, check = harness.run, harness.check
new = harness.folder / "new"

check(run("slim", "scan", "sphere", "-o", "new/deep/s.ply", "--points", "3000", "-q").code == 0, "scan")
cloud = "new/deep/s.ply"
check(run("slim", "build", cloud, "-o", "m.slim", "-q").code == 0, "build")
(harness.folder / "bad.ply").write_text("ply\nno header\n")
JOB = "[input]\nfiles = ['CLOUD']\n[[view]]\ncamera = 'front'\n[output]\ndir = 'runs/deep'\n"
for name, file in (("good.toml", cloud), ("bad.toml", "bad.ply")):
    (harness.folder / name).write_text(JOB.replace("CLOUD", file))

for output, arguments in (("made/b/m.slim", ("build", cloud)), ("made/r/p.png", ("render", "m.slim", "--size", "64x64")),
                          ("made/s/s.ply", ("smooth", "m.slim", cloud)), ("made/w/work", ("slice", cloud)),
                          ("made/m/d.json", ("measure", "m.slim", cloud))):
    result = run("slim", *arguments, "-o", output, "-q")
    check(result.code == 0 and (harness.folder / output).exists(), f"{arguments} -o {output}: {result.code} {result.err}")
check(run("slim", "run", "good.toml", "-q").code == 0 and (harness.folder / "runs/deep/model.slim").exists(), "run")

# A job's own output is not told as an option that nobody gave.
(harness.folder / "taken.toml").write_text(JOB.replace("CLOUD", cloud).replace("runs/deep", "taken"))
(harness.folder / "taken/model.slim").mkdir(parents=True)
taken = run("slim", "run", "taken.toml", "-q")
check(taken.code == 2 and "taken/model.slim: is a folder: expected a file" in taken.err and "-o" not in taken.err and
      "--output" not in taken.err, f"a folder where the model is to be: {taken.code} {taken.err}")
told = run("slim", "build", cloud, "-o", "taken/model.slim", "-q")
check(told.code == 2 and "-o taken/model.slim: is a folder: expected a file" in told.err, f"its option: {told.err}")

before = sorted(harness.folder.glob("*"))
for code, arguments in (
        (3, ("build", "bad.ply", "-o", "gone/deep/m.slim")),
        (3, ("build", "missing.ply", "-o", "gone/deep/m.slim", "--force")),
        (3, ("build", "bad.ply", "-o", "gone/deep/m.slim", "--work", "gone/work")),
        (3, ("slice", "bad.ply", "-o", "gone/deep/work")),
        (3, ("smooth", "m.slim", "bad.ply", "-o", "gone/deep/s.ply")),
        (3, ("measure", "m.slim", "bad.ply", "-o", "gone/deep/d.json")),
        (5, ("render", "m.slim", "-o", "gone/deep/p.png", "--size", "64x64", "--camera", "100,0,0,200,0,0,0,0,1")),
        (3, ("render", "missing.slim", "-o", "gone/deep/p.png")),
        (3, ("run", "bad.toml", "-o", "gone/deep")),
        (2, ("render", ".", "-o", "gone/p.png")),
        (2, ("slice", cloud, "-o", "gone/work", "--memory", "1KiB"))):
    result = run("slim", *arguments, "-q")
    check(result.code == code, f"{arguments}: exit {result.code}, expected {code}: {result.err}")
    left = sorted(set(harness.folder.glob("*")) - set(before))
    check(not left, f"{arguments}: left {left}")

# Out of memory: which file, and what to do.
result = run("slim-build", cloud, "-o", "oom.slim", "-q", "--memory", "64MiB", memory=40 << 20)
if run("slim-build", "--version", memory=40 << 20).code == 0:  # a sanitizer's build needs more for itself
    check(result.code in (0, 4), f"out of memory: {result.code} {result.err}")
if result.code == 4:
    check(cloud in result.err and "a smaller --memory than 64MiB" in result.err, result.err)
# A full disk, as a limit on file sizes is: what is sliced stays, and the same command goes on.
command = [harness.bin / "slim-build", cloud, "-o", "full.slim", "--slices", "20", "--t-mdl", "0.00001"]
limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (16000, 16000))
full = subprocess.run(command, cwd=harness.folder, capture_output=True, text=True, preexec_fn=limit)
check(full.returncode == 4 and "the same command goes on where it was, from full.slim.work, which stays" in full.stderr,
      f"a full disk: {full.returncode} {full.stderr}")
full = subprocess.run(command, cwd=harness.folder, capture_output=True, text=True)
check(full.returncode == 0 and "slice: up to date" in full.stderr and not (harness.folder / "full.slim.work").exists(),
      f"after a full disk: {full.returncode} {full.stderr}")

result = run("slim", "build", cloud, "-o", "n.slim", "--json")
said = result.json()
check(said["dropped"] == 0 and said["dropped_isolated"] == said["stages"]["fit"]["dropped_isolated"], str(said)[:200])
harness.end()
