#!/usr/bin/env python3
"""What it costs to compile a renderer for scenes in general instead of for one kind of scene.

    cargo build --release && cargo build --release -p examples --bin custom_strategy
    kinds.py SCENE.xml [--small DiffuseRooms] [--large Everything] [--aether target/release/aether]
             [--program target/release/custom_strategy] [--all SCENE.xml] [--spp 64] [--runs 5]

Reports seconds (one thread; renders of both kinds alternate, the median counts), instructions of a sample (under
callgrind, by renders of 1 and of 3 samples, so that loading is not counted; without valgrind none), bytes of a
vertex, and the size, without symbols, of `aether` and of a program that has the small kind alone.
"""

import argparse
import json
import pathlib
import re
import shutil
import statistics
import struct
import subprocess
import tempfile


def render(options, kind, spp, before=()):
    """Renders on one thread; the seconds of rendering alone, and what was written to standard error."""
    with tempfile.TemporaryDirectory() as directory:
        out = pathlib.Path(directory) / "out.exr"
        command = [*before, options.aether, "render", options.scene, "--kind", kind, "--threads", "1"]
        done = subprocess.run([*command, "--spp", str(spp), "-o", str(out)], check=True, capture_output=True, text=True)
        header = out.read_bytes()[:8192]
    (seconds,) = struct.unpack("<d", re.search(rb"seconds\0double\0.{4}(.{8})", header, re.S).group(1))
    return seconds, done.stderr


def instructions(options, kind):
    """Instructions of one sample a pixel of the image."""
    if not shutil.which("valgrind"):
        return None
    callgrind = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
    counts = []
    for spp in (1, 3):
        _, said = render(options, kind, spp, callgrind)
        counts.append(int(re.search(r"Collected : (\d+)", said).group(1)))
    return (counts[1] - counts[0]) / 2


def stripped(program):
    """The size of a program without symbols."""
    with tempfile.TemporaryDirectory() as directory:
        copy = pathlib.Path(directory) / "program"
        subprocess.run(["strip", "-o", str(copy), program], check=True)
        return copy.stat().st_size


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--small", default="DiffuseRooms")
    parser.add_argument("--large", default="Everything")
    parser.add_argument("--all", default="tests/scenes/models/bumps.xml", help="a scene that needs the large kind")
    parser.add_argument("--aether", default="target/release/aether")
    parser.add_argument("--program", default="target/release/custom_strategy", help="with the small kind alone")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--runs", type=int, default=5)
    options = parser.parse_args()
    kinds = [options.small, options.large]
    seconds = {kind: [] for kind in kinds}
    for _ in range(options.runs):
        for kind in kinds:
            seconds[kind].append(render(options, kind, options.spp)[0])
    middle = [statistics.median(seconds[kind]) for kind in kinds]
    counts = [instructions(options, kind) for kind in kinds]
    inspect = [[options.aether, "inspect", scene, "--json"] for scene in (options.scene, options.all)]
    vertices = [json.loads(subprocess.check_output(command))["kind"]["vertex_bytes"] for command in inspect]
    sizes = [stripped(options.program), stripped(options.aether)]

    print(f"| | {kinds[0]} | {kinds[1]} | ratio |\n| --- | --- | --- | --- |")
    rows = [("seconds", middle, "{:.2f}"), ("instructions of a sample of all pixels, in millions", counts, "{:.0f}"),
            ("bytes of a vertex", vertices, "{}"), ("bytes of the program, in millions", sizes, "{:.2f}")]
    for name, (small, large), form in rows:
        if small is None:
            continue
        scale = 1e-6 if "millions" in name else 1
        shown = [form.format(number * scale if scale != 1 else number) for number in (small, large)]
        print(f"| {name} | {shown[0]} | {shown[1]} | {small / large:.2f} |")


if __name__ == "__main__":
    main()
