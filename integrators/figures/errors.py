#!/usr/bin/env python3
"""The charts and the table of errors against time of README.md: eight scenes, each by `aether convergence`.

    errors.py --scenes SCENES --python PYTHON [--aether PROGRAM] -o DIRECTORY [NAME...]

SCENES has the scenes by Benedikt Bitterli that it names, each in a directory of its name, and as
`aether-authors/cbox/cbox_tridir.xml` the room of the Aether authors; PYTHON can import mitsuba, whose LLVM
DRJIT_LIBLLVM_PATH names. It makes a directory for each scene, or for those whose names are given, and in `report` what
`aether report` says of all that are there; the charts are copied beside this file. Nothing else should run meanwhile.
"""

import argparse
import pathlib
import shutil
import subprocess
import tempfile

from scene_files import opened

HERE = pathlib.Path(__file__).resolve().parent
PROJECT = HERE.parents[1]
MODELS = "tests/scenes/models"
ALL = "path,bdpt,ptracer,vcm,gdpt,mlt,pssmlt,vpl"
# Where most light comes through a small opening; what begins at lights hardly finds it.
OPENING = "path,bdpt,tridir,gdpt,mlt,pssmlt"
MITSUBA = ["--against", "mitsuba"]
ALONE = ["--variant", "bsdf only=path --techniques 0:*", "--variant", "light only=path --techniques 1:*"]

# What light passes in the room with a keyhole, which the authors' file does not name.
KEYHOLE = """<shape type="serialized" id="opening"><string name="filename" value="cornell_box_keyhole.serialized"/>
    <integer name="shapeIndex" value="0"/></shape>"""

THROUGH_KEYHOLE = ["--portal", "opening", "--reference-by", "bdpt,tridir"]

# Name, file (of the project or of SCENES), a shape that it has besides, size, seconds, integrators, and what else the
# measurement is asked for. A path tracer is no part of the truth where it hardly ever finds the light.
SCENES = [
    ("veach-mis", "veach-mis/scene.xml", "", "64x36", 1.5, ALL, [*ALONE, *MITSUBA]),
    ("veach-bidir", "veach-bidir/scene.xml", "", "64x36", 1.5, ALL, ["--reference-by", "bdpt", *MITSUBA]),
    ("veach-ajar", "veach-ajar/scene.xml", "", "64x36", 3, ALL, MITSUBA),
    ("cornell-box", "cornell-box/scene.xml", "", "48x48", 1.5, ALL, MITSUBA),
    ("box", PROJECT / "tests/scenes/cornell-box.xml", "", "48x48", 1.5, ALL, MITSUBA),
    ("daylight", PROJECT / MODELS / "daylight-tridir.xml", "", "48x48", 1.5, OPENING, ["--reference-by", "tridir", *MITSUBA]),
    ("portal-room", PROJECT / MODELS / "portal-room-tridir.xml", "", "48x48", 1.5, f"{ALL},tridir", MITSUBA),
    ("keyhole", "aether-authors/cbox/cbox_tridir.xml", KEYHOLE, "48x48", 1.5, OPENING, THROUGH_KEYHOLE),
]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--scenes", type=pathlib.Path, required=True)
    parser.add_argument("--python", required=True)
    parser.add_argument("--aether", default=str(PROJECT / "target/release/aether"))
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    options = parser.parse_args()
    known = [scene[0] for scene in SCENES]
    if unknown := [name for name in options.names if name not in known]:
        parser.error(f"no scene is called {', '.join(unknown)}; there are {', '.join(known)}")
    for name, file, shape, size, budget, integrators, more in SCENES:
        if options.names and name not in options.names:
            continue
        with tempfile.TemporaryDirectory() as directory:
            scene = (options.scenes / file).resolve()
            if shape:
                scene = opened(scene, shape, pathlib.Path(directory))
            command = [options.aether, "convergence", scene, "--name", name, "--size", size]
            command += ["--integrators", integrators, "--budget", str(budget), "--repeats", "4"]
            subprocess.run([*command, *more, "--python", options.python, "-o", options.output / name], check=True)
    made = [options.output / name for name in known if (options.output / name).is_dir()]
    report = options.output / "report"
    subprocess.run([options.aether, "report", *made, "-o", report], check=True)
    for directory in made:
        shutil.copy(report / f"{directory.name}.svg", HERE)


if __name__ == "__main__":
    main()
