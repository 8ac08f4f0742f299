#!/usr/bin/env python3
"""What a newcomer gets wrong: each mistake is named with the command that is right."""
import os
import pathlib
import shlex
import shutil
import signal
import struct
import subprocess
import time

from harness import Harness

harness = Harness("slim", "slim-scan", "slim-build", "slim-render", "slim-measure", "slim-info", "slim-run",
                  "slim-plan", "slim-fit", "slim-smooth")
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
    (harness.folder / "cut.ply").write_bytes((harness.folder / "t.ply").read_bytes()[:2000])
    refused(3, ["cut.ply", "the file is cut off"], "slim", "measure", "cut.ply", "cut.ply")
    refused(3, ["cut.ply", "the file is cut off"], "slim", "render", "cut.ply", "-o", "x.png")
    refused(2, ["x.ply", "ending in .slim"], "slim", "build", "t.ply", "-o", "x.ply")
    refused(2, ["diff.txt", "ending in .json"], "slim", "measure", "t.slim", "t.ply", "-o", "diff.txt")
    refused(2, ["--threads", "1 to "], "slim", "build", "t.ply", "-o", "x.slim", "--threads", "0")
    (harness.folder / "comma.xyz").write_text("1,5 2,0 3,1\n1,5 2,5 3,5\n")
    refused(3, ["comma.xyz: line 1", "decimal commas"], "slim", "build", "comma.xyz", "-o", "x.slim")
    (harness.folder / "hill.las").write_bytes(b"LASF" + b"\1" * 400)
    refused(3, ["pdal translate hill.las hill.ply"], "slim", "build", "hill.las", "-o", "x.slim")
    refused(2, ["is a folder"], "slim", "info", ".")
    refused(3, ["is a folder"], "slim", "build", ".", "-o", "x.slim")
    refused(3, ["standard input is not read"], "slim", "build", "-", "-o", "x.slim")
    refused(2, ["unexpected argument 'x.png'; to write it: -o x.png"], "slim", "render", "t.slim", "x.png")
    refused(2, ["a model, not a job"], "slim", "plan", "t.slim")
    refused(2, ["is a folder"], "slim", "render", ".", "-o", "x.png")


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
    for slices, is_sliced, stopped in (("1", "plan.json", ""), ("2", "slice.done.json", "goes on where it was, from big.slim.work, which stays")):
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


def outputs_over_inputs():
    """No picture over its model, whatever it is called; none outside its folder."""
    shutil.copy(harness.folder / "t.slim", harness.folder / "t.png")
    os.link(harness.folder / "t.png", harness.folder / "hard.png")
    folder = harness.folder / "dir"
    folder.mkdir()
    shutil.copy(harness.folder / "t.slim", folder / "front.shaded.png")
    shutil.copy(harness.folder / "t.slim", harness.folder / "spin_0002.png")
    before = (harness.folder / "t.png").read_bytes()
    refused(2, ["is an input"], "slim", "render", "t.png", "-o", "t.png")
    refused(2, ["is an input"], "slim", "render", "t.png", "-o", "./dir/../t.png")
    refused(2, ["is an input"], "slim", "render", "t.png", "-o", "hard.png")
    refused(2, ["is an input"], "slim", "render", "dir/front.shaded.png", "-o", "dir")
    refused(2, ["is an input"], "slim", "render", "spin_0002.png", "-o", "spin.png", "--turntable", "3")
    refused(2, ["is an input"], "slim", "render", "t.slim", "--mode", "raytrace", "--add", "t.png", "-o", "hard.png")
    check((harness.folder / "t.png").read_bytes() == before, "a picture over its model")
    refused(2, ["--name", "'/'"], "slim", "render", "t.slim", "-o", "dir", "--name", "../esc")
    check(not list(harness.folder.glob("esc*")), "--name leads out of the folder")


def runs_that_cannot_be():
    """Seen before anything is made, and said once."""
    refused(2, ["plate", "slim run plate scan.ply"], "slim", "run", "plate")
    refused(2, ["t.ply", "slim run plate t.ply"], "slim", "run", "t.ply")
    refused(3, ["nosuch.ply"], "slim", "run", "plate", "nosuch.ply")
    check(not (harness.folder / "nosuch_plate").exists(), "a missing cloud leaves a folder")
    job = harness.folder / "third.toml"
    job.write_text("[input]\nfiles = ['t.ply']\n[[view]]\naovs = ['e1']\n[output]\ndir = 'third'\n")
    refused(2, ["third.toml:3", "e1", "degree = 3"], "slim", "run", "third.toml")
    check(not (harness.folder / "third").exists(), "a view of third derivatives was seen after the build")
    check(run("slim", "plan", "third.toml", "--explain", "--set", "fit.degree=3").code == 0, "degree 3 refused")
    job.write_text("[input]\nfiles = ['t.ply']\n[[view]]\naovs = ['color']\n[output]\ndir = 'third'\n")
    refused(2, ["color = true"], "slim", "run", "third.toml")
    job.write_text("[input]\nfiles = ['t.ply']\n[[view]]\nname = '../out'\n")
    refused(2, ["third.toml:4", "'/'"], "slim", "run", "third.toml")
    (harness.folder / "bad.ply").write_text("ply\nformat ascii 1.0\nelement vertex 1\n")
    failed = run("slim", "run", "plate", "bad.ply")
    check(failed.code == 3 and failed.err.count("error:") == 1, f"an error is said twice: {failed.err}")
    (harness.folder / "file").write_text("")
    refused(2, ["cannot make this folder"], "slim", "run", "plate", "t.ply", "-o", "file/inside")


def commands_can_be_pasted():
    name = "my scan's.ply"
    shutil.copy(harness.folder / "t.ply", harness.folder / name)
    built = run("slim", "build", name, "-o", "my scan.slim")
    check(built.code == 0, built.err)
    for line in built.out.splitlines()[-2:]:
        words = shlex.split(line.removeprefix("next:").split("   (")[0])
        check(words[0] == "slim" and pathlib.Path(harness.folder / words[2]).exists(), f"not to be pasted: {line}")
    told = run("slim", "plan", "plate", name, "--explain", "--set", "render.light=key; fill")
    check(told.code == 0, told.err)
    words = shlex.split([line for line in told.out.splitlines() if "view front" in line][0])
    check("--light=key; fill" in words, f"not to be pasted: {words}")


def answers_first():
    measured = run("slim", "measure", "t.slim", "t.ply")
    lines = measured.out.splitlines()
    check(lines[0].split()[0] == "l2" and lines[0].endswith(" of L"), f"measure begins with {lines[0]}")
    check(lines[1].split()[0] == "max", f"measure goes on with {lines[1]}")
    refused(2, ["--two-way"], "slim", "measure", "t.slim", "t.ply", "--samples", "100")
    both = run("slim", "measure", "t.slim", "t.ply", "--two-way", "--json").json()
    check("spacing" in both["model_to_cloud"]["note"], f"two ways: {both['model_to_cloud']}")
    (harness.folder / "mesh.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n")
    check(run("slim", "info", "mesh.ply", "--json").json()["faces"] == 2, "info does not count faces")
    (harness.folder / "bad_face.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
        "property float nx\nproperty float ny\nproperty float nz\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0 1\n3 0 1 2\n")
    told = run("slim", "info", "bad_face.ply", "--json")
    check(told.code == 0 and told.json()["faces"] == 1, f"info reads faces that build does not: {told.err}")
    check(run("slim", "info", "t.slim", "--json").json()["colors"] is False, "info does not say colours")
    check(run("slim", "build", "t.ply", "-o", "auto.slim", "--degree", "auto", "-q").code == 0, "auto fails")
    told = run("slim", "info", "auto.slim").out
    check(any(line.startswith("degree ") and "auto" in line for line in told.splitlines()[:9]), told[:400])
    # The reader is gone before the first word is written, whatever the pipe holds.
    piped = subprocess.run(f"( sleep .3; exec '{harness.bin}/slim' info t.slim ) | true; echo ${{PIPESTATUS[0]}}",
                           shell=True, cwd=harness.folder, capture_output=True, text=True, executable="/bin/bash")
    check(piped.stdout == "141\n" and piped.stderr == "", f"info | true: {piped.stdout} {piped.stderr}")


def words():
    refused(2, ["--crop: expected"], "slim", "render", "t.slim", "-o", "x.png", "--crop", "1")
    refused(2, ["--frame is for"], "slim", "render", "t.slim", "-o", "x.png", "--frame", "2")
    refused(2, ["18446744073709551615"], "slim", "build", "t.ply", "-o", "x.slim", "--seed", "18446744073709551616")
    refused(2, ["at least one byte"], "slim", "build", "t.ply", "-o", "x.slim", "--memory", "0")
    for color in ("#fff", "#ffffff"):
        drawn = run("slim", "render", "t.slim", "-o", f"c{len(color)}.png", "--background", color, "--size", "60x50")
        check(drawn.code == 0, drawn.err)
    pictures = run("slim", "measure", "c4.png", "c7.png", "--json").json()
    told = run("slim", "measure", "c4.png", "c7.png").out
    check(told.startswith("identical") and "of L" not in told, f"measure of pictures: {told}")
    for option in (["--per-point", "p.ply"], ["--two-way"], ["--samples", "9"], ["--tolerance", "0.1"]):
        refused(2, [option[0], "a cloud against a model"], "slim", "measure", "c4.png", "c7.png", *option)
    refused(2, ["--threshold", "two pictures"], "slim", "measure", "t.slim", "t.ply", "--threshold", "0.1")
    (harness.folder / "job.toml").write_text("[input]\nfiles = ['t.ply']\n")
    for memory in ("bogus", "1K", "1G"):
        refused(2, ["--memory"], "slim", "plan", "job.toml", "--explain", "--memory", memory)
    refused(2, ["at least 64MiB"], "slim", "plan", "job.toml", "--format", "slurm", "--memory", "1K")
    if (harness.bin / "slim-report").exists():
        refused(2, ["pionts", "values.KEY"], "slim", "report", "job.toml", "-o", "x", "--set", "pionts=3")
    check(pictures["above"] == 0, "#fff is not #ffffff")
    drawn = run("slim", "render", "t.slim", "-o", "u.png", "--aov", "mean", "--unit", "ß字", "--size", "400x300")
    check("ß字" in drawn.err, f"letters that a picture does not have: {drawn.err}")
    twice = run("slim", "build", "t.ply", "./t.ply", "-o", "twice.slim")
    check("given twice" in twice.err, f"a cloud given twice: {twice.err}")
    for y, told in (("0.1*i", True), ("0.1*i + 0.001*(i % 2)", False)):
        (harness.folder / "line.xyz").write_text("".join(f"{i} {eval(y)} {2 * i}\n" for i in range(200)))
        line = run("slim", "build", "line.xyz", "-o", "line.slim")
        check(("on one line" in line.err) == told, f"points on a line, {y}: {line.err}")
    check(run("slim", "scan", "sphere", "-o", "ball.ply", "--points", "900", "--ascii").code == 0, "no ball")
    rows = (harness.folder / "ball.ply").read_text().split("end_header\n")[1].splitlines()
    (harness.folder / "speck.xyz").write_text("".join(" ".join(row.split()[:3]) + "\n" for row in rows) + "1e9 0 0\n")
    speck = run("slim", "build", "speck.xyz", "-o", "speck.slim")
    check("on one line" not in speck.err and "far points out" in speck.err, f"a stray 1e9 away: {speck.err}")
    (harness.folder / "small.xyz").write_text("".join(f"{i % 10}e-300 {i // 10}e-300 0\n" for i in range(100)))
    refused(3, ["change its unit"], "slim", "build", "small.xyz", "-o", "small.slim")


def a_stray_far_off():
    """A point ten diagonals away makes nothing smaller, and build names it; more than one in a thousand make L larger, which it says."""
    head, body = (harness.folder / "t.ply").read_bytes().split(b"end_header\n", 1)
    size = len(body) // 5000
    row = struct.pack("<3f", 40, 40, 40) + body[12:size]
    corners = ((40, 40, 40), (40, -40, 40), (40, 40, -40), (40, -40, -40), (45, 0, 0), (45, 40, 0))
    rows = b"".join(struct.pack("<3f", *p) + body[12:size] for p in corners)
    for name, n, more in (("six", 6, rows), ("far", 1, row)):
        (harness.folder / f"{name}.ply").write_bytes(head.replace(b"vertex 5000", b"vertex %d" % (5000 + n)) + b"end_header\n" +
                                                     body + more)
    built = run("slim", "build", "far.ply", "-o", "far.slim")
    check(built.code == 0 and "a point far from all others, as (40, 40, 40)" in built.err and "stretch" not in built.out,
          f"a stray: {built.out} {built.err}")
    built = run("slim", "build", "six.ply", "-o", "six.slim")
    check(built.code == 0 and "stretch the diagonal" in built.out, f"six strays a side: {built.out} {built.err}")
    check("stretch" not in run("slim", "build", "t.ply", "-o", "t.slim").out, "no stray stretches L")
    for options in ([], ["--ortho"], ["--mode", "raytrace"]):
        covered = [run("slim", "render", model, "-o", "f.png", "--size", "120x90", "--json", *options)
                   .json()["covered_pixels"] for model in ("t.slim", "far.slim")]
        check(covered[1] > 0.7 * covered[0], f"{options}: a stray shrinks the object: {covered}")


def options_by_their_names():
    for options, told in ((["--turntable", "3", "--path", "front;back", "--frames", "2"],
                           "--turntable and --path both move the camera"),
                          (["--path", "front;back"], "--path: say how many pictures with --frames"),
                          (["--frames", "3"], "--frames is for a --path, which"),
                          (["--frame", "3"], "--frame is for a --turntable or a --path, which"),
                          (["--lines", "contour", "--turntable", "3", "--lines-obj", "x.obj"], "--lines-obj is for one"),
                          (["--aov", "truth_distance"], "--truth-shape")):
        refused(2, [told], "slim", "render", "t.slim", "-o", "x.png", "--size", "60x50", *options)
    check("--add a.slim,b.slim" in run("slim", "render", "--help").out, "--help does not tell how to add several models")


def said_of_nothing():
    check("skipped     none" in run("slim", "info", "t.ply").out, "info leaves the skipped attributes blank")
    bare = harness.folder / "bare"
    bare.mkdir()
    shutil.copy(harness.bin / "slim-run", bare)
    alone = subprocess.run([bare / "slim-run", "plate"], capture_output=True, text=True)
    check(alone.returncode == 2 and "no ready styles beside the program" in alone.stderr, f"without styles: {alone.stderr}")
    refused(2, ["no ready style of that name: expected a file, or one of comparison", "(did you mean 'plate'?)"], "slim", "run", "plat")


def options_without_effect():
    """Refused, as --sun without relief is, and named; where they have one they are taken."""
    for options in (["--same-scale"], ["--bounces", "3"], ["--no-shadows"], ["--light-maps"], ["--percentile", "90"],
                    ["--range", "mean=3"], ["--range", "3"], ["--lod", "2", "--mode", "raytrace"],
                    ["--fov", "20", "--ortho"], ["--same-range", "front,back"],
                    ["--aov", "gauss", "--range", "mean=3"], ["--same-scale", "--ortho-width", "5"],
                    ["--same-scale", "--ortho", "--camera", "0,0,9,0,0,0"],
                    ["--up", "z", "--camera", "0,0,9,0,0,0,0,1,0"],
                    ["--percentile", "50", "--aov", "mean", "--range", "mean=5"],
                    ["--same-range", "front,top", "--aov", "mean", "--range", "3"], ["--name", "n"],
                    ["--camera", "iso", "--path", "front;back", "--frames", "2"],
                    ["--zoom", "2", "--path", "front zoom 1;back zoom 3", "--frames", "2"],
                    ["--bounces", "3", "--mode", "raytrace", "--aov", "mean"],
                    ["--background", "white", "--aov", "environment", "--environment-behind"]):
        refused(2, [options[0].replace("--no-", "--") if options[0] != "--aov" else "--range", "which is not asked for"],
                "slim", "render", "t.slim", "-o", "x.png", "--size", "60x50", *options)
    for options in (["--same-scale", "--ortho"], ["--bounces", "3", "--mode", "raytrace"], ["--lod", "2"],
                    ["--no-shadows", "--mode", "raytrace"], ["--light-maps", "--aov", "mean"],
                    ["--percentile", "90", "--aov", "error"], ["--range", "mean=3", "--aov", "mean,gauss"],
                    ["--fov", "20", "--ortho", "--camera", "0,0,9,0,0,0"], ["--up", "z", "--camera", "9,0,0,0,0,0"],
                    ["--up", "z", "--camera", "0,0,9,0,0,0,0,1,0", "--aov", "hillshade"],
                    ["--percentile", "50", "--aov", "mean,gauss", "--range", "mean=5"],
                    ["--same-range", "front,top", "--aov", "mean,depth", "--range", "mean=3"],
                    ["--zoom", "2", "--path", "front;back zoom 3", "--frames", "2"]):
        drawn = run("slim", "render", "t.slim", "-o", "x.png", "--size", "60x50", *options)
        check(drawn.code == 0, f"{options}: {drawn.err}")


def other_options_without_effect():
    for told, words in ((["--coarse", "--slice"], ["fit", "w", "--coarse", "--slice", "99"]),
                        (["--explain", "--format slurm"], ["plan", "job.toml", "--explain", "--format", "slurm"]),
                        (["--threads", "make"], ["plan", "job.toml", "--format", "make", "--threads", "8"]),
                        (["--threads", "--explain"], ["plan", "job.toml", "--explain", "--threads", "8"]),
                        (["--quiet", "--verbose"], ["info", "t.slim", "-q", "-v"]),
                        (["--stations", "uniform"], ["scan", "sphere", "-o", "u.ply", "--pattern", "uniform", "--stations", "3"]),
                        (["--sensors"], ["build", "t.ply", "-o", "k.slim", "--normals", "keep", "--sensors", "s.json"]),
                        (["gzip"], ["smooth", "t.slim", "t.ply", "-o", "o.ply.gz"])):
        refused(2, told, "slim", *words)
    # A picture without a legend that leaves its room overlays one with it.
    plain, room, legend = [
        run("slim", "render", "t.slim", "-o", "x.png", "--size", "500x400", "--aov", "mean", "--json", *options)
        .json()["covered_pixels"] for options in (["--no-legend"], ["--no-legend", "--legend-room"], [])]
    check(plain > room == legend, f"--legend-room without a legend: {plain} {room} {legend}")
    for count in ("2000000000", "0", "x"):
        many = run("slim", "build", "t.ply", "-o", "many.slim", env={"SLIM_THREADS": count})
        check(many.code == 2 and f"SLIM_THREADS={count}: expected" in many.err, f"{count}: {many.err}")


def one_range_for_all_sides():
    """The range of a map is the largest of the cameras', whichever of them draws."""
    def ranges(camera, *options):
        return run("slim", "render", "t.slim", "-o", "r.png", "--aov", "depth", "--size", "120x90", "--json", "--camera",
                   camera, *options).json()["ranges"]["depth"]
    own = [ranges(camera) for camera in ("front", "right")]
    check(own[0] != own[1], f"the cameras see the same: {own}")
    for camera in ("front", "right"):
        both = ranges(camera, "--same-range", "front,right")
        check(both == [min(r[0] for r in own), max(r[1] for r in own)], f"{camera}: {both} is not of {own}")
    refused(2, ["--same-range", "nowhere"], "slim", "render", "t.slim", "-o", "r.png", "--aov", "depth", "--same-range",
            "nowhere")


build_says_little()
wrong_files()
two_builds_at_once()
jobs()
outputs_over_inputs()
runs_that_cannot_be()
commands_can_be_pasted()
answers_first()
words()
a_stray_far_off()
options_without_effect()
other_options_without_effect()
options_by_their_names()
said_of_nothing()
one_range_for_all_sides()
harness.end()
