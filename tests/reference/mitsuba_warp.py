"""The hand-written densities of Mitsuba 3 (mitsuba.warp) in single precision, at points of the catalogue.

    python tests/reference/mitsuba_warp.py > tests/reference/mitsuba-warp.csv

A line is a sampler of the catalogue, its parameters, uniforms, the sample that they map to (computed
with 50 digits, rounded to single precision), the exact density of the exact sample, and what Mitsuba
says of the rounded one. Parameters and uniforms are single-precision numbers, written exactly.
"""

import mitsuba as mi
import numpy as np
from mpmath import cos, exp, expm1, log, log1p, mp, mpf, pi, sin, sqrt

mi.set_variant("scalar_rgb")
mp.dps = 50
warp = mi.warp


def single(x):
    return float(np.float32(float(x)))


def direction(z_below, phi):
    """The direction whose depth below the pole is given."""
    r = sqrt(z_below * (2 - z_below))
    return r * cos(phi), r * sin(phi), 1 - z_below


def polar(r, phi):
    return r * cos(phi), r * sin(phi)


def root(u, a, b):
    """Where a density that is linear from a to b has the cumulative value u."""
    return u * (a + b) / (a + sqrt((1 - u) * a * a + u * b * b))


def uniform_sphere(u, v):
    return direction(2 * u, 2 * pi * v), 1 / (4 * pi)


def uniform_hemisphere(u, v):
    return direction(1 - u, 2 * pi * v), 1 / (2 * pi)


def cosine_hemisphere(u, v):
    r, z = sqrt(u), sqrt(1 - u)
    return (*polar(r, 2 * pi * v), z), z / pi


def cone(u, v, m):
    return direction(m * u, 2 * pi * v), 1 / (2 * pi * m)


def disk_polar(u, v, radius):
    return polar(radius * sqrt(u), 2 * pi * v), 1 / (pi * radius**2)


def von_mises_fisher(u, v, kappa):
    m = -log1p((1 - u) * expm1(-2 * kappa)) / kappa
    return direction(m, 2 * pi * v), kappa * exp(-kappa * m) / (-2 * pi * expm1(-2 * kappa))


def beckmann(u, v, alpha):
    t2 = -(alpha**2) * log1p(-u)
    z = 1 / sqrt(1 + t2)
    return (*polar(sqrt(t2) * z, 2 * pi * v), z), exp(-t2 / alpha**2) / (pi * alpha**2 * z**3)


def bivariate_normal(u, v, a, b, c):
    r = sqrt(-2 * log1p(-u))
    return polar(r, 2 * pi * v), (1 - u) / (2 * pi)


def bilinear_density(u, v, w00, w10, w01, w11):
    y = root(v, w00 + w10, w01 + w11)
    c, d = (1 - y) * w00 + y * w01, (1 - y) * w10 + y * w11
    x = root(u, c, d)
    return (x, y), 4 * ((1 - x) * c + x * d) / (w00 + w10 + w01 + w11)


def tent(u, v, radius):
    """On a line: Mitsuba's tent of two dimensions, which is 1 across the middle of the other one."""
    x = sqrt(2 * u) - 1 if u < 0.5 else 1 - sqrt(2 * (1 - u))
    return (radius * x,), (1 - abs(x)) / radius


def concentric_disk(u, v):
    a, b = 2 * u - 1, 2 * v - 1
    if abs(a) > abs(b):
        return polar(a, pi / 4 * (b / a)), 1 / pi
    return polar(b, pi / 2 - pi / 4 * (a / b) if b else 0), 1 / pi


CASES = [
    ("uniform sphere", uniform_sphere, [()], lambda x: warp.square_to_uniform_sphere_pdf(x)),
    ("uniform hemisphere", uniform_hemisphere, [()], lambda x: warp.square_to_uniform_hemisphere_pdf(x)),
    ("cosine hemisphere", cosine_hemisphere, [()], lambda x: warp.square_to_cosine_hemisphere_pdf(x)),
    ("cone", cone, [(1.0,), (0.1,), (1e-4,), (1e-7,)], lambda x, m: warp.square_to_uniform_cone_pdf(x, 1 - m)),
    ("disk polar", disk_polar, [(1.0,)], lambda x, r: warp.square_to_uniform_disk_pdf(x)),
    ("tent", tent, [(1.0,)], lambda x, r: warp.square_to_tent_pdf(x)),
    ("concentric_disk", concentric_disk, [()], lambda x: warp.square_to_uniform_disk_concentric_pdf(x)),
    (
        "von_mises_fisher",
        von_mises_fisher,
        [(0.01,), (1.0,), (100.0,), (1e5,)],
        lambda x, kappa: warp.square_to_von_mises_fisher_pdf(x, kappa),
    ),
    (
        "beckmann",
        beckmann,
        [(1.0,), (0.3,), (0.01,), (1e-4,)],
        lambda x, alpha: warp.square_to_beckmann_pdf(x, alpha),
    ),
    ("bivariate_normal", bivariate_normal, [(1.0, 0.0, 1.0)], lambda x, a, b, c: warp.square_to_std_normal_pdf(x)),
    (
        "bilinear_density",
        bilinear_density,
        [(1.0, 3.0, 5.0, 7.0), (1.0, 0.0, 0.0, 1000.0)],
        # Mitsuba leaves it unnormalised.
        lambda x, a, b, c, d: warp.square_to_bilinear_pdf(a, b, c, d, x) / ((a + b + c + d) / 4),
    ),
]

# Samplers of one uniform.
LINES = ["tent"]

LAST = 1 - 2**-24
FIRST = [2**-60, 1e-5, 1e-3, 0.1, 0.3, 0.5, 0.75, 0.97, 0.999, 1 - 1e-5, LAST]
SECOND = [1e-5, 0.1, 0.3, 0.5, 0.75, LAST]


def main():
    print("name,parameters,uniforms,point,density,mitsuba")
    words = lambda numbers: " ".join(repr(float(n)) for n in numbers)
    for name, sample, sets, density in CASES:
        for numbers in sets:
            numbers = [single(n) for n in numbers]
            for u in FIRST:
                for v in SECOND[:1] if name in LINES else SECOND:
                    u, v = single(u), single(v)
                    x, exact = sample(mpf(u), mpf(v), *map(mpf, numbers))
                    x = [single(c) for c in x]
                    point = mi.Vector3f(*x) if len(x) == 3 else mi.Point2f(*(x + [0.0])[:2])
                    found = float(density(point, *numbers))
                    print(f"{name},{words(numbers)},{words([u] if name in LINES else [u, v])},{words(x)},{mp.nstr(exact, 17)},{found!r}")


main()
