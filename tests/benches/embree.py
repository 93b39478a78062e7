#!/usr/bin/env python3
"""Rays of `integrators` beside Embree's, one at a time on one thread.

    embree.py --embree PYTHON [--rays PROGRAM] [--count 1000000] [--runs 5] [--columns 200]

PYTHON is an interpreter that can import embreex (4.4, from PyPI) and numpy; PROGRAM is the example `rays`
(target/release/examples/rays). The scene is closed: a torus with bumps over a floor with bumps, in a box, of about
five columns x columns triangles. `rays` casts rays from the camera in the order of the pixels and rays from what
they hit in random directions, in random order, and writes them; Embree casts the same ones. Those start next to a
surface: Embree is given their origins moved on by 1e-4, as it knows nothing of surfaces that rays start on. Both are
timed in turns; what is reported is the fastest run of each, and how far they agree on what is hit.
"""

import argparse
import math
import pathlib
import re
import struct
import subprocess
import tempfile

# Runs inside PYTHON: casts the rays once for each line of its input.
WORKER = r"""
import sys, time
import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
mesh, rays, count = sys.argv[1], sys.argv[2], int(sys.argv[3])
with open(mesh, "rb") as file:
    sizes = np.fromfile(file, "<u4", 2)
    points = np.fromfile(file, "<f4", 3 * sizes[0]).reshape(-1, 3)
    corners = np.fromfile(file, "<u4", 3 * sizes[1]).reshape(-1, 3)
scene = rtcore_scene.EmbreeScene()
TriangleMesh(scene, points, corners.astype(np.int32))
rays = np.fromfile(rays, "<f4").reshape(-1, 7)
sets = [rays[:count], rays[count:]]
for line in sys.stdin:
    answer = []
    for which, part in enumerate(sets):
        on = np.float32(1e-4 * which)
        direction = np.ascontiguousarray(part[:, 3:6])
        origin = np.ascontiguousarray(part[:, :3] + on * direction)
        start = time.perf_counter()
        t = scene.run(origin, direction, query="DISTANCE")
        seconds = time.perf_counter() - start
        t = np.where(t > 1e30, np.inf, t + on)
        with np.errstate(invalid="ignore"):
            alike = (t == part[:, 6]) | (np.abs(t - part[:, 6]) <= 1e-3 * (1 + t))
        answer += [seconds, float(np.mean(alike))]
    print(*answer, flush=True)
"""

SCENE = """<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="perspective">
        <float name="fov" value="70"/>
        <transform name="to_world"><lookat origin="0, -2.6, 1.4" target="0, 0, 0" up="0, 0, 1"/></transform>
        <film type="hdrfilm"><integer name="width" value="1000"/><integer name="height" value="1000"/></film>
    </sensor>
    <shape type="ply"><string name="filename" value="mesh.ply"/><bsdf type="diffuse"/></shape>
    <emitter type="point"><point name="position" x="0" y="0" z="1.5"/></emitter>
</scene>
"""


def grid(columns, rows, point):
    """The points and triangles of a surface over the unit square."""
    points = [point(i / columns, j / rows) for j in range(rows + 1) for i in range(columns + 1)]
    corners = []
    for j in range(rows):
        for i in range(columns):
            a = j * (columns + 1) + i
            c = a + columns + 1
            corners += [(a, a + 1, c + 1), (a, c + 1, c)]
    return points, corners


def torus(s, t):
    a, b = 2 * math.pi * s, 2 * math.pi * t
    r = 0.4 + 0.03 * math.sin(23 * a) * math.sin(11 * b)
    return ((1 + r * math.cos(b)) * math.cos(a), (1 + r * math.cos(b)) * math.sin(a), r * math.sin(b))


def floor(s, t):
    x, y = 6 * s - 3, 6 * t - 3
    return (x, y, -1 + 0.15 * math.sin(5 * x) * math.cos(7 * y))


def meshes(columns):
    """All points and triangles: torus, floor, box."""
    parts = [grid(2 * columns, columns // 2, torus), grid(columns, int(1.5 * columns), floor)]
    box = [(3.0 * x, 3.0 * y, -1.5 if z < 0 else 3.0) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    parts.append((box, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]))
    points, corners = [], []
    for some, triangles in parts:
        first = len(points)
        points += some
        corners += [tuple(first + k for k in triangle) for triangle in triangles]
    return points, corners


def write_scene(folder, columns):
    """The scene for `rays`, and its mesh for Embree; returns the number of triangles."""
    points, corners = meshes(columns)
    floats = b"".join(struct.pack("<3f", *p) for p in points)
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(corners)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = b"".join(struct.pack("<B3i", 3, *c) for c in corners)
    (folder / "mesh.ply").write_bytes(header.encode() + floats + faces)
    plain = b"".join(struct.pack("<3I", *c) for c in corners)
    (folder / "mesh.bin").write_bytes(struct.pack("<2I", len(points), len(corners)) + floats + plain)
    (folder / "scene.xml").write_text(SCENE)
    return len(corners)


def ours(arguments, folder, *more):
    """Millions of rays a second, from the camera and scattered."""
    count = ["--rays", str(arguments.count), "--rounds", "1"]
    words = [arguments.rays, str(folder / "scene.xml"), *count, *more]
    text = subprocess.run(words, check=True, capture_output=True, text=True).stdout
    return [float(number) for number in re.findall(r"([\d.]+) M/s", text)[:2]]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--embree", required=True)
    parser.add_argument("--rays", default="target/release/examples/rays")
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--columns", type=int, default=200)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        triangles = write_scene(folder, arguments.columns)
        ours(arguments, folder, "--write", str(folder / "rays.bin"))
        words = [arguments.embree, "-c", WORKER, str(folder / "mesh.bin"), str(folder / "rays.bin"), str(arguments.count)]
        worker = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        runs = []
        for _ in range(arguments.runs):
            speeds = ours(arguments, folder)
            print("go", file=worker.stdin, flush=True)
            runs.append((speeds, [float(word) for word in worker.stdout.readline().split()]))
        worker.stdin.close()
    print(f"{triangles} triangles, {arguments.count} rays, one thread, millions of rays a second")
    for which, what in enumerate(["from the camera", "scattered"]):
        own = max(speeds[which] for speeds, _ in runs)
        embree = arguments.count / min(theirs[2 * which] for _, theirs in runs) * 1e-6
        alike = runs[0][1][2 * which + 1]
        print(f"{what:16} {own:6.2f}, Embree {embree:6.2f}, ratio {own / embree:.2f}; alike {100 * alike:.3f} %")


if __name__ == "__main__":
    main()
