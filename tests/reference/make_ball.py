"""Writes tests/scenes/meshes/ball.ply: an octahedron, each face split in four,
pushed out to the unit sphere (18 vertices, 32 triangles), as little-endian
binary PLY. Uses the standard library only.

    python3 tests/reference/make_ball.py
"""

import math
import pathlib
import struct

CORNERS = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
FACES = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]


def split(vertices, faces):
    """Splits every triangle in four and pushes the new vertices out to the unit sphere."""
    vertices, middles, out = list(vertices), {}, []

    def middle(a, b):
        key = (min(a, b), max(a, b))
        if key not in middles:
            m = [p + q for p, q in zip(vertices[a], vertices[b])]
            length = math.sqrt(sum(t * t for t in m))
            middles[key] = len(vertices)
            vertices.append(tuple(t / length for t in m))
        return middles[key]

    for a, b, c in faces:
        ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
        out += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return vertices, out


def main():
    """Writes the mesh."""
    vertices, faces = split(CORNERS, FACES)
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    body = b"".join(struct.pack("<3f", *v) for v in vertices)
    body += b"".join(struct.pack("<B3i", 3, *f) for f in faces)
    path = pathlib.Path(__file__).parent.parent / "scenes" / "meshes" / "ball.ply"
    path.write_bytes(header.encode() + body)


if __name__ == "__main__":
    main()
