"""Renders a scene with Mitsuba 3 for `aether convergence`: the same file, size, depth, samples and threads.

Writes EXR files and their list `images.csv` into the directory given. What is measured is rendering alone: the
scene is loaded, and compiled by LLVM, before.
"""

import argparse
import csv
import os
import subprocess
import sys
import time
import xml.etree.ElementTree as xml

import mitsuba as mi

VARIANTS = {"mitsuba-scalar": "scalar_rgb", "mitsuba-llvm": "llvm_ad_rgb"}
# Samples of an image that are rendered at once: more would need much memory with LLVM.
MOST_AT_ONCE = 1 << 25


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("--scene", required=True)
    parser.add_argument("-D", dest="defines", action="append", default=[])
    parser.add_argument("--portal", dest="portals", action="append", default=[])
    parser.add_argument("--size", required=True)
    parser.add_argument("--max-depth", type=int, default=-1)
    parser.add_argument("--rr-depth", type=int, default=5)
    parser.add_argument("--threads", type=int)
    parser.add_argument("--budget", type=float, required=True)
    parser.add_argument("--spp", required=True)
    parser.add_argument("--seeds", required=True)
    parser.add_argument("--output", required=True)
    parser.add_argument("--variant", choices=VARIANTS)
    return parser.parse_args()


def load_without(path, portals, defines):
    """The scene without the shapes that are openings and no surfaces, and without an integrator that knows them."""
    tree = xml.parse(path).getroot()
    for parent in list(tree.iter()):
        for child in list(parent):
            opening = child.tag == "shape" and child.get("id") in portals
            if opening or child.tag == "integrator":
                parent.remove(child)
    mi.file_resolver().append(os.path.dirname(os.path.abspath(path)))
    return mi.load_string(xml.tostring(tree, encoding="unicode"), **defines)


def load(options):
    """The scene with a film of the size asked for, and the path tracer with the depth asked for."""
    defines = dict(text.split("=", 1) for text in options.defines)
    defines = {name.strip("= "): value for name, value in defines.items()}
    if options.portals:
        scene = load_without(options.scene, options.portals, defines)
    else:
        scene = mi.load_file(options.scene, **defines)
    width, height = (int(side) for side in options.size.split("x"))
    sensor = scene.sensors()[0]
    if list(sensor.film().size()) != [width, height]:
        parameters = mi.traverse(sensor)
        parameters["film.size"] = mi.ScalarVector2u(width, height)
        parameters.update()
    settings = {"type": "path", "max_depth": options.max_depth, "rr_depth": options.rr_depth}
    return scene, sensor, mi.load_dict(settings), width * height


def render(scene, sensor, integrator, seed, spp, pixels):
    """The image and the seconds that it took."""
    import drjit as dr

    part = max(1, min(spp, MOST_AT_ONCE // pixels))
    begin, total, done = time.perf_counter(), None, 0
    while done < spp:
        samples = min(part, spp - done)
        # A seed of its own for each part of each image.
        number = (seed * 4096 + spp * 64 + done // part) % (1 << 32)
        image = mi.render(scene, sensor=sensor, integrator=integrator, seed=number, spp=samples)
        dr.eval(image)
        dr.sync_thread()
        total = image * samples if total is None else total + image * samples
        done += samples
    result = mi.Bitmap(total / spp)
    return result, time.perf_counter() - begin


def measure(options, name):
    """Renders with one variant; the rows of the list of images."""
    mi.set_variant(VARIANTS[name])
    if options.threads:
        import drjit as dr

        dr.set_thread_count(options.threads)
    scene, sensor, integrator, pixels = load(options)
    fitting = [int(spp) for spp in options.spp.split(",")]
    seeds = [int(seed) for seed in options.seeds.split(",")]
    for seed in [None, *seeds]:
        speed = None
        for spp in fitting:
            if speed and spp * speed > 1.3 * options.budget:
                fitting = [step for step in fitting if step < spp]
                break
            # The first time, LLVM compiles for each number of samples: that is not measured.
            number = seeds[0] + 1_000_003 if seed is None else seed
            image, seconds = render(scene, sensor, integrator, number, spp, pixels)
            if seed is None:
                continue
            speed = seconds / spp
            file = f"{name}-{seed}-{spp}.exr"
            image.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False).write(
                os.path.join(options.output, file)
            )
            yield [name, "path", seed, spp, f"{seconds:.6f}", file]


def main():
    options = arguments()
    os.makedirs(options.output, exist_ok=True)
    if options.variant:
        with open(os.path.join(options.output, f"{options.variant}.csv"), "w", newline="") as table:
            csv.writer(table, lineterminator="\n").writerows(measure(options, options.variant))
        return
    # Each variant in a process of its own: with an LLVM that is too old, Mitsuba aborts.
    rows = []
    for name in VARIANTS:
        outcome = subprocess.run([sys.executable, *sys.argv, f"--variant={name}"])
        if outcome.returncode == 0:
            with open(os.path.join(options.output, f"{name}.csv"), newline="") as table:
                rows += list(csv.reader(table))
        else:
            print(f"{name} failed and is left out ({outcome.returncode})", file=sys.stderr)
    if not rows:
        sys.exit("no variant of Mitsuba could render the scene")
    with open(os.path.join(options.output, "images.csv"), "w", newline="") as table:
        head = ["renderer", "integrator", "seed", "spp", "seconds", "file"]
        csv.writer(table, lineterminator="\n").writerows([head, *rows])


if __name__ == "__main__":
    main()
