#!/usr/bin/env python3
"""Hostile and degenerate input: `slim build` ends in a model or in exit code 3 with the file named.

Never another exit code (a sanitizer's finding is one), a hang, or gigabytes. With --asan as second
argument the address space is not bounded, as the sanitizer reserves terabytes.
"""
import math
import random
import struct
import sys

from harness import SHARED, Harness

harness = Harness("slim-build", "slim-info")
SANITIZED = "--asan" in sys.argv
SECONDS = 120 if SANITIZED else 30
PEAK = (4 if SANITIZED else 1) << 30
NOT_READ = {".las", ".laz", ".ptx", ".pcd", ".e57", ".obj", ".off", ".stl", ".drc"}


def ply(points, normals=None, kind="ascii", declared=None, extra=""):
    """The bytes of a PLY; `declared` lies about the number of points."""
    n = len(points) if declared is None else declared
    names = "x y z" + (" nx ny nz" if normals else "")
    header = f"ply\nformat {kind} 1.0\n{extra}element vertex {n}\n"
    header += "".join(f"property float {name}\n" for name in names.split()) + "end_header\n"
    rows = [p + (normals[i] if normals else ()) for i, p in enumerate(points)]
    if kind == "ascii":
        return (header + "".join(" ".join(map(repr, row)) + "\n" for row in rows)).encode()
    order = "<" if "little" in kind else ">"
    return header.encode() + b"".join(struct.pack(f"{order}{len(row)}f", *row) for row in rows)


def sphere(n):
    points = []
    for i in range(n):
        z = 1 - (2 * i + 1) / n
        r, a = math.sqrt(1 - z * z), i * math.pi * (3 - math.sqrt(5))
        points.append((r * math.cos(a), r * math.sin(a), z))
    return points


def attempt(name, data, expect="either"):
    """expect: 'model', 'refused', or 'either'."""
    file = harness.folder / name
    file.write_bytes(data)
    attempt_file(file, expect)
    file.unlink()


def attempt_file(file, expect="either"):
    model = harness.folder / "m.slim"
    result = harness.run("slim-build", file, "-o", model, "-q", "--force", seconds=SECONDS,
                         memory=None if SANITIZED else 4 << 30)
    codes = {"model": (0,), "refused": (3,), "either": (0, 3)}[expect]
    said = f"{file.name}: exit {result.code}: {result.err.strip()[-1500:]}"
    harness.check(result.code in codes, f"expected {expect}; {said}")
    harness.check(result.peak_bytes < PEAK, f"{file.name}: {result.peak_bytes} bytes at the peak")
    if result.code == 3:
        harness.check(file.name in result.err, f"the message does not name the file; {said}")
        harness.check(not model.exists(), f"{file.name}: refused, yet there is a model")
    if result.code == 0:
        harness.check(harness.run("slim-info", model, "--json").code == 0,
                      f"{file.name}: the model is not readable")
        model.unlink(missing_ok=True)
    left = [f.name for f in harness.folder.iterdir() if ".tmp." in f.name]
    harness.check(not left, f"{file.name}: left behind {left}")


def generated():
    ball = sphere(300)
    random.seed(7)
    nan, inf = float("nan"), float("inf")
    attempt("good.ply", ply(ball, ball), "model")
    attempt("good_without_normals.ply", ply(ball), "model")
    attempt("empty.ply", b"", "refused")
    attempt("empty.xyz", b"", "refused")
    attempt("no_points.ply", ply([]), "refused")
    attempt("header_only.ply", ply([], declared=100), "refused")
    attempt("header_cut.ply", b"ply\nformat ascii 1.0\nelement vertex 3\nprop", "refused")
    attempt("zeros.ply", b"\0" * 4096)
    attempt("zeros.xyz", b"\0" * 4096)
    attempt("noise.ply", b"ply\n" + random.randbytes(5000), "refused")
    for kind in ("ascii", "binary_little_endian", "binary_big_endian"):
        attempt(f"more_declared_{kind}.ply", ply(ball, ball, kind, declared=301), "refused")
        attempt(f"billions_declared_{kind}.ply", ply(ball, ball, kind, declared=4_000_000_000), "refused")
        attempt(f"overflow_declared_{kind}.ply", ply(ball, ball, kind, declared=2**63), "refused")
        attempt(f"negative_declared_{kind}.ply", ply(ball, ball, kind, declared=-1), "refused")
        attempt(f"fewer_declared_{kind}.ply", ply(ball, ball, kind, declared=200))
    attempt("faces_lie.ply", ply(ball).replace(
        b"end_header", b"element face 4000000000\nproperty list uchar int vertex_indices\nend_header"),
            "refused")
    attempt("index_out_of_range.ply", ply(ball).replace(
        b"end_header", b"element face 1\nproperty list uchar int vertex_indices\nend_header")
            + b"3 0 1 300\n", "refused")
    attempt("all_nan.ply", ply([(nan, nan, nan)] * 50), "refused")
    attempt("some_nan.ply", ply(ball + [(nan, 0, 0), (0, inf, 0), (0, 0, -inf)]), "model")
    attempt("nan_normals.ply", ply(ball, [(nan, 0, 0)] * 300))
    attempt("huge.ply", ply([(x * 1e38, y * 1e38, z * 1e38) for x, y, z in ball]))
    attempt("huge.xyz", "".join(f"{x}e308 {y}e308 {z}e308\n" for x, y, z in ball).encode())
    attempt("tiny.ply", ply([(x * 1e-38, y * 1e-38, z * 1e-38) for x, y, z in ball]))
    attempt("far_away.xyz", "".join(f"{4e6 + x} {5e6 + y} {z}\n" for x, y, z in ball).encode(), "model")
    attempt("one_point.ply", ply([(1, 2, 3)]))
    attempt("two_identical.ply", ply([(1, 2, 3)] * 2))
    attempt("many_identical.ply", ply([(1, 2, 3)] * 1000))
    attempt("two_points.ply", ply([(0, 0, 0), (1, 0, 0)]))
    attempt("collinear.ply", ply([(i / 100, 0, 0) for i in range(200)]))
    attempt("collinear_slanted.ply", ply([(i / 7, i / 3, i / 11) for i in range(200)]))
    attempt("plane.ply", ply([(i % 20 / 20, i // 20 / 20, 0) for i in range(400)]), "model")
    attempt("zero_normals.ply", ply(ball, [(0, 0, 0)] * 300), "model")
    attempt("long_normals.ply", ply(ball, [(1e30 * x, 1e30 * y, 1e30 * z) for x, y, z in ball]), "model")
    attempt("flipped_normals.ply", ply(ball, [(-x, -y, -z) for x, y, z in ball]), "model")
    attempt("random_normals.ply", ply(ball, [tuple(random.gauss(0, 1) for _ in "xyz") for _ in ball]))
    attempt("doubled.ply", ply(ball + ball, ball + ball), "model")
    attempt("words.xyz", b"1 2 3\n4 five 6\n", "refused")
    attempt("short_row.xyz", b"1 2 3\n4 5\n", "refused")


def truncated():
    """Thirty places of a small file of each kind, the whole header among them."""
    ball = sphere(300)
    for kind in ("ascii", "binary_little_endian"):
        whole = ply(ball, ball, kind)
        for i in range(30):
            size = i * 7 if i < 20 else len(whole) * (i - 19) // 11
            attempt(f"cut_{kind}_{size}.ply", whole[:size], "refused")
        attempt(f"cut_{kind}_last.ply", whole[:-1], "either" if kind == "ascii" else "refused")


def collected():
    for folder in ("malformed", "formats"):
        if not (SHARED / "data" / folder).is_dir():
            print(f"not tried: {folder} (shared data is not there)")
            continue
        for file in sorted((SHARED / "data" / folder).iterdir()):
            if not file.is_file() or file.suffix in (".conf", ".md"):
                continue
            if file.suffix.lower() not in NOT_READ:
                attempt_file(file)
                continue
            attempt_file(file, "refused")
            said = harness.run("slim-build", file, "-o", "m.slim", "-q").err
            harness.check("PLY" in said, f"{file.name}: the message names no format that is read: {said}")


generated()
truncated()
collected()
harness.end()
