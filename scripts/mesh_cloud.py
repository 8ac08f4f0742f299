"""The vertices of a mesh as a cloud with normals from its faces: what the benchmarks build from.

Reads binary little-endian PLY as the shared meshes are: float x y z and, as one more element, lists of
vertices (uchar count, int indices). Normals are the sums of the normals of a vertex's faces times their area.
"""

import array
import struct
import sys


def read_mesh(path):
    """(coordinates as flat floats, triangles as flat indices); exits on a PLY of another form."""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    words = [line.split() for line in data[:end].decode("ascii").splitlines()]
    counts = {w[1]: int(w[2]) for w in words if w[:1] == ["element"]}
    kinds = [w[1:] for w in words if w[:1] == ["property"]]
    if (["format", "binary_little_endian", "1.0"] not in words or "face" not in counts
            or kinds[:3] != [["float", "x"], ["float", "y"], ["float", "z"]]
            or [k[:3] for k in kinds[3:]] != [["list", "uchar", "int"]]):
        sys.exit(f"{path}: expected binary little-endian PLY: float x y z, faces of uchar and int")
    faces = end + 12 * counts["vertex"]
    points = array.array("f", data[end:faces])
    return points, triangles(data[faces:], counts["face"])


def triangles(data, n):
    flat, at = array.array("i"), 0
    for _ in range(n):
        corners = struct.unpack_from(f"<{data[at]}i", data, at + 1)
        at += 1 + 4 * len(corners)
        for i in range(2, len(corners)):
            flat.extend((corners[0], corners[i - 1], corners[i]))
    return flat


def normals_of(points, faces):
    """Flat, of any length; zero where no face has an area."""
    normals = array.array("d", bytes(8 * len(points)))
    for f in range(0, len(faces), 3):
        a, b, c = (3 * i for i in faces[f:f + 3])
        ux, uy, uz = (points[b + k] - points[a + k] for k in range(3))
        vx, vy, vz = (points[c + k] - points[a + k] for k in range(3))
        normal = (uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx)
        for at in (a, b, c):
            for k in range(3):
                normals[at + k] += normal[k]
    return normals


def write_cloud(mesh, cloud):
    """Writes the vertices that faces use to the path `cloud`; returns (points, faces of the mesh)."""
    points, faces = read_mesh(mesh)
    normals = normals_of(points, faces)
    records = bytearray()
    for i in sorted(set(faces)):
        n = normals[3 * i:3 * i + 3]
        length = sum(x * x for x in n) ** 0.5 or 1.0
        records += struct.pack("<6f", *points[3 * i:3 * i + 3], *(x / length for x in n))
    names = "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    count = len(records) // 24
    cloud.write_bytes(f"ply\nformat binary_little_endian 1.0\nelement vertex {count}\n{names}end_header\n".encode()
                      + records)
    return count, len(faces) // 3
