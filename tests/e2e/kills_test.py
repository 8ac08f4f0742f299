#!/usr/bin/env python3
"""A build in slices is killed (SIGKILL) at 50 moments, one in each fiftieth of an undisturbed build's time and random
within it, and run again: the bytes of the undisturbed build, and nothing left over. Then the same, a fifth as often,
with a build of one slice, whose points are in memory alone.

Usage: kills_test.py BIN_FOLDER [KILLS [SEED]]"""
import random
import shutil
import signal
import subprocess
import sys
import time

from harness import Harness

harness = Harness("slim-scan", "slim-build")
n_kills = int(sys.argv[2]) if len(sys.argv) > 2 else 50
rng = random.Random(int(sys.argv[3]) if len(sys.argv) > 3 else 1)
model = harness.folder / "m.slim"
work = harness.folder / "m.slim.work"


def clean():
    shutil.rmtree(work, ignore_errors=True)
    for file in harness.folder.glob("m.slim*"):
        file.unlink()


def killed_after(seconds, arguments):
    """Starts a build and kills it; whether that was before its end."""
    child = subprocess.Popen([str(harness.bin / "slim-build"), *arguments], cwd=harness.folder,
                             stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(seconds)
    child.send_signal(signal.SIGKILL)
    return child.wait() == -signal.SIGKILL


def kill_often(n_kills, *options):
    arguments = ["cloud.ply", "-o", "m.slim", "-q", *options]
    clean()
    start = time.monotonic()
    result = harness.run("slim-build", *arguments, seconds=300)
    whole = time.monotonic() - start
    harness.check(result.code == 0, result.err)
    undisturbed = model.read_bytes()
    n_killed, parts = 0, {}
    for i in range(n_kills):
        clean()
        moment = whole * (i + rng.random()) / n_kills
        killed = killed_after(moment, arguments)
        n_killed += killed
        harness.check(not killed or not model.exists() or model.read_bytes() == undisturbed,
                      f"killed after {moment:.3f} s: a model that is not whole")
        there = sum(1 for _ in work.glob("**/*.done.json"))
        parts[there] = parts.get(there, 0) + 1
        result = harness.run("slim-build", *arguments, seconds=300)
        harness.check(result.code == 0, f"after a kill at {moment:.3f} s: {result.err}")
        harness.check(model.exists() and model.read_bytes() == undisturbed,
                      f"killed after {moment:.3f} s of {whole:.3f}: other bytes")
        left = sorted(f.name for f in harness.folder.iterdir() if f.name.startswith("m.slim"))
        harness.check(left == ["m.slim", "m.slim.done.json"], f"killed after {moment:.3f} s, left over: {left}")
    print(f"{n_kills} builds of {whole:.2f} s, {n_killed} killed before their end; finished parts that they left, and "
          "how often:", dict(sorted(parts.items())))
    harness.check(n_killed >= 0.8 * n_kills, "most builds ended before they were killed")


result = harness.run("slim-scan", "sculpture", "--points", "300000", "-o", "cloud.ply", "-q", seconds=120)
harness.check(result.code == 0, result.err)
kill_often(n_kills, "--slices", "5")
kill_often(max(1, n_kills // 5))
harness.end()
