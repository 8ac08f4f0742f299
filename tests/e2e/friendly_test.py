#!/usr/bin/env python3
"""What a newcomer gets wrong: each mistake is named with the command that is right."""
import signal
import subprocess
import time

from harness import Harness

harness = Harness("slim", "slim-scan", "slim-build", "slim-render", "slim-measure", "slim-info", "slim-run")
run, check = harness.run, harness.check


def refused(code, parts, *command):
    result = run(*command)
    told = f"{' '.join(map(str, command))}: exit {result.code}: {result.err.strip()[-600:]}"
    check(result.code == code, f"expected exit {code}; {told}")
    for part in parts:
        check(part in result.err, f"expected '{part}'; {told}")


def build_says_little():
    check(run("slim", "scan", "torus", "-o", "t.ply", "--points", "5000", "-q").code == 0, "scan fails")
    built = run("slim", "build", "t.ply", "-o", "t.slim")
    check(built.code == 0, built.err)
    lines = built.out.splitlines()
    check(len(lines) <= 8, f"build prints {len(lines)} lines: {built.out}")
    for part in ("t.slim: 5000 points", " leaves", "fit error", "of each leaf alone", "fit ",
                 "next: slim render t.slim -o t.png", "(l2: RMS distance"):
        check(part in built.out, f"build does not say '{part}': {built.out}")
    again = run("slim", "build", "t.ply", "-o", "t.slim")
    check(again.out == built.out and "up to date" in again.err, f"up to date: {again.out} {again.err}")
    check("point_visits" in run("slim", "build", "t.ply", "-o", "t.slim", "-v").out, "-v hides the counters")
    check("point_visits" in run("slim", "build", "t.ply", "-o", "t.slim", "--json").out, "--json hides them")


def wrong_files():
    refused(2, ["slim measure t.slim t.ply"], "slim", "measure", "t.ply", "t.slim")
    refused(3, ["slim build t.ply -o t.slim"], "slim", "render", "t.ply", "-o", "x.png")
    refused(3, ["slim build t.ply -o t.slim"], "slim", "measure", "t.ply", "t.ply")
    (harness.folder / "comma.xyz").write_text("1,5 2,0 3,1\n1,5 2,5 3,5\n")
    refused(3, ["comma.xyz: line 1", "decimal commas"], "slim", "build", "comma.xyz", "-o", "x.slim")
    (harness.folder / "hill.las").write_bytes(b"LASF" + b"\1" * 400)
    refused(3, ["pdal translate hill.las hill.ply"], "slim", "build", "hill.las", "-o", "x.slim")
    refused(2, ["is a folder"], "slim", "info", ".")
    refused(3, ["is a folder"], "slim", "render", ".", "-o", "x.png")


def two_builds_at_once():
    check(run("slim", "scan", "sculpture", "-o", "big.ply", "--points", "400000", "-q").code == 0, "scan fails")
    first = subprocess.Popen([harness.bin / "slim-build", "big.ply", "-o", "big.slim"], cwd=harness.folder,
                             stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    for _ in range(500):
        time.sleep(0.005)
        if (harness.folder / "big.slim.work").exists():
            break
    refused(75, ["big.slim.work", "another slim"], "slim", "build", "big.ply", "-o", "big.slim")
    first.kill()
    first.wait()
    work = harness.folder / "big.slim.work"
    check(work.exists(), "the second build removed the first one's folder")
    # After kill -9 nothing is locked any more. A build in slices goes on where it was, one of a slice begins again.
    for slices, is_sliced, stopped in (("1", "plan.json", ""), ("2", "slice.done.json", "goes on where it was, from big.slim.work")):
        arguments = ["big.ply", "-o", "big.slim", "--slices", slices]
        second = subprocess.Popen([harness.bin / "slim-build", *arguments], cwd=harness.folder,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        for _ in range(2000):
            time.sleep(0.005)
            if (work / is_sliced).exists():
                break
        second.send_signal(signal.SIGTERM)
        told = second.communicate(timeout=60)[1].decode()
        check(second.returncode == 143 and stopped in told and work.exists() == bool(stopped),
              f"SIGTERM with {slices} slices: {second.returncode}: {told}")
        third = run("slim", "build", *arguments, seconds=120)
        check(third.code == 0 and not work.exists(), f"the third build with {slices} slices: {third.err}")


def jobs():
    job = harness.folder / "job.toml"
    text = "[input]\nfiles = ['t.ply']\n[[view]]\ncamera = 'front'\n[[view]]\ncamera = 'iso'\nsize = '64'\n"
    job.write_text(text)
    refused(2, ["job.toml:7: size"], "slim", "run", "job.toml")
    check(not (harness.folder / "out").exists(), "a wrong view was seen after the build")
    job.write_text(text.replace("'64'", "'64x64'"))
    changed = run("slim", "run", "job.toml", "--set", "fit.t_mdl=0.05", "--json")
    check(changed.code == 0, changed.err)
    leaves = changed.json()["steps"][0]["result"]["leaves"]
    plain = run("slim", "run", "job.toml", "--json")
    check(plain.json()["steps"][0]["result"]["leaves"] > leaves, "--set fit.t_mdl=0.05 changes no leaves")
    check("of no view of this job" not in plain.err, plain.err)
    refused(2, ["TABLE.KEY"], "slim", "run", "job.toml", "--set", "t_mdl=0.05")
    job.write_text(text[:text.rindex("[[view]]")])
    fewer = run("slim", "run", "job.toml")
    check("iso.shaded.png" in fewer.err and "of no view of this job" in fewer.err, f"a removed view: {fewer.err}")


build_says_little()
wrong_files()
two_builds_at_once()
jobs()
harness.end()
