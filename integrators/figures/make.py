#!/usr/bin/env python3
"""The pictures of README.md: renders of `aether` beside each other and beside Mitsuba 3, and what they differ by.

    make.py beside SCENE --integrator NAME --spp N       one algorithm beside Mitsuba's path tracer
    make.py equal SCENE --integrators A,B --spp N        algorithms with the same samples, the truth, and their errors
    make.py gradients SCENE --spp N                      what a gradient-domain render is made of, and its errors

Each with -o PICTURE.jpg [--peer-spp N] [--size WxH] [--depth N] [--opening XML] [--option OPTION]... [--aether PROGRAM],
run by a Python that can import mitsuba (3.9, with an LLVM that DRJIT_LIBLLVM_PATH names). The truth is the image of
Mitsuba's path tracer with `--peer-spp` samples. Errors are those of linear images: MSE is the mean of (x - r)^2,
relMSE that of (x - r)^2 / (r^2 + 0.01). All parts of a picture have the same exposure.
"""

import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

import mitsuba as mi
from scene_files import opened

mi.set_variant("llvm_ad_rgb")
mi.set_log_level(mi.LogLevel.Error)
import numpy as np  # noqa: E402


def read(path):
    """The colours of an image as an array, and its seconds of rendering."""
    bitmap = mi.Bitmap(str(path))
    seconds = float(bitmap.metadata()["seconds"]) if "seconds" in bitmap.metadata() else None
    data, names = np.array(bitmap).astype(np.float64), [field.name for field in bitmap.struct_()]
    return np.stack([data[:, :, names.index(channel)] for channel in "RGB"], axis=2), seconds


def aether(options, integrator, spp, *more, parts=("",)):
    """Renders with `aether`; the image, and the other files that it writes."""
    with tempfile.TemporaryDirectory() as directory:
        out, scene = pathlib.Path(directory) / "out.exr", pathlib.Path(options.scene).resolve()
        if options.opening:
            scene = opened(scene, options.opening, pathlib.Path(directory))
        command = [options.aether, "render", scene, "--integrator", integrator, "-o", str(out)]
        command += ["--size", options.size, "--max-depth", str(options.depth), *options.option, *map(str, more)]
        command += ["--spp", str(spp)] if spp else []
        command += ["--portal", "opening"] if options.opening else []
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return [read(out.with_name(f"out{part}.exr")) for part in parts]


def modern(text):
    """A scene file of Mitsuba 0.5 as Mitsuba 3 takes it: spectra of three numbers are colours, of one number too, a
    film for display is one for floats, textures are scaled and moved by a transform, integrators that only the file's
    authors have are left to the caller."""
    def colour(match):
        name, numbers = match.group(1), match.group(2).replace(",", " ").split()
        return f'<rgb name="{name}" value="{" ".join(numbers * (3 if len(numbers) == 1 else 1))}"'

    def place(match):
        of = dict(re.findall(r'name="(\w+)" value="([-\d.]+)"', match.group(0)))
        return (f'<transform name="to_uv"><scale value="{of.get("uvscale", 1)}"/>'
                f'<translate x="{of.get("uoffset", 0)}" y="{of.get("voffset", 0)}"/></transform>')

    text = re.sub(r"<!--.*?-->", "", text, flags=re.S)
    text = re.sub(r'<spectrum name="(\w+)" value="([\d., ]+)"', colour, text)
    text = re.sub(r'<integrator type="\w+"\s*/>|<integrator.*?</integrator>', "", text, flags=re.S)
    film = r'(<film )type="ldrfilm"(>.*?)(?:<(?:boolean|float|string) name="(?:banner|exposure|gamma|tonemapMethod|filename)"[^>]*/>\s*)+'
    text = re.sub(film, r'\1type="hdrfilm"\2', text, flags=re.S)
    text = re.sub(r'<film type="ldrfilm"', '<film type="hdrfilm"', text)
    placed = re.compile(r'(?:<float name="(?:uvscale|uoffset|voffset)" value="[-\d.]+"/>\s*)+')
    text = placed.sub(place, text)
    text = re.sub(r'<float name="maxSmoothAngle" value="[\d.]+"/>', "", text)
    # A texture that scales another one by one is that one.
    return re.sub(r'<texture type="scale">\s*<float name="scale" value="1.0"/>(.*?</texture>)\s*</texture>', r"\1", text, flags=re.S)


def mitsuba(options, spp):
    """The image that Mitsuba's path tracer makes of the same file."""
    path = pathlib.Path(options.scene).resolve()
    text = path.read_text()
    old = re.search(r'<scene version="0', text)
    mi.file_resolver().prepend(str(path.parent))
    scene = mi.load_string(modern(text) if old else text)
    width, height = map(int, options.size.split("x"))
    sensor = scene.sensors()[0]
    film = mi.traverse(sensor)
    film["film.size"] = mi.ScalarVector2u(width, height)
    film.update()
    path_tracer = mi.load_dict({"type": "path", "max_depth": options.depth})
    part = max(1, min(spp, (1 << 23) // (width * height)))
    images = [np.array(mi.render(scene, sensor=sensor, integrator=path_tracer, spp=part, seed=seed))
              for seed in range(max(1, spp // part))]
    return np.mean([image[..., :3].astype(np.float64) for image in images], axis=0)


def write(options, rows, exposure):
    """Rows of images of one size, with the same exposure, as one picture."""
    gap = 4
    height, width, _ = rows[0][0].shape
    most = max(map(len, rows))
    sheet = np.ones((len(rows) * (height + gap) - gap, most * (width + gap) - gap, 3))
    for i, row in enumerate(rows):
        for k, image in enumerate(row):
            y, x = i * (height + gap), k * (width + gap)
            sheet[y:y + height, x:x + width] = np.clip(image * exposure, 0, 1)
    eight_bits = mi.Bitmap(sheet.astype(np.float32)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, True)
    eight_bits.write(options.output, quality=88 if options.output.endswith(".jpg") else -1)


def exposure_of(image, options):
    """So that all but the brightest twentieth fits."""
    return options.exposure or 0.9 / np.quantile(image.mean(axis=2), 0.95)


def errors(image, truth):
    square = (image - truth) ** 2
    return square.mean(), (square / (truth**2 + 0.01)).mean()


def beside(options, truth, exposure):
    """One algorithm, and Mitsuba's path tracer."""
    ours, seconds = read(options.ours) if options.ours else aether(options, options.integrator, options.spp)[0]
    # The second without what is brighter than white: rare and bright paths decide the mean of a noisy image.
    seen = [np.minimum(image * exposure, 1).mean() for image in (ours, truth)]
    print(f"{options.integrator}: {seconds:.1f} s, relMSE {errors(ours, truth)[1]:.4g}; mean over Mitsuba's "
          f"{ours.mean() / truth.mean():.4f}, of what is no brighter than white {seen[0] / seen[1]:.4f}")
    return [[ours, truth]]


def equal(options, truth, exposure):
    """Algorithms with the same number of samples, and their errors over several seeds."""
    shown = []
    for name in options.integrators.split(","):
        runs = [aether(options, name, options.spp, "--seed", seed)[0] for seed in range(options.runs)]
        both = np.array([errors(image, truth) for image, _ in runs])
        seconds = np.mean([seconds for _, seconds in runs])
        shown_error = np.mean([errors(*(np.minimum(x * exposure, 1) for x in (image, truth)))[0] for image, _ in runs])
        print(f"{name}: MSE {both[:, 0].mean():.4g}, of what is shown {shown_error:.4g}, relMSE {both[:, 1].mean():.4g}, "
              f"{seconds:.2f} s")
        shown.append(runs[0][0])
    return [[*shown, truth]]


def gradients(options, truth, exposure):
    """The parts of a gradient-domain render, path tracing at equal samples and at equal time, and the errors."""
    parts = ("", "-primal", "-dx", "-dy")
    (l1, seconds), (primal, _), (dx, _), (dy, _) = aether(options, "gdpt", options.spp, parts=parts)
    (l2, _), = aether(options, "gdpt", options.spp, "--reconstruction", "l2")
    (path, fewer), = aether(options, "path", options.spp)
    (longer, _), = aether(options, "path", round(options.spp * seconds / fewer))
    named = {"primal": primal, "L1": l1, "L2": l2, "path, equal samples": path, "path, equal time": longer}
    for name, image in named.items():
        print(f"{name}: relMSE {errors(image, truth)[1]:.4g}")
    print(f"{seconds:.1f} s, path {fewer:.1f} s")
    shown = [0.5 / exposure + 2.0 * image for image in (dx, dy)]
    return [[primal, *shown], [l1, l2, longer]]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("figure", choices=["beside", "equal", "gradients"])
    parser.add_argument("scene")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--aether", default="target/release/aether")
    parser.add_argument("--size", default="256x192")
    parser.add_argument("--depth", type=int, default=-1)
    parser.add_argument("--opening", help="XML of a shape that is a portal, with the id `opening`")
    parser.add_argument("--integrator", default="path")
    parser.add_argument("--integrators", default="bdpt,tridir")
    parser.add_argument("--option", action="append", default=[], help="of aether, as --option=--light-paths=827")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--peer-spp", type=int, default=256)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--exposure", type=float)
    parser.add_argument("--ours", help="an image that was rendered before")
    options = parser.parse_args()
    truth = mitsuba(options, options.peer_spp)
    exposure = exposure_of(truth, options)
    make = {"beside": beside, "equal": equal, "gradients": gradients}[options.figure]
    write(options, make(options, truth, exposure), exposure)


if __name__ == "__main__":
    sys.exit(main())
