#!/usr/bin/env python3
"""`slim smooth`: points and meshes come out in the format they came in, whole or not at all."""
import gzip
import json
import random
import struct

from harness import SHARED, Harness

harness = Harness("slim", "slim-scan", "slim-build", "slim-smooth", "slim-info")
run, check = harness.run, harness.check
folder = harness.folder


def smooth(cloud, out, *options, code=0):
    done = run("slim", "smooth", "m.slim", cloud, "-o", out, "--json", *options)
    check(done.code == code, f"smooth {cloud} -o {out} {options}: exit {done.code}: {done.err[-500:]}")
    return done


def model():
    run("slim-scan", "torus", "-o", "c.ply", "--points", "20000", "--noise", "0.003", "--noise-model", "isotropic")
    check(run("slim-build", "c.ply", "-o", "m.slim").code == 0, "build fails")


def points():
    said = smooth("c.ply", "s.ply").json()
    for key in ("points", "moved", "unsupported", "rms_displacement", "max_displacement", "seconds",
                "peak_memory_bytes"):
        check(key in said, f"the result lacks {key}: {said}")
    check(said["points"] == 20000 and said["moved"] + said["unsupported"] == 20000, f"counts: {said}")
    info = run("slim-info", "s.ply", "--json").json()
    check(info["points"] == 20000 and "scan" in info["attributes"] and "scalar_displacement" in info["skipped"],
          f"info: {info}")
    noise = run("slim-info", "m.slim", "--json").json()["noise"]
    check(info["noise_variance"] > 0 and abs(info["noise"] - noise) < 0.02 * noise and "slim smooth" in info["about"],
          f"the noise that a smoothed cloud had, of a model with {noise}: {info}")
    told = run("slim-info", "s.ply").out
    check(f"{info['noise']:.2g} of L" in told, f"info for people: {told}")
    check("noise" not in run("slim-info", "c.ply", "--json").json(), "noise of a cloud that is not smoothed")
    check("of L, in the median leaf" in run("slim-smooth", "m.slim", "c.ply", "-o", "s.ply").out, "noise that smooth says")
    manifest = json.loads((folder / "s.ply.done.json").read_text())
    check(manifest["stage"] == "smooth" and len(manifest["inputs"]) == 2, "the manifest names model and cloud")
    check(smooth("c.ply", "s.ply").json().get("up_to_date") is True, "a second run smooths again")
    check("up_to_date" not in smooth("c.ply", "s.ply", "--amount", "0.5").json(), "--amount is ignored")
    once = (folder / "s.ply").read_bytes()
    smooth("c.ply", "s.ply", "--amount", "0.5", "--threads", "1", "--force")
    check((folder / "s.ply").read_bytes() == once, "threads change the bytes")
    smooth("s.ply", "again.ply")
    size = [len((folder / name).read_bytes()) for name in ("s.ply", "again.ply")]
    check(size[0] == size[1], "a second smoothing adds properties again")


def memory_is_kept():
    run("slim-scan", "bumpy", "-o", "big.ply", "--points", "600000", "--noise", "0.001", "--pattern", "uniform")
    check(run("slim-build", "big.ply", "-o", "big.slim").code == 0, "build of a large cloud fails")
    whole = run("slim", "smooth", "big.slim", "big.ply", "-o", "big.out.ply", "--json").json()
    check(whole["refit_share"] == 1, f"1 GiB does not hold 600,000 points: {whole}")
    for size in (64, 96):
        part = run("slim", "smooth", "big.slim", "big.ply", "-o", "big.out.ply", "--memory", f"{size}MiB", "--json").json()
        check(0 < part["refit_share"] < 1 and part["moved"] == 600000, f"{size} MiB: {part}")
        check(part["peak_memory_bytes"] < size << 20, f"{size} MiB: {part}")
    check(whole["peak_memory_bytes"] > 64 << 20, f"the check shows nothing: {whole}")


def measure_keeps_its_inputs():
    for out in ("m.slim", "c.ply"):
        done = run("slim", "measure", "m.slim", "c.ply", "-o", out)
        check(done.code == 2 and "is an input" in done.err, f"measure -o {out}: exit {done.code}: {done.err}")
    check(run("slim", "measure", "m.slim", "c.ply").code == 0, "measure fails after a refusal")


def packed_and_text():
    (folder / "c.ply.gz").write_bytes(gzip.compress((folder / "c.ply").read_bytes()))
    smooth("c.ply", "s.ply", "--force")
    smooth("c.ply.gz", "unpacked.ply")
    check((folder / "unpacked.ply").read_bytes() == (folder / "s.ply").read_bytes(), "gzip gives other bytes")
    (folder / "p.xyz").write_text("# three\n1.3600 0 0 17\n0 1.36 0 18\n9 9 9 19\n")
    said = smooth("p.xyz", "p.out.xyz").json()
    lines = (folder / "p.out.xyz").read_text().splitlines()
    check(said["moved"] == 2 and said["unsupported"] == 1, f"text: {said}")
    check(lines[0] == "# three" and lines[3] == "9 9 9 19" and lines[1].endswith(" 17"), f"text: {lines}")
    check(abs(float(lines[1].split()[0]) - 1.35) < 0.01, f"text: {lines}")


def refused():
    smooth("c.ply", "x.xyz", code=2)
    smooth("c.ply", "c.ply", code=2)
    smooth("c.ply", "m.slim", code=2)
    smooth("c.ply", "x.ply", "--amount", "1.5", code=2)
    smooth("c.ply", "x.ply", "--mode", "mesh", code=3)
    smooth("nowhere.ply", "x.ply", code=3)
    swapped = run("slim", "smooth", "c.ply", "m.slim", "-o", "x.ply")
    check(swapped.code == 2 and "slim smooth m.slim c.ply -o x.ply" in swapped.err, f"swapped: {swapped.err}")


def apart():
    (folder / "away.xyz").write_text("403000 7 8\n403001 7 8\n")
    for command in (("smooth", "m.slim", "away.xyz", "-o", "apart.xyz"),
                    ("measure", "m.slim", "away.xyz", "-o", "apart.json", "--per-point", "apart.ply")):
        done = run("slim", *command, "--json")
        said = done.json()["error"]
        check(done.code == 5 and said["code"] == 5, f"{command}: exit {done.code}: {done.out}")
        check(all(word in said["message"] for word in ("m.slim", "away.xyz", "(403000, 7, 8)")), f"{command}: {said}")
    check(not list(folder.glob("apart*")), f"left behind: {list(folder.glob('apart*'))}")


def mesh_bytes(n, last_index=None):
    """A bowl of n x n vertices, little endian."""
    random.seed(3)
    head = (f"ply\nformat binary_little_endian 1.0\nelement vertex {n * n}\nproperty double x\nproperty double y\n"
            f"property double z\nelement face {2 * (n - 1) ** 2}\nproperty list uchar int vertex_indices\nend_header\n")
    rows = b""
    for i in range(n * n):
        x, y = i % n / n - 0.5, i // n / n - 0.5
        rows += struct.pack("<ddd", x, y, x * x + y * y + random.gauss(0, 0.004))
    faces = []
    for i in range((n - 1) ** 2):
        a = i // (n - 1) * n + i % (n - 1)
        faces += [(a, a + 1, a + n), (a + 1, a + n + 1, a + n)]
    if last_index is not None:
        faces[-1] = (0, 1, last_index)
    return head.encode() + rows + b"".join(struct.pack("<Biii", 3, *face) for face in faces)


def meshes():
    n = 60
    whole = mesh_bytes(n)
    (folder / "bowl.ply").write_bytes(whole)
    check(run("slim-build", "bowl.ply", "-o", "m.slim").code == 0, "build of the bowl fails")
    said = smooth("bowl.ply", "b.ply").json()
    check(said["mode"] == "mesh" and said["held"] == 4 * (n - 1) and said["moved"] == (n - 2) ** 2, f"mesh: {said}")
    out = (folder / "b.ply").read_bytes()
    check(out.endswith(whole[-13 * 2 * (n - 1) ** 2:]), "faces are not carried")
    start = out.index(b"end_header\n") + 11
    errors = [abs(z - x * x - y * y) for x, y, z, *_ in struct.iter_unpack("<dddffff", out[start:start + 40 * n * n])]
    check(sum(errors) / len(errors) < 0.0015, f"mean error of heights {sum(errors) / len(errors)}")  # noise: 0.0032
    check(said["at_edges"] < 0.05, f"edges on a bowl: {said}")
    moved = run("slim", "measure", "bowl.ply", "b.ply", "--per-point", "moved.ply", "--json").json()
    check(moved["vertices"] == n * n and (folder / "moved.ply").read_bytes().endswith(whole[-13:]), f"moved: {moved}")
    check(smooth("bowl.ply", "b.ply", "--mode", "points").json()["mode"] == "points", "--mode points is ignored")


def damaged():
    whole = mesh_bytes(12)
    for mode in ("auto", "points"):
        for i in range(25):
            (folder / "cut.ply").write_bytes(whole[:len(whole) * i // 25])
            done = smooth("cut.ply", "never.ply", "--mode", mode, code=3)
            check("cut.ply" in done.err, f"the message does not name the file: {done.err}")
    (folder / "lies.ply").write_bytes(mesh_bytes(12, last_index=144))
    done = smooth("lies.ply", "never.ply", code=3)
    check("lies.ply" in done.err and "144" in done.err, f"out of range: {done.err}")
    check(not list(folder.glob("never*")), f"left behind: {list(folder.glob('never*'))}")
    if not (SHARED / "data" / "malformed").is_dir():
        return
    for file in sorted((SHARED / "data" / "malformed").iterdir()):
        if file.suffix.lower() not in (".ply", ".xyz"):
            continue
        done = run("slim-smooth", "m.slim", file, "-o", "maybe" + file.suffix, "--json", seconds=30)
        check(done.code in (0, 3, 5), f"{file.name}: exit {done.code}: {done.err[-500:]}")


model()
points()
memory_is_kept()
measure_keeps_its_inputs()
packed_and_text()
refused()
apart()
meshes()
damaged()
harness.end()
