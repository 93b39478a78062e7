#!/usr/bin/env python3
"""A render by LuxCore, for `peers.py`: PYTHON luxcore.py SCENE.cfg --spp N --threads N --seed N -o IMAGE.exr

PYTHON is an interpreter that can import pyluxcore (2.11, from PyPI) and numpy. Everything else is as the scene says.
"""

import argparse
import os
import time

import numpy  # noqa: F401  (before pyluxcore, whose allocator ends the process otherwise)
import pyluxcore


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--spp", type=int, required=True)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("-o", dest="image", required=True)
    options = parser.parse_args()
    image = os.path.abspath(options.image)
    pyluxcore.Init()
    os.chdir(os.path.dirname(os.path.abspath(options.scene)))
    properties = pyluxcore.Properties(os.path.basename(options.scene))
    for name, value in {
        "batch.haltspp": options.spp,
        "native.threads.count": options.threads,
        "renderengine.seed": options.seed,
        "film.outputs.0.type": "RGB",
        "film.outputs.0.filename": image,
    }.items():
        properties.Set(pyluxcore.Property(name, value))
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(properties))
    session.Start()
    while not session.HasDone():
        time.sleep(0.01)
        session.UpdateStats()
    session.Stop()
    session.GetFilm().SaveOutputs()


if __name__ == "__main__":
    main()
