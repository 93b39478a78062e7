"""Indices of refraction by name, as Mitsuba 3 resolves them in its RGB variants.

    pip install -r tests/reference/requirements.txt
    python3 tests/reference/make_indices.py

Writes integrators/src/scene/indices.txt: a line `metal NAME eta_r eta_g eta_b
k_r k_g k_b` for each conductor, and `dielectric eta NAME` for each dielectric.
"""

import glob
import os
import pathlib

import mitsuba as mi

OUTPUT = pathlib.Path(__file__).resolve().parents[2] / "integrators/src/scene/indices.txt"
DIELECTRICS = (
    "vacuum,helium,hydrogen,air,carbon dioxide,water,acetone,ethanol,carbon tetrachloride,glycerol,benzene,"
    "silicone oil,bromine,water ice,fused quartz,pyrex,acrylic glass,polypropylene,bk7,sodium chloride,"
    "amber,pet,diamond"
).split(",")


def shortest(value):
    """The shortest decimal for a number in single precision."""
    return f"{value:.7g}"


def metals():
    """Lines for all conductors that Mitsuba has data for."""
    folder = os.path.join(os.path.dirname(mi.__file__), "data", "ior")
    names = sorted(os.path.basename(f)[: -len(".eta.spd")] for f in glob.glob(folder + "/*.eta.spd"))
    for name in names:
        parameters = mi.traverse(mi.load_dict({"type": "conductor", "material": name}))
        numbers = [*parameters["eta.value"], *parameters["k.value"]]
        yield "metal " + name + " " + " ".join(shortest(x) for x in numbers)


def dielectrics():
    """Lines for all dielectrics."""
    for name in DIELECTRICS:
        bsdf = mi.load_dict({"type": "dielectric", "int_ior": name, "ext_ior": 1.0})
        yield f"dielectric {shortest(mi.traverse(bsdf)['eta'])} {name}"


if __name__ == "__main__":
    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    OUTPUT.write_text("\n".join([*metals(), *dielectrics()]) + "\n")
