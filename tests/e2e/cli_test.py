#!/usr/bin/env python3
"""The contract of every verb: help, configuration, errors, exit codes, signals, broken outputs."""
import json
import os
import resource
import signal
import subprocess
import time

from harness import SOURCE, Harness

VERBS = ["scan", "slice", "normals", "fit", "tree", "build", "render", "smooth", "measure", "info", "run", "plan", "report"]
harness = Harness("slim", *(f"slim-{verb}" for verb in VERBS))
run, check = harness.run, harness.check


def every_verb():
    overview = run("slim", "--help").out
    for verb in VERBS:
        check(f"  {verb} " in overview, f"slim --help does not list {verb}")
        help_text = run("slim", verb, "--help")
        check(help_text.code == 0, f"{verb} --help: exit {help_text.code}")
        for part in ("Usage: slim " + verb, "Examples:", "--threads", "--json"):
            check(part in help_text.out, f"{verb} --help lacks '{part}'")
        check(run(f"slim-{verb}", "--version").out.startswith(f"slim-{verb} "), f"{verb} --version")

        wrong = run(f"slim-{verb}", "--theads", "2")
        check(wrong.code == 2 and "'--threads'" in wrong.err and not wrong.out,
              f"{verb} --theads: exit {wrong.code}: {wrong.err}")
        wrong = run(f"slim-{verb}", "--theads", "2", "--json")
        error = wrong.json()["error"]
        check(error["code"] == 2 and error["option"] == "--theads", f"{verb}: error object {wrong.out}")
        missing = run(f"slim-{verb}")
        check(missing.code == 2 and "missing" in missing.err, f"{verb} alone: {missing.err}")

        printed = run(f"slim-{verb}", "--print-config").out
        file = SOURCE / "configs" / f"{verb}.toml"
        kept = "".join(line for line in file.read_text().splitlines(keepends=True)[2:])
        check(kept == printed, f"{file} is not what slim-{verb} --print-config says; run "
                               "scripts/write_configs")
        again = run(f"slim-{verb}", "--config", file, "--print-config")
        check(again.code == 0, f"{file}: {again.err}")


def front_door():
    wrong = run("slim", "biuld")
    check(wrong.code == 2 and "'build'" in wrong.err, f"slim biuld: {wrong.err}")
    for words, expected in ((("biuld", "--json"), "'build'"), (("--json",), "no verb"), (("--jsno", "--json"), "'--jsno'")):
        wrong = run("slim", *words)
        check(wrong.code == 2 and wrong.json()["error"]["code"] == 2 and
              expected in wrong.json()["error"]["message"], f"slim {words}: {wrong.out}")
    alone = run("slim")
    check(alone.code == 2 and not alone.out and "Usage: slim VERB" in alone.err, f"slim alone: {alone.err[:99]}")
    check(run("slim", "help", "build").out == run("slim", "build", "--help").out, "slim help build")
    check("'build'" in run("slim", "help", "biuld").err, "slim help biuld")
    for words in (["--help"], ["--version"], ["build", "--version"], ["help", "build"]):
        with open("/dev/full", "w") as full:
            result = run("slim", *words, stdout=full)
        check(result.code == 4 and "cannot write" in result.err, f"slim {words} >/dev/full: {result.code}")
    check(run("slim", "--version").code == 0, "slim --version")


def config_file():
    file = harness.folder / "c.toml"
    file.write_text("points = 1000\n\nstatoins = 3\n")
    wrong = run("slim-scan", "sphere", "-o", "x.ply", "--config", file)
    check(wrong.code == 2 and "c.toml:3" in wrong.err and "'stations'" in wrong.err, wrong.err)
    file.write_text("points = 1000\nstations = 3\n")
    good = run("slim-scan", "sphere", "-o", "x.ply", "--config", file, "--set", "points=1100", "--json")
    check(good.code == 0 and good.json()["points"] == 1100, f"--set after --config: {good.err}")
    wrong = run("slim-scan", "shpere", "-o", "x.ply")
    check(wrong.code == 2 and "'sphere'" in wrong.err, wrong.err)


def outputs():
    missing = run("slim-info", "nowhere.ply", "--json")
    check(missing.code == 3 and "nowhere.ply" in missing.json()["error"]["message"], missing.err)
    missing = run("slim", "build", "nope", "-o", "a.slim", "--json")
    check(missing.code == 3 and missing.json()["error"]["file"] == "nope", f"slim build nope: {missing.out}")
    run("slim-scan", "sphere", "-o", "./-x.ply", "--points", "1000")  # what follows -- is a file
    dashed = run("slim", "info", "--json", "--", "-x.ply")
    check(dashed.code == 0 and dashed.json()["points"] == 1000, f"slim info -- -x.ply: {dashed.err}")
    wrong = run("slim-scan", "sphere", "-o", "/proc/x.ply", "--points", "1000")
    check(wrong.code in (2, 3, 4) and "x.ply" in wrong.err, f"/proc/x.ply: {wrong.code} {wrong.err}")
    with open("/dev/full", "w") as full:
        wrong = run("slim-info", "x.ply", stdout=full)
        check(wrong.code == 4 and "standard output" in wrong.err, f"full disk: {wrong.code} {wrong.err}")
    reader, writer = os.pipe()
    os.close(reader)
    wrong = run("slim-info", "x.ply", stdout=writer)
    check(wrong.code == 141 and not wrong.err.strip(), f"broken pipe: {wrong.code} {wrong.err}")


def file_size_limit():
    command = [harness.bin / "slim-scan", "sphere", "-o", "large.ply", "--points", "100000"]
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100000, 100000))
    done = subprocess.run(command, cwd=harness.folder, capture_output=True, text=True, preexec_fn=limit)
    check(done.returncode == 4 and "ulimit" in done.stderr, f"file size limit: {done.returncode} {done.stderr}")
    check(not list(harness.folder.glob("large*")), "a write over the limit left a file")


def up_to_date():
    first = run("slim-scan", "torus", "-o", "t.ply", "--points", "2000", "--json").json()
    check("up_to_date" not in first, "a first run is not up to date")
    before = (harness.folder / "t.ply").stat().st_mtime_ns
    second = run("slim-scan", "torus", "-o", "t.ply", "--points", "2000", "--threads", "1", "--json").json()
    check(second.get("up_to_date") is True, f"the second run: {second}")
    check((harness.folder / "t.ply").stat().st_mtime_ns == before, "the file was written again")
    for change in (["--seed", "5"], ["--force"]):
        third = run("slim-scan", "torus", "-o", "t.ply", "--points", "2000", "--json", *change).json()
        check("up_to_date" not in third, f"{change} was ignored")
    manifest = json.loads((harness.folder / "t.ply.done.json").read_text())
    check(manifest["outputs"][0]["path"] == "t.ply", "the manifest names its output beside it")


def signals():
    for number, code, said in ((signal.SIGTERM, 143, "terminated"), (signal.SIGINT, 130, "interrupted"),
                               (signal.SIGHUP, 143, "terminated"), (signal.SIGXCPU, 4, "ulimit -t")):
        folder = harness.folder / f"signal_{number}"
        child = subprocess.Popen([harness.bin / "slim-scan", "sculpture", "-o", folder / "x.ply",
                                  "--points", "50000000"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        for _ in range(200):
            time.sleep(0.05)
            if folder.exists() and any(folder.iterdir()):
                break
        child.send_signal(number)
        _, err = child.communicate(timeout=30)
        check(child.returncode == code and said in err.decode(), f"signal {number}: exit {child.returncode}: {err.decode()}")
        check(not folder.exists(), f"signal {number} left {folder}")


def ignored_signals():
    """What is ignored, by nohup or the shell, stays ignored."""
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM, signal.SIGXCPU):
        model = harness.folder / f"ignored_{number}.ply"
        child = subprocess.Popen([harness.bin / "slim-scan", "sculpture", "-o", model, "--points", "400000", "-q"],
                                 preexec_fn=lambda: signal.signal(number, signal.SIG_IGN))
        time.sleep(0.1)
        check(child.poll() is None, "the scan ended before the signal")
        child.send_signal(number)
        check(child.wait(60) == 0 and model.exists(), f"signal {number}, ignored, ends a run: {child.returncode}")


def stopped_and_continued():
    """The grace time of a run that was asked to end is not over because it was stopped (ctrl-Z) and went on."""
    os.mkfifo(harness.folder / "config.fifo")  # nobody writes: it waits, and notices no signal
    child = subprocess.Popen([harness.bin / "slim-scan", "sphere", "-o", "fifo.ply", "--config", "config.fifo"],
                             cwd=harness.folder, stderr=subprocess.PIPE, text=True)
    time.sleep(0.3)
    start = time.monotonic()
    for number in (signal.SIGTERM, signal.SIGSTOP, signal.SIGCONT):
        child.send_signal(number)
        time.sleep(0.2)
    _, err = child.communicate(timeout=30)
    seconds = time.monotonic() - start
    check(child.returncode == 143 and seconds > 2.5, f"exit {child.returncode} after {seconds:.1f} s: {err}")
    check("no half-written file is left" in err, f"after the grace time: {err}")


def no_room_for_a_thread():
    limit = lambda: resource.setrlimit(resource.RLIMIT_STACK, (1 << 47, resource.RLIM_INFINITY))
    done = subprocess.run([harness.bin / "slim-build", "--version"], capture_output=True, text=True, preexec_fn=limit)
    check(done.returncode == 4 and "thread" in done.stderr, f"no room for a thread: {done.returncode} {done.stderr}")


def processor_time_limit():
    command = [harness.bin / "slim-scan", "sculpture", "-o", "long.ply", "--points", "50000000", "-q"]
    for limits in ((1, 60), (1, 1), (2, 2)):  # soft and hard: at a hard one the system kills
        limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, limits)
        done = subprocess.run(command, cwd=harness.folder, capture_output=True, text=True, preexec_fn=limit)
        check(done.returncode == 4 and "ulimit -t" in done.stderr,
              f"limit of time {limits}: {done.returncode} {done.stderr}")
        check(not list(harness.folder.glob("long*")), f"a run over the limit of time {limits} left a file")


every_verb()
front_door()
config_file()
outputs()
file_size_limit()
up_to_date()
signals()
ignored_signals()
stopped_and_continued()
no_room_for_a_thread()
processor_time_limit()
harness.end()
