"""Writes ../scenes/meshes/two.serialized: a tetrahedron without normals, and a square with everything.

    python tests/reference/make_serialized.py
"""

import pathlib
import struct
import zlib

SINGLE, FACE_NORMALS, NORMALS, TEXCOORDS = 0x1000, 0x10, 0x1, 0x2


def mesh(name, flags, *lists, triangles):
    """One mesh; the lists are positions, then normals and texture coordinates if the flags say so."""
    data = struct.pack("<I", flags) + name.encode() + b"\0"
    data += struct.pack("<QQ", len(lists[0]), len(triangles))
    for rows in lists:
        data += b"".join(struct.pack(f"<{len(row)}f", *row) for row in rows)
    data += b"".join(struct.pack("<3I", *t) for t in triangles)
    return struct.pack("<HH", 0x041C, 4) + zlib.compress(data, 9)


def main():
    """Writes the file."""
    tetrahedron = mesh(
        "tetrahedron",
        SINGLE | FACE_NORMALS,
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
        triangles=[(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)],
    )
    square = mesh(
        "square",
        SINGLE | NORMALS | TEXCOORDS,
        [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)],
        [(0, 0, 1)] * 4,
        [(0, 0), (1, 0), (1, 1), (0, 1)],
        triangles=[(0, 1, 2), (0, 2, 3)],
    )
    path = pathlib.Path(__file__).resolve().parent.parent / "scenes/meshes/two.serialized"
    table = struct.pack("<QQ", 0, len(tetrahedron)) + struct.pack("<I", 2)
    path.write_bytes(tetrahedron + square + table)


if __name__ == "__main__":
    main()
