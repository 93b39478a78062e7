#!/usr/bin/env python3
"""How the cost of `aether render` grows: with the length of paths, lights, triangles, threads, the size of the image
and samples, each with the exponent of a power law fitted to its larger half (least squares of logarithms).

    growth.py [--aether target/release/aether] [--largest 1000000] [--only NAME] [--json]

Scenes are made here. Costs are processor seconds of rendering, as the difference between two renders that differ in
samples alone, over their number; `start` is what is left for none (loading, building the tree), `peak` the most memory
in MiB. Of threads, the cost is seconds from start to end.
"""

import argparse
import json
import math
import os
import pathlib
import struct
import subprocess
import tempfile
import time

SCENE = """<scene version="3.0.0">
  <integrator type="{integrator}">
    <integer name="max_depth" value="{depth}"/><integer name="rr_depth" value="1000"/>
  </integrator>
  <sensor type="perspective">
    <float name="fov" value="60"/>
    <transform name="to_world"><lookat origin="0, 0, 0.8" target="0, -0.1, -1" up="0, 1, 0"/></transform>
    <sampler type="independent"><integer name="sample_count" value="1"/></sampler>
    <film type="hdrfilm">
      <integer name="width" value="{size}"/><integer name="height" value="{size}"/><rfilter type="box"/>
    </film>
  </sensor>
  <bsdf type="twosided" id="wall"><bsdf type="diffuse"><rgb name="reflectance" value="0.9"/></bsdf></bsdf>
  <shape type="cube"><ref id="wall"/></shape>
  <shape type="ply"><string name="filename" value="floor.ply"/><ref id="wall"/></shape>
  <shape type="ply">
    <string name="filename" value="lights.ply"/><ref id="wall"/>
    <emitter type="area"><rgb name="radiance" value="1"/></emitter>
  </shape>
</scene>
"""


def mesh(path, triangles, height, corner):
    """A sheet of about so many separate triangles in a square at a height; `corner` orders theirs."""
    side = max(1, math.ceil(math.sqrt(triangles)))
    half = 0.8 / side
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {3 * triangles}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {triangles}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    # Written as it comes: what this program has in memory counts for the ones that it starts.
    with path.open("wb") as file:
        file.write(header.encode())
        for i in range(triangles):
            x, z = (2 * (i % side + 0.5) / side - 1) * 0.9, (2 * (i // side + 0.5) / side - 1) * 0.9
            y = height + 0.05 * math.sin(12 * x) * math.cos(12 * z)
            file.write(struct.pack("<9f", *(c for dx, dz in corner for c in (x + half * dx, y, z + half * dz))))
        for i in range(triangles):
            file.write(struct.pack("<B3i", 3, 3 * i, 3 * i + 1, 3 * i + 2))


def run(options, folder, spp, threads):
    """Processor seconds, seconds and peak memory of one render."""
    command = [options.aether, "render", "scene.xml", "--spp", str(spp), "--threads", str(threads), "-o", "out.exr"]
    start = time.perf_counter()
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(f"{' '.join(command)} failed in {folder}")
    return usage.ru_utime + usage.ru_stime, time.perf_counter() - start, usage.ru_maxrss / 1024


def measure(options, integrator="path", depth=4, size=128, lights=2, triangles=1000, threads=1, spp=8):
    """One row: cost a sample, start, peak."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        up, down = [(-1, -1), (0, 1), (1, -1)], [(-1, -1), (1, -1), (0, 1)]
        mesh(folder / "floor.ply", triangles, -0.7, up)
        mesh(folder / "lights.ply", lights, 0.8, down)
        (folder / "scene.xml").write_text(SCENE.format(integrator=integrator, depth=depth, size=size))
        few, many = run(options, folder, 1, threads), run(options, folder, 1 + spp, threads)
    kind = 1 if threads > 1 else 0
    total = max(many[kind] - few[kind], 1e-6)
    samples = size * size * spp
    return {"cost": total / samples * 1e6, "start": max(0.0, few[0] - total / spp), "peak": many[2], "total": total}


def exponent(points, key):
    """The slope of the logarithms over the larger half."""
    points = [(math.log(x), math.log(max(row[key], 1e-9))) for x, row in points]
    points = points[(len(points) - 1) // 2:]
    x, y = (sum(axis) / len(points) for axis in zip(*points))
    return sum((a - x) * (b - y) for a, b in points) / sum((a - x) ** 2 for a, _ in points)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--aether", default="target/release/aether")
    parser.add_argument("--largest", type=int, default=1_000_000)
    parser.add_argument("--only")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    options.aether = str(pathlib.Path(options.aether).resolve())
    decades = lambda first: [10**k for k in range(first, 8) if 10**k <= options.largest]
    cores = [1 << k for k in range(8) if 1 << k <= len(os.sched_getaffinity(0))]
    series = {
        "path, length": ("cost", "depth", [2, 4, 8, 16, 32], {}),
        "bdpt, length": ("cost", "depth", [2, 4, 8, 16, 32], {"integrator": "bdpt", "size": 48}),
        "lights": ("cost", "lights", decades(0), {"depth": 2}),
        "triangles": ("cost", "triangles", decades(3), {"depth": 2, "spp": 64}),
        "triangles, start": ("start", "triangles", decades(3), {"depth": 2, "size": 16, "spp": 1}),
        "triangles, memory": ("peak", "triangles", decades(3), {"depth": 2, "size": 16, "spp": 1}),
        "threads": ("total", "threads", cores, {"spp": 32}),
        "side of the image": ("total", "size", [64, 128, 256, 512], {"spp": 4}),
        "samples, memory": ("peak", "spp", [1, 4, 16, 64], {"size": 64}),
    }
    results = {}
    for name, (key, parameter, values, fixed) in series.items():
        if options.only and options.only not in name:
            continue
        points = [(value, measure(options, **fixed, **{parameter: value})) for value in values]
        slope = exponent(points, key) if len(points) > 1 else None
        results[name] = {"exponent": slope, "of": key, "points": {x: row[key] for x, row in points}}
        if not options.json:
            unit = {"cost": "us a sample", "start": "s", "peak": "MiB", "total": "s"}[key]
            row = ", ".join(f"{x}: {row[key]:.3g}" for x, row in points)
            print(f"{name:18} exponent {slope:6.2f}   {unit}: {row}" if slope is not None else f"{name:18} {row}", flush=True)
    if options.json:
        print(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
