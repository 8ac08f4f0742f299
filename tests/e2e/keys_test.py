"""Every key that a program writes with --json, or into a manifest, is explained in docs/files.md."""
import json
import re

import harness


def keys_in(value):
    """The keys of all objects in it, but for a manifest's configuration and a job's views (which
    --help explains) and the sums that `normals` hands on."""
    if isinstance(value, list):
        return set().union(*map(keys_in, value)) if value else set()
    if not isinstance(value, dict):
        return set()
    keys = {key for key in value if re.fullmatch(r"[a-z][a-z_0-9]*", key)}
    return keys.union(*(keys_in(value[key]) for key in value if key not in ("config", "evidence", "noise",
                                                                         "rules", "view_list")))


def documented():
    text = (harness.SOURCE / "docs" / "files.md").read_text()
    return set(re.findall(r"[a-z][a-z_0-9]*", " ".join(re.findall(r"`([^`\n]*)`", text))))


RUNS = [
    ("slim-scan", "sculpture", "--points", 6000, "--noise", 0.002, "-o", "c.ply"),
    ("slim-build", "c.ply", "--t-mdl", 0.05, "-o", "m.slim"),
    ("slim-build", "c.ply", "--t-mdl", 0.05, "--normals", "estimate", "--sharp", "on", "--degree", "auto",
     "-o", "e.slim", "--work", "w", "--slices", 2),
    ("slim-render", "m.slim", "--size", "100x80", "--aov", "shaded,hillshade,mean", "--lines", "contour",
     "--antialias", "-o", "x.png"),
    ("slim-render", "e.slim", "--size", "100x80", "--mode", "raytrace", "--ortho", "--aov", "all",
     "-o", "y.exr"),
    ("slim-measure", "m.slim", "c.ply", "--two-way"),
    ("slim-smooth", "m.slim", "c.ply", "-o", "s.ply"),
    ("slim-measure", "c.ply", "s.ply", "--two-way"),
    ("slim-info", "c.ply"),
    ("slim-info", "e.slim"),
    ("slim-info", "x.mean.png"),
    ("slim-info", "c.truth"),
    ("slim-info", "s.ply"),
    ("slim-info", "views.toml"),
    ("slim-render", "m.slim", "--job", "views.toml", "-o", "views"),
]

if __name__ == "__main__":
    test = harness.Harness(*sorted({run[0] for run in RUNS}))
    known = documented()
    (test.folder / "views.toml").write_text('[[view]]\nsize = "64x48"\n')
    ours = {"truth_distance", "shaded", "hillshade", "mean"}  # names of pictures
    for program, *arguments in RUNS:
        result = test.run(program, *arguments, "--json")
        if not test.check(result.code == 0, f"{program} {arguments}: exit {result.code}: {result.err[-300:]}"):
            continue
        for key in sorted(keys_in(result.json()) - known - ours):
            test.check(False, f"{program} --json: {key} is not in docs/files.md")
        test.check(True, program)
    for manifest in sorted(test.folder.rglob("*.done.json")):
        for key in sorted(keys_in(json.loads(manifest.read_text())) - known - ours):
            test.check(False, f"{manifest.relative_to(test.folder)}: {key} is not in docs/files.md")
        test.check(True, manifest.name)
    test.end()
