#!/usr/bin/env python3
"""Checks who may include whom (the table below) and that headers are grouped in order.

Prints every violation as file:line and exits 1 if there is one. No argument: the tree this lies in.
`--self-test` feeds it violations and expects to see each.
"""
import pathlib
import re
import sys

# What a folder may include besides itself and what those include.
ALLOWED = {
    "slim/base": [],
    "slim/model": ["slim/base"],
    "slim/shapes": ["slim/model"],
    "slim/scanner": ["slim/shapes"],
    "slim/slicing": ["slim/model"],
    "slim/neighbors": ["slim/model"],
    "slim/normals": ["slim/slicing", "slim/neighbors"],
    "slim/fit": ["slim/normals"],
    "slim/cover": ["slim/fit", "slim/blend"],
    "slim/tree": ["slim/cover"],
    "slim/blend": ["slim/model"],
    "slim/edges": ["slim/tree"],
    "slim/smooth": ["slim/tree", "slim/blend"],
    "slim/color": ["slim/tree"],
    "formats": ["slim/model"],
    "raytrace": ["slim/model"],
    "raytrace/intersect": ["raytrace", "slim/tree", "slim/blend"],
    "raytrace/project": ["raytrace/intersect", "slim/tree", "slim/blend"],
    "raytrace/trace": ["raytrace/intersect", "slim/tree", "slim/blend"],
    "raytrace/brute": ["raytrace", "slim/blend"],
    "raytrace/lines": ["raytrace"],
    "pipeline": ["slim/scanner", "slim/edges", "slim/smooth", "slim/color", "formats", "raytrace/project",
                 "raytrace/brute", "raytrace/lines", "raytrace/trace"],
    "tests": ["pipeline"],
}
# Heavy third-party headers, and the only files that may see them.
HEAVY = {
    "CLI/": ["pipeline/command_line.cpp"],
    "toml++/": ["pipeline/toml_file.cpp"],
    "OpenImageIO/": ["formats/openimageio/light_image_module.cpp"],
    "CGAL/": ["slim/normals/", "tests/peers/"],
    "flann/": ["slim/neighbors/"],
}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def closure(module, seen=None):
    seen = set() if seen is None else seen
    if module not in seen:
        seen.add(module)
        for other in ALLOWED[module]:
            closure(other, seen)
    return seen


def module_of(path):
    """The longest known folder that holds the path, or None."""
    parts = path.split("/")
    for n in range(len(parts) - 1, 0, -1):
        if "/".join(parts[:n]) in ALLOWED:
            return "/".join(parts[:n])
    return None


def group_of(bracket, name, own):
    """0 own header, 1 project, 2 third party, 3 std and system: the order of a file's includes."""
    if bracket == '"':
        return 0 if name == own else 1
    third = re.match(r"(gtest|gmock|fmt|spdlog|nlohmann|CLI|toml|tbb|oneapi|Eigen|CGAL|flann|"
                     r"OpenImageIO|OpenEXR|Imath|xxhash|zstd|zlib|boost|lz4|experimental)", name)
    return 2 if third else 3


def check_file(path, text):
    """Violations of one file as (line, message)."""
    module = module_of(path)
    if module is None:
        yield 1, "in a folder that the table of scripts/check_includes.py does not know"
        return
    may = closure(module)
    own = re.sub(r"\.cpp$", ".h", path)
    last = 0
    for number, line in enumerate(text.splitlines(), 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        bracket, name = match.groups()
        for prefix, users in HEAVY.items():
            if name.startswith(prefix) and not any(path.startswith(user) for user in users):
                yield number, f"<{name}> may only be included by {', '.join(users)}"
        if bracket == '"':
            other = module_of(name)
            if other is None:
                yield number, f'"{name}": project headers are named from the top folder'
            elif other not in may:
                yield number, f"{module} may not include {other} ({name})"
        group = group_of(bracket, name, own)
        if group < last:
            yield number, f"{name}: order is own, project, third-party, standard headers"
        last = group


def check_tree(top):
    count = 0
    for folder in ("slim", "formats", "raytrace", "pipeline", "tests"):
        for file in sorted((top / folder).rglob("*")):
            if file.suffix not in (".h", ".cpp"):
                continue
            path = file.relative_to(top).as_posix()
            for line, message in check_file(path, file.read_text()):
                print(f"{path}:{line}: {message}")
                count += 1
    return count


def self_test():
    cases = [
        ("slim/base/a.cpp", '#include "slim/model/surfel.h"', True),
        ("slim/fit/a.cpp", '#include "slim/neighbors/knn.h"', False),
        ("slim/fit/a.cpp", '#include "slim/blend/blend.h"', True),
        ("formats/a.cpp", '#include "slim/fit/moments.h"', True),
        ("raytrace/shade.cpp", '#include "slim/blend/blend.h"', True),
        ("raytrace/project/a.cpp", '#include "slim/blend/blend.h"', False),
        ("pipeline/a.cpp", '#include "tests/support/x.h"', True),
        ("slim/base/a.cpp", '#include "surfel.h"', True),
        ("slim/base/a.cpp", '#include <vector>\n#include "slim/base/vec.h"', True),
        ("slim/base/a.cpp", '#include "slim/base/a.h"\n\n#include <vector>', False),
        ("pipeline/a.cpp", "#include <CLI/CLI.hpp>", True),
        ("unknown/a.cpp", "", True),
    ]
    wrong = [c for c in cases if bool(list(check_file(c[0], c[1]))) != c[2]]
    for case in wrong:
        print("self-test: wrong answer for", case)
    return len(wrong)


if __name__ == "__main__":
    found = self_test()
    if sys.argv[1:] != ["--self-test"]:
        found += check_tree(pathlib.Path(__file__).resolve().parent.parent)
    print(f"{found} violations" if found else "includes are in order")
    sys.exit(1 if found else 0)
