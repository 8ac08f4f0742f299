"""What bench_bytes and bench_reference share: models of the shared meshes, bytes at a wanted error."""

import json
import math
import os
import pathlib
import subprocess
import sys

import mesh_cloud

ROOT = pathlib.Path(__file__).resolve().parent.parent
FILES = {"igea": "clouds/igea.ply", "horse": "meshes/horse.ply", "nefertiti": "meshes/nefertiti.ply",
         "bunny_zipper": "meshes/bunny_zipper.ply", "bunny_raw": "scans/bunny_raw.ply",
         "happy_stand_raw": "scans/happy_stand_raw.ply"}


def run(command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} ends with {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def source_of(name):
    data = pathlib.Path(os.environ.get("SLIM_SHARED") or ROOT.parent / "shared") / "data"
    if not (data / FILES[name]).exists():
        sys.exit(f"{data / FILES[name]}: not there: name the shared folder in $SLIM_SHARED")
    return data / FILES[name]


def cloud_of(name, folder):
    """The cloud itself, or the mesh's vertices with normals from its faces, written to the folder."""
    source = source_of(name)
    if not FILES[name].startswith("meshes/"):
        return source
    cloud = folder / f"{name}.ply"
    mesh_cloud.write_cloud(source, cloud)
    return cloud


def model(programs, cloud, folder, t, words):
    """Builds and measures one: T_MDL, leaves, bytes, l2, max, normal error, missed points."""
    path = folder / "model.slim"
    run([programs / "slim-build", cloud, "-o", path, "--t-mdl", t, *words, "--force", "-q"])
    at = json.loads(run([programs / "slim-measure", path, cloud, "--json", "-q"]))
    return {"t_mdl": t, **{key: at[key] for key in ("leaves", "bytes", "l2", "max", "normal_rms_deg", "missed")}}


def useful(sweep):
    """The models or meshes of a sweep that no other betters in bytes and error at once, smallest first."""
    out = []
    for at in sorted(sweep, key=lambda at: (at["bytes"], at["l2"])):
        if not out or at["l2"] < out[-1]["l2"]:
            out.append(at)
    return out


def value_at(sweep, l2, key="bytes"):
    """Of models or meshes at an error, by a line through the logarithms of the two nearest useful ones; where all are
    better than that, of the smallest; None where none is as good."""
    sweep = useful(sweep)
    if sweep and sweep[0]["l2"] <= l2:
        return sweep[0][key]
    for a, b in zip(sweep, sweep[1:]):
        if b["l2"] <= l2 <= a["l2"]:
            share = math.log(l2 / a["l2"]) / math.log(b["l2"] / a["l2"])
            return round(a[key] * (b[key] / a[key]) ** share)
    return None
