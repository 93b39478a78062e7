#!/usr/bin/env python3
"""Compares `aether` with Mitsuba 3's path tracer on any scene file, with the same number of samples.

    DRJIT_LIBLLVM_PATH=/path/to/libLLVM-19.so python3 tests/reference/compare_public.py SCENE.xml... [--spp 256]
        [--size 128x72] [--aether target/release/aether] [--option=--mitsuba3-roughplastic] [--integrator path]

Both render the file with a box filter: a wider one lets neighbouring pixels of Mitsuba share samples, so that their
errors depend on each other. Mitsuba's image is the mean of BATCHES independent ones, whose scatter is its variance.
`aether compare` does the rest: the ratio of means, and a z-test of the means of blocks.
"""

import argparse
import pathlib
import re
import subprocess
import tempfile

import mitsuba as mi
import numpy as np

from make_renders import write_exr

BATCHES = 16


def boxed(text):
    """A scene file with a box filter."""
    text = re.sub(r"<rfilter[^>]*/>|<rfilter.*?</rfilter>", "", text, flags=re.S)
    return text.replace("</film>", '<rfilter type="box"/></film>')


def mitsuba(path, options, out):
    """Renders with Mitsuba, and writes the mean and its variance."""
    scene = mi.load_file(str(path))
    sensor = scene.sensors()[0]
    width, height = map(int, options.size.split("x"))
    film = mi.traverse(sensor)
    film["film.size"] = mi.ScalarVector2u(width, height)
    film.update()
    batch = lambda seed: np.array(mi.render(scene, sensor=sensor, spp=options.spp // BATCHES, seed=seed), np.float64)
    images = np.stack([batch(seed)[:, :, :3] for seed in range(BATCHES)])
    mean, variance = images.mean(0), images.var(0, ddof=1) / BATCHES
    planes = {c: mean[:, :, k] for k, c in enumerate("RGB")}
    planes |= {f"variance.{c}": variance[:, :, k] for k, c in enumerate("RGB")}
    write_exr(out, planes, {})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", type=pathlib.Path)
    parser.add_argument("--aether", default="target/release/aether")
    parser.add_argument("--integrator", default="path")
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--size", default="128x72")
    parser.add_argument("--seed", default="1")
    parser.add_argument("--option", action="append", default=[], help="of aether, as --option=--mitsuba3-roughplastic")
    options = parser.parse_args()
    mi.set_variant("llvm_ad_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    for path in map(pathlib.Path.resolve, options.scenes):
        with tempfile.TemporaryDirectory() as directory:
            place = pathlib.Path(directory)
            theirs, ours, scene = place / "mitsuba.exr", place / "aether.exr", place / path.name
            # Beside links to all that the file may name.
            for other in path.parent.iterdir():
                if other.name != path.name:
                    (place / other.name).symlink_to(other)
            scene.write_text(boxed(path.read_text()))
            mitsuba(scene, options, theirs)
            command = [options.aether, "render", scene, "--integrator", options.integrator, "--spp", options.spp,
                       "--size", options.size, "--seed", options.seed, "-o", ours, *options.option]
            subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)
            print(f"{path.parent.name}/{path.name}", flush=True)
            subprocess.run([options.aether, "compare", str(ours), str(theirs)], check=False)


if __name__ == "__main__":
    main()
