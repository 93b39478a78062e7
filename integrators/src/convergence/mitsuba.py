"""Renders a scene with Mitsuba 3 for `aether convergence`: the same file, size, depth, samples and threads.

Writes EXR files and their list `images.csv` into the directory given. What is measured is rendering alone: the
scene is loaded and, with LLVM, compiled by a render of one sample before.
"""

import argparse
import csv
import os
import time

import mitsuba as mi

VARIANTS = {"mitsuba-scalar": "scalar_rgb", "mitsuba-llvm": "llvm_ad_rgb"}
# Samples of an image that are rendered at once: more would need much memory with LLVM.
MOST_AT_ONCE = 1 << 25


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("--scene", required=True)
    parser.add_argument("-D", dest="defines", action="append", default=[])
    parser.add_argument("--size", required=True)
    parser.add_argument("--max-depth", type=int, default=-1)
    parser.add_argument("--rr-depth", type=int, default=5)
    parser.add_argument("--threads", type=int)
    parser.add_argument("--budget", type=float, required=True)
    parser.add_argument("--spp", required=True)
    parser.add_argument("--seeds", required=True)
    parser.add_argument("--output", required=True)
    return parser.parse_args()


def load(options):
    """The scene with a film of the size asked for, and the path tracer with the depth asked for."""
    defines = dict(text.split("=", 1) for text in options.defines)
    defines = {name.strip("= "): value for name, value in defines.items()}
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


def main():
    options = arguments()
    os.makedirs(options.output, exist_ok=True)
    steps = [int(spp) for spp in options.spp.split(",")]
    seeds = [int(seed) for seed in options.seeds.split(",")]
    with open(os.path.join(options.output, "images.csv"), "w", newline="") as table:
        out = csv.writer(table, lineterminator="\n")
        out.writerow(["renderer", "integrator", "seed", "spp", "seconds", "file"])
        for name, variant in VARIANTS.items():
            mi.set_variant(variant)
            if options.threads:
                import drjit as dr

                dr.set_thread_count(options.threads)
            scene, sensor, integrator, pixels = load(options)
            render(scene, sensor, integrator, seeds[0] + 1_000_003, 1, pixels)
            fitting = steps
            for seed in seeds:
                speed = None
                for spp in fitting:
                    if speed and spp * speed > 1.3 * options.budget:
                        fitting = [step for step in fitting if step < spp]
                        break
                    image, seconds = render(scene, sensor, integrator, seed, spp, pixels)
                    speed = seconds / spp
                    file = f"{name}-{seed}-{spp}.exr"
                    image.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False).write(
                        os.path.join(options.output, file)
                    )
                    out.writerow([name, "path", seed, spp, f"{seconds:.6f}", file])


if __name__ == "__main__":
    main()
