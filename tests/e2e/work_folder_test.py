#!/usr/bin/env python3
"""What lies at `<output>.work` and `<output>.work.done`: a build removes what a build made, and nothing else."""
import fcntl
import os
import pathlib
import shutil
import signal
import subprocess
import time

from harness import Harness

harness = Harness("slim", "slim-scan", "slim-build", "slim-slice", "slim-run")
run, check = harness.run, harness.check
work = harness.folder / "a.slim.work"
done = harness.folder / "a.slim.work.done"
elsewhere = harness.folder / "elsewhere"


def clean():
    for path in harness.folder.iterdir():
        if path.name in ("s.ply", "s.ply.done.json", "s.scans.json", "s.truth", "big.ply"):
            continue
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()


def build(*options, cloud="s.ply"):
    return run("slim", "build", cloud, "-o", "a.slim", "-q", *options)


def photos(folder):
    (folder / "photos").mkdir(parents=True)
    (folder / "photos" / "x.jpg").write_text("p")


def has_photos(folder):
    return (folder / "photos" / "x.jpg").exists()


def others_files():
    """A folder of someone else is refused, with what to do, and stays as it is, whatever the input."""
    for options, cloud, code in (((), "s.ply", 2), (("--force",), "s.ply", 2), (("--force",), "missing.ply", 2),
                                 ((), "missing.ply", 2), ((), "bad.ply", 2)):
        clean()
        (harness.folder / "bad.ply").write_text("ply\nno header\n")
        photos(work)
        result = build(*options, cloud=cloud)
        check(result.code == code, f"{options} {cloud}: exit {result.code}, expected {code}: {result.err}")
        check(has_photos(work), f"{options} {cloud}: someone's files are gone")
        if code == 2:
            check("a.slim.work" in result.err and "--work DIR" in result.err, result.err)
            check(os.listdir(work) == ["photos"], f"left in it: {os.listdir(work)}")
    # A file of that name that is no plan of slices.
    clean()
    work.mkdir()
    (work / "plan.json").write_text('{"version": 1, "slices": ["of bread"]}')
    check(build().code == 2 and "bread" in (work / "plan.json").read_text(), "another program's plan.json")
    # With --work elsewhere it does not matter.
    check(build("--work", "w").code == 0 and (work / "plan.json").exists(), "--work elsewhere")
    clean()
    photos(done)
    check(build().code == 0 and has_photos(done) and not work.exists(), "someone's folder a.slim.work.done")
    check(build().code == 0 and has_photos(done), "someone's folder a.slim.work.done, up to date")


def named_folders():
    """One that --work or slim slice named is used and kept, also after a build that was killed in it."""
    clean()
    check(build("--work", "a.slim.work").code == 0, "--work")
    result = run("slim", "build", "s.ply", "-o", "a.slim", "--t-mdl", "0.02")
    check(result.code == 0 and "slice: up to date" in result.err, f"a kept folder is not used: {result.err}")
    check((work / "slice_0000/points.slice").exists(), "a kept folder is gone")
    check(build("--force").code == 0 and (work / "slice_0000/surfels.fit").exists(), "--force removes a kept folder")
    check(build("--face-points", "off", "--strict").code == 0, "other options of slicing")
    check(run("slim", "normals", "a.slim.work", "-q").code == 0, "the kept folder is no whole one any more")
    check(run("slim", "fit", "a.slim.work", "-q").code == 0 and work.exists(), "fit in a kept folder")
    clean()
    check(run("slim", "slice", "s.ply", "-o", "a.slim.work", "--slices", "2", "-q").code == 0, "slice")
    check(build("--slices", "2").code == 0 and (work / "plan.json").exists(), "what slim slice made is gone")
    check(build(cloud="missing.ply").code == 3 and (work / "plan.json").exists(), "a missing input removes slices")
    # A killed build's folder that is named afterwards is its namer's.
    clean()
    work.mkdir()
    (work / "made_by_slim_build").touch()
    check(run("slim", "slice", "s.ply", "-o", "a.slim.work", "-q").code == 0, "slice")
    check(build().code == 0 and work.exists(), "a marked folder that slim slice took over is gone")
    (harness.folder / "a.slim").unlink()
    (work / "made_by_slim_build").touch()
    check(build("--work", "a.slim.work").code == 0 and work.exists(), "--work of a marked folder")
    check(build("--t-mdl", "0.02").code == 0 and work.exists(), "a marked folder that --work took over is gone")


def empty_folders_and_links():
    clean()
    work.mkdir()
    check(build().code == 0 and not work.exists(), "what a build leaves that is killed before its mark stays for good")
    work.mkdir()
    check(build("--force", cloud="missing.ply").code == 3 and not work.exists(), "an empty folder and a missing input")
    work.mkdir()
    check(build("--work", "a.slim.work").code == 0 and (work / "plan.json").exists(), "an empty folder of --work")
    clean()
    elsewhere.mkdir()
    work.symlink_to("elsewhere")
    check(build("--slices", "2").code == 0, "a link to an empty folder")
    check(work.is_symlink() and os.listdir(elsewhere) == [], f"a link: {os.listdir(elsewhere)}")
    photos(elsewhere)
    check(build("--force").code == 2 and work.is_symlink() and has_photos(elsewhere), "a link to someone's folder")
    clean()
    photos(elsewhere)
    (elsewhere / "made_by_slim_build").touch()
    done.symlink_to("elsewhere")
    check(build().code == 0 and done.is_symlink() and has_photos(elsewhere), "a link a.slim.work.done")
    clean()
    work.symlink_to("nowhere")
    check(build().code == 2 and work.is_symlink(), "a link to nothing")
    clean()
    # Someone's files within a build's own folder: only its own go.
    photos(work)
    (work / "made_by_slim_build").touch()
    result = build()
    check(result.code == 0 and has_photos(work) and "a.slim.work" in result.err, f"files in a build's own: {result.err}")
    check(os.listdir(work) == ["photos"], f"left beside them: {os.listdir(work)}")


def stopped():
    """SIGINT: someone's folder stays, a build's own goes or is gone on with."""
    clean()
    photos(work)
    child = subprocess.Popen([harness.bin / "slim-build", "big.ply", "-o", "a.slim", "-q"], cwd=harness.folder,
                             stderr=subprocess.DEVNULL)
    time.sleep(0.05)
    child.send_signal(signal.SIGINT)
    check(child.wait(30) in (2, 130) and has_photos(work), "SIGINT removes someone's folder")
    shutil.rmtree(work)
    arguments = ["big.ply", "-o", "a.slim", "-q", "--slices", "2"]
    child = subprocess.Popen([harness.bin / "slim-build", *arguments], cwd=harness.folder)
    for _ in range(4000):
        time.sleep(0.002)
        if (work / "slice.done.json").exists():
            break
    child.kill()
    child.wait()
    check((work / "made_by_slim_build").exists(), "a killed build's folder bears no mark")
    before = sorted(work.glob("**/*"))
    result = build("--slices", "2", "--force", cloud="missing.ply")
    check(result.code == 3 and sorted(work.glob("**/*")) == before, f"a missing input removes what a kill left: {result.err}")
    result = run("slim", "build", "big.ply", "-o", "a.slim", "--slices", "2")
    check(result.code == 0 and not work.exists() and not done.exists(), "a resumed build leaves its folder")
    check("slice: up to date" in result.err, f"a build does not go on after a kill: {result.err}")


def killed_once(there, *options):
    """A build of big.ply, killed as soon as that file of its work folder is there."""
    child = subprocess.Popen([harness.bin / "slim-build", "big.ply", "-o", "a.slim", "-q", *options], cwd=harness.folder)
    while child.poll() is None and not (work / there).exists():
        time.sleep(0.001)
    child.kill()
    check(child.wait() == -signal.SIGKILL, f"the build ended before {there} was seen")


def bad_sensors_after_a_kill():
    """A bad file of sensors costs nothing of what a killed build left, also where its slices are up to date."""
    clean()
    killed_once("slice_0001/oriented.slice.done.json", "--slices", "4")
    (harness.folder / "sensors.json").write_text("{'scans': of no use")
    result = build("--slices", "4", "--sensors", "sensors.json", cloud="big.ply")
    check(result.code == 3 and "sensors.json" in result.err, f"bad sensors: {result.code} {result.err}")
    check((work / "slice_0001/oriented.slice.done.json").exists(), "bad sensors remove what a kill left")
    result = run("slim", "build", "big.ply", "-o", "a.slim", "--slices", "4")
    check(result.code == 0 and "slice: up to date" in result.err and not work.exists(), f"not resumed: {result.err}")
    # What the failed build sliced itself goes.
    result = build("--slices", "4", "--force", "--sensors", "sensors.json", cloud="big.ply")
    check(result.code == 3 and not work.exists(), f"bad sensors, sliced for them: {result.code} {result.err}")


def slicing_where_a_build_is_at_work():
    clean()
    work.mkdir()
    mark = work / "made_by_slim_build"
    mark.touch()
    held = os.open(work, os.O_RDONLY)
    fcntl.flock(held, fcntl.LOCK_EX)
    result = run("slim", "slice", "s.ply", "-o", "a.slim.work", "-q")
    check(result.code == 75 and mark.exists(), f"slices into a build's folder: {result.code} {mark.exists()}")
    os.close(held)
    result = run("slim", "slice", "s.ply", "-o", "a.slim.work", "-q")
    check(result.code == 0 and not mark.exists(), f"once it ended: {result.code} {mark.exists()}")


def others_file_in_a_slice():
    """Slices beyond those of a new plan go, all of them, though one holds a file of others."""
    clean()
    check(run("slim", "slice", "s.ply", "-o", "w", "--slices", "6", "-q").code == 0, "slice")
    slices = [harness.folder / "w" / f"slice_{i:04}" for i in range(6)]
    (slices[3] / "mine.txt").write_text("mine")
    check(run("slim", "slice", "s.ply", "-o", "w", "--slices", "2", "-q").code == 0, "slice again")
    check(os.listdir(slices[3]) == ["mine.txt"], f"left beside mine: {os.listdir(slices[3])}")
    check(not slices[2].exists() and not slices[4].exists() and not slices[5].exists(), "slices of an earlier plan stay")


def runs():
    """What make's slicing put beside a job's model, slim run uses and keeps."""
    clean()
    (harness.folder / "job.toml").write_text("[input]\nfiles = ['s.ply']\n[output]\ndir = 'out'\n")
    folder = pathlib.Path("out/model.slim.work")
    check(run("slim", "slice", "s.ply", "-o", folder, "-q").code == 0, "slice")
    result = run("slim", "run", "job.toml", "-q")
    check(result.code == 0 and (harness.folder / folder / "plan.json").exists(), f"slim run removes it: {result.err}")


for name, n in (("s.ply", 3000), ("big.ply", 200000)):
    made = run("slim", "scan", "sphere", "-o", name, "--points", n, "-q")
    check(made.code == 0, made.err)
others_files()
named_folders()
empty_folders_and_links()
stopped()
bad_sensors_after_a_kill()
slicing_where_a_build_is_at_work()
others_file_in_a_slice()
runs()
harness.end()
