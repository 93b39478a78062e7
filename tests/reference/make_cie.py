"""Colour matching functions and daylight, for spectra in scene files.

    pip install -r tests/reference/requirements.txt
    python3 tests/reference/make_cie.py

Writes integrators/src/scene/cie.txt: a line `wavelength x y z d65` every five
nanometres (CIE 1931 standard observer, illuminant D65), as Mitsuba 3 has them.
"""

import pathlib

import mitsuba as mi

OUTPUT = pathlib.Path(__file__).resolve().parents[2] / "integrators/src/scene/cie.txt"

if __name__ == "__main__":
    mi.set_variant("scalar_rgb")
    lines = []
    for wavelength in range(360, 831, 5):
        xyz = mi.cie1931_xyz(float(wavelength))
        values = [*xyz, mi.cie_d65(float(wavelength))]
        lines.append(f"{wavelength} " + " ".join(f"{float(v):.7g}" for v in values))
    OUTPUT.write_text("\n".join(lines) + "\n")
