"""Reference images of tests/scenes, rendered with Mitsuba 3.

    pip install -r tests/reference/requirements.txt
    DRJIT_LIBLLVM_PATH=/path/to/libLLVM-19.so python3 tests/reference/make_renders.py [SCENE...]

Renders each scene (by default all) with its own integrator and depth as
BATCHES independent images of SAMPLES samples per pixel, seeds 0, 1, 2, ...,
and writes renders/SCENE.exr: float32 channels R, G, B (the mean over the
batches) and variance.R, variance.G, variance.B (the variance of that mean,
estimated from the scatter of the batches). The variant `llvm_ad_rgb` needs
LLVM 19 or newer. The scenes of single models (`models/...`) are rendered with
`--variant scalar_rgb`.

Options: `--check NAME` renders one scene with `scalar_rgb` too and reports the
z-scores between the two variants (box filter only: the scalar variants
tabulate other filters coarsely); `--furnace` compares the stored furnace
images with their analytic answers; `--preview DIR` writes tone-mapped PNGs.
"""

import argparse
import pathlib
import struct
import sys
import time
import zlib

import mitsuba as mi
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
SCENES = HERE.parent / "scenes"
RENDERS = HERE / "renders"
BATCHES = 64
SAMPLES = 512
NAMES = (
    "cornell-box rectangle cube sphere disk obj ply-ascii ply-binary two-lights "
    "tent-filter gaussian-filter mitchell-filter lanczos-filter furnace-enclosure furnace-white"
).split()
# One material or one light each. Rendered with MODEL_SAMPLES in each of MODEL_BATCHES.
MODELS = [
    "models/" + name
    for name in (
        "conductor mirror dielectric thindielectric plastic plastic-nonlinear roughconductor-ggx "
        "roughconductor-ggx-all roughconductor-beckmann roughdielectric-ggx roughdielectric-beckmann "
        "mask blendbsdf textures anisotropic varying bumps bumped-mesh roughplastic-mitsuba3 constant envmap "
        "textured-lights point spot directional portal-room daylight smooth "
        "thinlens orthographic crop cylinder instance near-lamp"
    ).split()
]
MODEL_BATCHES = 16
MODEL_SAMPLES = 256


# Has an analytic answer only: in Mitsuba 3.9.1 the multiple importance sampling
# of a sphere light seen from points on that sphere adds 0.2 to 1 % of energy
# (BSDF sampling alone and light sampling alone are both exact).
SPHERE_FURNACE = "furnace-sphere"


def furnace_answer(name):
    """The exact radiance of a furnace scene, per channel.

    Depth d counts path edges, so that light arrives after 0, 1, ..., d - 1
    bounces and the sum is L (1 + r + ... + r^(d-1)) = L (1 - r^d) / (1 - r).
    """
    if name == "furnace-white":
        return np.ones(3)
    emitted, reflectance, depth = {
        "furnace-enclosure": ((0.5, 1.0, 0.25), (0.2, 0.5, 0.8), 6),
        "furnace-sphere": ((0.25, 0.5, 1.0), (0.9, 0.6, 0.3), 4),
    }[name]
    r = np.array(reflectance)
    return np.array(emitted) * (1 - r**depth) / (1 - r)


def render(name, batches, samples):
    """Mean and variance of the mean over `batches` renders, as float64 HxWx3 arrays."""
    scene = mi.load_file(str(SCENES / f"{name}.xml"))
    total, squares = 0.0, 0.0
    for seed in range(batches):
        image = np.array(mi.render(scene, spp=samples, seed=seed), dtype=np.float64)
        if seed == 0:
            # Deviations from the first batch keep the sum of squares accurate.
            first = image
        total = total + (image - first)
        squares = squares + (image - first) ** 2
    mean = total / batches
    scatter = np.maximum(squares / batches - mean**2, 0.0)
    return first + mean, scatter / (batches - 1)


def write_exr(path, channels, attributes):
    """Writes float32 planes {name: HxW array} as a single-part scanline EXR, ZIP compressed.

    Written by hand because the result must be the same byte for byte from the
    same pixels (no dates, no host names).
    """
    names = sorted(channels)
    height, width = channels[names[0]].shape

    def attribute(name, kind, data):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data

    chlist = b"".join(n.encode() + b"\0" + struct.pack("<iBxxxii", 2, 0, 1, 1) for n in names) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<ii", 20000630, 2)
    header += attribute("channels", "chlist", chlist)
    header += attribute("compression", "compression", b"\x03")  # ZIP, blocks of 16 lines
    header += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
    header += attribute("lineOrder", "lineOrder", b"\0")
    header += attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1.0))
    for key, value in sorted(attributes.items()):
        header += attribute(key, "string", str(value).encode())
    header += b"\0"

    blocks = []
    for top in range(0, height, 16):
        rows = range(top, min(top + 16, height))
        raw = b"".join(channels[n][y].astype("<f4").tobytes() for y in rows for n in names)
        blocks.append(struct.pack("<i", top) + sized(zip_block(raw)))
    offset, table = len(header) + 8 * len(blocks), b""
    for block in blocks:
        table += struct.pack("<Q", offset)
        offset += len(block)
    path.write_bytes(header + table + b"".join(blocks))


def sized(data):
    """`data` with its length in front."""
    return struct.pack("<i", len(data)) + data


def zip_block(raw):
    """One ZIP block of an EXR file: even bytes, then odd bytes, as differences, deflated."""
    data = np.frombuffer(raw, dtype=np.uint8)
    data = np.concatenate([data[0::2], data[1::2]]).astype(np.int32)
    data[1:] = (data[1:] - data[:-1] + 128) % 256
    packed = zlib.compress(data.astype(np.uint8).tobytes(), 9)
    return packed if len(packed) < len(raw) else raw


def make(name):
    """Renders one scene and writes its reference; returns a line of report."""
    start = time.perf_counter()
    batches, samples = (MODEL_BATCHES, MODEL_SAMPLES) if name in MODELS else (BATCHES, SAMPLES)
    mean, variance = render(name, batches, samples)
    seconds = time.perf_counter() - start
    planes = {}
    for k, c in enumerate("RGB"):
        planes[c], planes[f"variance.{c}"] = mean[:, :, k], variance[:, :, k]
    write_exr(
        RENDERS / f"{name}.exr",
        planes,
        {
            "batches": batches,
            "renderer": f"Mitsuba {mi.__version__} {mi.variant()}",
            "samplesPerPixel": batches * samples,
            "scene": f"{name}.xml",
        },
    )
    error = np.sqrt(variance.mean()) / mean.mean()
    return f"{name:18s} {seconds:7.1f} s  mean {mean.mean((0, 1)).round(6)}  noise per pixel {error:.2e}"


def read(name):
    """Mean and variance planes of a stored reference."""
    bitmap = mi.Bitmap(str(RENDERS / f"{name}.exr"))
    data = np.array(bitmap, dtype=np.float64)
    order = [field.name for field in bitmap.struct_()]
    pick = lambda prefix: np.stack([data[:, :, order.index(prefix + c)] for c in "RGB"], 2)
    return pick(""), pick("variance.")


def report_z(label, difference, variance):
    """Prints how a difference of images compares with its standard error."""
    z = difference / np.sqrt(np.maximum(variance, 1e-300))
    z = z[variance > 0]
    mean_z = difference.sum((0, 1)) / np.sqrt(np.maximum(variance.sum((0, 1)), 1e-300))
    print(f"{label}: rms z {np.sqrt((z**2).mean()):.3f}, largest {np.abs(z).max():.2f}, of the mean {mean_z.round(2)}")


def check_scalar(name):
    """Compares the stored reference with an independent render by `scalar_rgb`."""
    mi.set_variant("scalar_rgb")
    mean, variance = render(name, 32, 64)
    stored, stored_variance = read(name)
    report_z(f"{name} scalar_rgb", mean - stored, variance + stored_variance)


def check_furnaces():
    """Compares furnace images with their answers.

    The spherical one is rendered here by `prb_basic`, which samples only the
    BSDF; see SPHERE_FURNACE.
    """
    for name in [n for n in NAMES if n.startswith("furnace")]:
        mean, variance = read(name)
        report_z(f"{name} {furnace_answer(name)}", mean - furnace_answer(name), variance)
    scene = mi.load_file(str(SCENES / f"{SPHERE_FURNACE}.xml"))
    integrator = mi.load_dict({"type": "prb_basic", "max_depth": 4, "rr_depth": 100})
    mean = np.array(mi.render(scene, integrator=integrator, spp=64, seed=0)).mean((0, 1))
    exact = furnace_answer(SPHERE_FURNACE)
    print(f"{SPHERE_FURNACE} {exact}: relative error of prb_basic {mean / exact - 1}")


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description="Renders the reference images with Mitsuba 3.")
    parser.add_argument("scenes", nargs="*", default=[*NAMES, *MODELS])
    parser.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba; models use scalar_rgb")
    parser.add_argument("--check", metavar="SCENE", help="compare a stored image with scalar_rgb")
    parser.add_argument("--furnace", action="store_true", help="compare furnaces with their answers")
    parser.add_argument("--preview", metavar="DIR", help="write PNGs of the stored images")
    options = parser.parse_args()
    unknown = [n for n in options.scenes if n not in [*NAMES, *MODELS]]
    if unknown:
        sys.exit(f"unknown scene {unknown[0]}; the scenes are {', '.join([*NAMES, *MODELS])}")
    if options.check:
        return check_scalar(options.check)
    mi.set_variant(options.variant)
    if options.furnace:
        return check_furnaces()
    if options.preview:
        for name in options.scenes:
            image = mi.Bitmap(read(name)[0].astype(np.float32))
            image.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, True).write(
                str(pathlib.Path(options.preview) / f"{name}.png")
            )
        return None
    (RENDERS / "models").mkdir(parents=True, exist_ok=True)
    for name in options.scenes:
        print(make(name), flush=True)
    return None


if __name__ == "__main__":
    main()
