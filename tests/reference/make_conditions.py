"""Reference values and condition numbers of the closed-form samplers.

    pip install -r tests/reference/requirements.txt
    python3 tests/reference/make_conditions.py

Writes catalogue-e.json; README.md describes the fields and defines the
condition numbers. All arithmetic is mpmath's at 80 digits; the uniforms and
parameters of an entry are exactly the floats that it prints, and every number
derived from them is exact to the digits shown.

Each sampler is given twice, independently: the map from uniforms to a point,
and the density as a closed form in the point. The script stops if the density
times sqrt(det(J^T J)) of the map, by central differences, is not 1.
"""

import json
import math
import pathlib
import struct
from typing import NamedTuple

from mpmath import cospi, exp, expm1, floor, inf, isfinite, log, log1p, mp, mpf, nstr, pi, sin, sinpi, sqrt

mp.dps = 80
OUTPUT = pathlib.Path(__file__).resolve().parent / "catalogue-e.json"
BELOW_ONE = 1 - 2.0**-53
TINY = 2.0**-60


# --- vectors ---------------------------------------------------------------


def dot(a, b):
    """Scalar product."""
    return sum((p * q for p, q in zip(a, b)), mpf(0))


def norm(a):
    """Euclidean length."""
    return sqrt(dot(a, a))


def unit(a):
    """The vector scaled to length 1."""
    length = norm(a)
    return [p / length for p in a]


def on_circle(r, v):
    """The point at radius r and angle 2 pi v."""
    return [r * cospi(2 * v), r * sinpi(2 * v)]


def from_height(z, v):
    """The direction at height z and azimuth 2 pi v."""
    return on_circle(sqrt((1 - z) * (1 + z)), v) + [z]


def logit(u):
    """A logistic variate by its inverse distribution function."""
    return log(u) - log1p(-u)


# --- the samplers ----------------------------------------------------------


class Sampler(NamedTuple):
    """One row: the map, its density, and how its points are nudged.

    `inside(x, p)` is the closed support in the coordinates that `density`
    reads; `project(x, p)` takes a nudged point back to the manifold.
    """

    row: int
    name: str
    sample: object
    density: object
    inside: object = lambda x, p: True
    project: object = lambda x, p: x
    preimages: object = None  # (x, p) -> all uniforms that map to x, where there may be several
    smooth: object = lambda u, p: True  # whether the map has derivatives at u


def truncated_exponential(u, p):
    """Row 4; s = 0 is the uniform limit."""
    if p["s"] == 0:
        return [u[0] * p["D"]]
    return [-log1p(u[0] * expm1(-p["s"] * p["D"])) / p["s"]]


def truncated_exponential_density(x, p):
    """Row 4."""
    if p["s"] == 0:
        return 1 / p["D"]
    return p["s"] * exp(-p["s"] * x[0]) / -expm1(-p["s"] * p["D"])


def power_density(x, p):
    """Row 2; at 0 the limit, infinite for k < 1."""
    return p["k"] * real_power(x[0], p["k"] - 1)


def weibull_density(x, p):
    """Row 18; at 0 the limit."""
    t = x[0] / p["l"]
    return p["k"] / p["l"] * real_power(t, p["k"] - 1) * exp(-real_power(t, p["k"]))


def real_power(x, y):
    """x^y for x >= 0, with its limits at x = 0."""
    if x == 0:
        return mpf(1) if y == 0 else (mpf(0) if y > 0 else inf)
    return exp(y * log(x))


def gumbel_density(x, p):
    """Row 19."""
    z = (x[0] - p["m"]) / p["b"]
    return exp(-z - exp(-z)) / p["b"]


def affine_logistics(u, p):
    """Row 57."""
    a, b = logit(u[0]), logit(u[1])
    return [p["t0"] + p["a"] * a + p["b"] * b, p["t1"] + p["c"] * a + p["d"] * b]


def affine_logistics_density(x, p):
    """Row 57: the logistic densities at M^-1 (x - t), over |det M|."""
    det = p["a"] * p["d"] - p["b"] * p["c"]
    y, z = x[0] - p["t0"], x[1] - p["t1"]
    return logistic_density((p["d"] * y - p["b"] * z) / det) * logistic_density((p["a"] * z - p["c"] * y) / det) / abs(det)


def logistic_density(t):
    """Of the standard logistic distribution."""
    e = exp(-abs(t))
    return e / (1 + e) ** 2


def height(x, y, p):
    """The height field of row 107."""
    return p["h"] * sinpi(x) * sinpi(y)


def height_density(x, p):
    """Row 107: one over the area element of the graph."""
    slope_x = p["h"] * pi * cospi(x[0]) * sinpi(x[1])
    slope_y = p["h"] * pi * sinpi(x[0]) * cospi(x[1])
    return 1 / sqrt(1 + slope_x**2 + slope_y**2)


def sphere_point(u, p):
    """Row 93."""
    return [c + p["R"] * w for c, w in zip(p["c"], from_height(1 - 2 * u[0], u[1]))]


def to_sphere(x, p):
    """The point of the sphere of row 93 nearest to x."""
    return [c + p["R"] * w for c, w in zip(p["c"], unit([a - c for a, c in zip(x, p["c"])]))]


def to_unit_sphere(x, p):
    """The direction of x."""
    return unit(x)


def equirectangular_density(x, p):
    """Row 61: infinite at the poles."""
    r = norm(x[:2])
    return 1 / (2 * pi**2 * r) if r else inf


def linear_density(x, p):
    """Row 5."""
    return 2 * (p["a"] + (p["b"] - p["a"]) * x[0]) / (p["a"] + p["b"])


def linear(u, p):
    """Row 5, the conjugate form of the quadratic formula; 0 at 0."""
    if u[0] == 0:
        return [mpf(0)]
    root = sqrt((1 - u[0]) * p["a"] ** 2 + u[0] * p["b"] ** 2)
    return [u[0] * (p["a"] + p["b"]) / (p["a"] + root)]


def upper(x, p):
    """On the upper half of the sphere."""
    return x[2] >= 0


def unit_interval(x, p):
    """In [0, 1]."""
    return 0 <= x[0] <= 1


def positive(x, p):
    """On the half line."""
    return x[0] >= 0


SAMPLERS = [
    Sampler(1, "affine", lambda u, p: [p["a"] + (p["b"] - p["a"]) * u[0]], lambda x, p: 1 / abs(p["b"] - p["a"]),
            lambda x, p: min(p["a"], p["b"]) <= x[0] <= max(p["a"], p["b"])),
    Sampler(2, "power", lambda u, p: [real_power(u[0], 1 / p["k"])], power_density, unit_interval),
    Sampler(3, "exponential", lambda u, p: [-log1p(-u[0]) / p["s"]], lambda x, p: p["s"] * exp(-p["s"] * x[0]), positive),
    Sampler(4, "truncated exponential", truncated_exponential, truncated_exponential_density,
            lambda x, p: 0 <= x[0] <= p["D"]),
    Sampler(5, "linear", linear, linear_density, unit_interval),
    Sampler(18, "Weibull", lambda u, p: [p["l"] * real_power(-log1p(-u[0]), 1 / p["k"])], weibull_density, positive),
    Sampler(19, "Gumbel", lambda u, p: [p["m"] - p["b"] * log(-log(u[0]))], gumbel_density),
    Sampler(23, "softplus of logistic", lambda u, p: [-log1p(-u[0])], lambda x, p: exp(-x[0]), positive),
    Sampler(42, "disk polar", lambda u, p: on_circle(p["R"] * sqrt(u[0]), u[1]), lambda x, p: 1 / (pi * p["R"] ** 2),
            lambda x, p: norm(x) <= p["R"]),
    Sampler(57, "affine of two logistics", affine_logistics, affine_logistics_density),
    Sampler(60, "uniform sphere", lambda u, p: from_height(1 - 2 * u[0], u[1]), lambda x, p: 1 / (4 * pi),
            project=to_unit_sphere),
    Sampler(61, "equirectangular", lambda u, p: on_circle(sinpi(u[0]), u[1]) + [cospi(u[0])], equirectangular_density,
            project=to_unit_sphere),
    Sampler(62, "uniform hemisphere", lambda u, p: from_height(u[0], u[1]), lambda x, p: 1 / (2 * pi), upper, to_unit_sphere),
    Sampler(63, "cosine hemisphere", lambda u, p: on_circle(sqrt(u[0]), u[1]) + [sqrt(1 - u[0])], lambda x, p: x[2] / pi,
            upper, to_unit_sphere),
    Sampler(64, "power cosine", lambda u, p: from_height(real_power(u[0], 1 / (p["n"] + 1)), u[1]),
            lambda x, p: (p["n"] + 1) / (2 * pi) * real_power(x[2], p["n"]), upper, to_unit_sphere),
    Sampler(93, "sphere surface", sphere_point, lambda x, p: 1 / (4 * pi * p["R"] ** 2), project=to_sphere),
    Sampler(107, "height field", lambda u, p: [u[0], u[1], height(u[0], u[1], p)], height_density,
            lambda x, p: 0 <= x[0] <= 1 and 0 <= x[1] <= 1, lambda x, p: [x[0], x[1], height(x[0], x[1], p)]),
]
BY_ROW = {s.row: s for s in SAMPLERS}

# --- the points ------------------------------------------------------------

# Per row: (parameters, uniforms). The first ones of a row are its known traps.
LINE = [[0.0], [TINY], [1e-300], [0.3], [0.5], [0.7183098861837907], [1 - 2.0**-20], [BELOW_ONE]]
PAIRS = [[0.3, 0.6], [0.7183098861837907, 0.15915494309189535], [TINY, 0.3], [BELOW_ONE, 0.25], [0.5, 0.0],
         [0.5, BELOW_ONE], [1e-300, 0.9], [0.0, 0.3], [1 - 2.0**-30, 0.5]]


def over(parameters, uniforms):
    """One parameter set at many uniforms."""
    return [(parameters, u) for u in uniforms]


POINTS = {
    1: [({"a": 1e6, "b": 1e6 + 2.0**-10}, [0.3])] + over({"a": -2.0, "b": 3.0}, LINE)
    + [({"a": 1e6, "b": 1e6 + 2.0**-10}, [BELOW_ONE]), ({"a": 3.0, "b": -2.0}, [0.3]), ({"a": -1e300, "b": 1e300}, [0.7]),
       ({"a": 1.0, "b": 1.0 + 2.0**-52}, [0.25]), ({"a": -1.0, "b": 1e-20}, [BELOW_ONE])],
    2: [({"k": 1e3}, [1e-9]), ({"k": 0.01}, [0.5])] + over({"k": 2.5}, LINE)
    + [({"k": 1.0}, [0.0]), ({"k": 0.5}, [0.0]), ({"k": 1e3}, [BELOW_ONE]), ({"k": 1e6}, [1e-300]), ({"k": 0.01}, [BELOW_ONE])],
    3: [({"s": 1.0}, [TINY]), ({"s": 1e-8}, [BELOW_ONE])] + over({"s": 1.7}, LINE)
    + [({"s": 1e8}, [0.3]), ({"s": 1e-30}, [0.5]), ({"s": 1e300}, [1e-5])],
    4: [({"s": 1e-12, "D": 1.0}, [0.25]), ({"s": 800.0, "D": 1.0}, [BELOW_ONE])] + over({"s": 1.7, "D": 2.0}, LINE)
    + [({"s": 0.0, "D": 2.0}, [0.3]), ({"s": -3.0, "D": 1.0}, [0.3]), ({"s": -800.0, "D": 1.0}, [0.5]),
       ({"s": 1e-300, "D": 1.0}, [0.7]), ({"s": 1.7, "D": 1e-12}, [0.3]), ({"s": -1e-12, "D": 5.0}, [BELOW_ONE])],
    5: [({"a": 1.0, "b": 1.0 + 2.0**-40}, [0.3]), ({"a": 0.0, "b": 1.0}, [1e-20])] + over({"a": 1.0, "b": 4.0}, LINE)
    + [({"a": 1.0, "b": 0.0}, [BELOW_ONE]), ({"a": 1.0, "b": 1.0}, [0.3]), ({"a": 0.0, "b": 1.0}, [0.0]),
       ({"a": 1e-20, "b": 1e20}, [0.3]), ({"a": 4.0, "b": 1.0}, [1 - 2.0**-20]), ({"a": 1e-300, "b": 1e-300}, [0.5])],
    18: [({"l": 1.0, "k": 0.5}, [1e-20]), ({"l": 1.0, "k": 20.0}, [BELOW_ONE])] + over({"l": 2.0, "k": 1.6}, LINE)
    + [({"l": 1.5, "k": 2.0}, [0.3]), ({"l": 1.0, "k": 1.0}, [0.0]), ({"l": 1.0, "k": 0.5}, [0.0]),
       ({"l": 1e6, "k": 1e3}, [0.5]), ({"l": 1e-6, "k": 0.1}, [BELOW_ONE])],
    19: [({"m": 0.0, "b": 1.0}, [BELOW_ONE]), ({"m": 0.0, "b": 1.0}, [1e-300])] + over({"m": 0.3, "b": 2.0}, LINE[1:])
    + [({"m": 0.0, "b": 1.0}, [1 / math.e]), ({"m": 1e6, "b": 1e-3}, [0.3]), ({"m": -5.0, "b": 1e8}, [0.9])],
    23: over({}, LINE + [[1e-20], [0.9999]]),
    42: [({"R": 1.0}, [1e-300, 0.3])] + over({"R": 2.0}, PAIRS) + [({"R": 1e-10}, [0.3, 0.6]), ({"R": 1e10}, [0.3, 0.125])],
    57: [({"a": 1.0, "b": 1.0, "c": 1.0, "d": 1 + 2.0**-30, "t0": 0.0, "t1": 0.0}, [0.3, 0.6])]
    + over({"a": 1.0, "b": 0.5, "c": -0.3, "d": 2.0, "t0": 0.1, "t1": -0.2},
           [[0.3, 0.6], [0.7183098861837907, 0.15915494309189535], [TINY, 0.3], [BELOW_ONE, 0.25], [0.5, 0.5], [1e-250, BELOW_ONE]])
    + [({"a": 1.0, "b": 0.0, "c": 0.0, "d": 1.0, "t0": 0.0, "t1": 0.0}, [0.9, 0.2]),
       ({"a": 1e-3, "b": 0.0, "c": 0.0, "d": 1e-3, "t0": 1e6, "t1": -1e6}, [0.3, 0.6]),
       ({"a": 0.0, "b": 2.0, "c": 1.0, "d": 0.0, "t0": 0.0, "t1": 1.0}, [0.3, 0.6]),
       ({"a": 1e8, "b": 1.0, "c": 1.0, "d": 1e-7, "t0": 0.0, "t1": 0.0}, [0.3, 0.6])],
    60: over({}, [[TINY, 0.3]] + PAIRS[:2] + PAIRS[3:] + [[0.5, 0.125]]),
    61: over({}, [[1e-10, 0.3], [BELOW_ONE, 0.3]] + PAIRS + [[0.25, 0.125]]),
    62: over({}, PAIRS + [[2.0**-30, 0.125]]),
    63: over({}, [[BELOW_ONE, 0.25]] + PAIRS[:3] + PAIRS[4:] + [[0.5, 0.125]]),
    64: [({"n": 1e6}, [0.5, 0.1])] + over({"n": 20.0}, PAIRS)
    + [({"n": 0.0}, [0.0, 0.3]), ({"n": 1.0}, [0.3, 0.6]), ({"n": 1e6}, [1e-300, 0.9]), ({"n": 1e-3}, [0.01, 0.6]),
       ({"n": 1e12}, [0.3, 0.6])],
    93: [({"c": [1e6, 1e6, 1e6], "R": 1e-3}, [0.3, 0.6])] + over({"c": [1.0, 2.0, 3.0], "R": 2.5}, PAIRS)
    + [({"c": [0.0, 0.0, 0.0], "R": 1.0}, [0.3, 0.125]), ({"c": [1e6, -1e6, 0.0], "R": 1e-3}, [BELOW_ONE, 0.3]),
       ({"c": [1e-3, 0.0, 0.0], "R": 1e6}, [0.7, 0.6])],
    107: [({"h": 1e8}, [0.3, 0.6])] + over({"h": 0.8}, PAIRS)
    + [({"h": 0.0}, [0.3, 0.6]), ({"h": 1e8}, [0.5, 0.5]), ({"h": 1e8}, [TINY, BELOW_ONE]), ({"h": -2.0}, [0.9, 0.2])],
}

# Per row: (parameters, point, inside the support). Where the last is False the density is 0.
HEMISPHERE_QUERIES = [({}, [0.0, 0.6, -0.8], False), ({}, [0.0, 0.6, 0.1], False), ({}, [0.0, 0.0, 0.0], False),
                      ({}, [0.0, 0.0, -1.0], False), ({}, [0.0, 0.0, 2.0], False), ({}, [math.nan, 0.0, 1.0], False),
                      ({}, [0.0, 0.0, math.inf], False), ({}, [0.0, 0.0, 1.0], True)]
SPHERE_QUERIES = [({}, [0.0, 0.6, 0.1], False), ({}, [0.0, 0.0, 0.0], False), ({}, [0.0, -2.0, 0.0], False),
                  ({}, [math.nan, 0.0, 1.0], False), ({}, [0.0, 0.0, 1.0], True), ({}, [0.0, 0.0, -1.0], True),
                  ({}, [0.0, 1.0, 0.0], True)]
WITH_N = [({"n": 20.0}, x, inside) for _, x, inside in HEMISPHERE_QUERIES] + [({"n": 20.0}, [0.0, 1.0, 0.0], True),
                                                                              ({"n": 0.0}, [0.0, 0.6, -0.8], False)]
QUERIES = {
    1: [({"a": -2.0, "b": 3.0}, [-2.1], False), ({"a": -2.0, "b": 3.0}, [3.1], False), ({"a": -2.0, "b": 3.0}, [-2.0], True),
        ({"a": 3.0, "b": -2.0}, [3.1], False), ({"a": 1e6, "b": 1e6 + 2.0**-10}, [1e6 + 2.0**-9], False),
        ({"a": -2.0, "b": 3.0}, [math.nan], False), ({"a": -2.0, "b": 3.0}, [math.inf], False)],
    2: [({"k": 2.5}, [-0.1], False), ({"k": 2.5}, [1.5], False), ({"k": 2.0}, [-0.5], False), ({"k": 2.5}, [0.0], True),
        ({"k": 1.0}, [0.0], True), ({"k": 0.5}, [0.0], True), ({"k": 1e3}, [0.01], True)],
    3: [({"s": 1.0}, [-1e-6], False), ({"s": 1.0}, [-1.0], False), ({"s": 1.7}, [0.0], True), ({"s": 1.0}, [800.0], True),
        ({"s": 1.0}, [math.inf], False), ({"s": 1.0}, [-math.inf], False)],
    4: [({"s": 1.7, "D": 2.0}, [-0.1], False), ({"s": 1.7, "D": 2.0}, [2.1], False), ({"s": -3.0, "D": 1.0}, [1.1], False),
        ({"s": 1.7, "D": 2.0}, [0.0], True), ({"s": 0.0, "D": 2.0}, [1.0], True), ({"s": 0.0, "D": 2.0}, [2.5], False)],
    5: [({"a": 1.0, "b": 4.0}, [-0.1], False), ({"a": 1.0, "b": 4.0}, [1.1], False), ({"a": 0.0, "b": 1.0}, [0.0], True),
        ({"a": 1.0, "b": 4.0}, [-0.5], False), ({"a": 1.0, "b": 4.0}, [0.0], True)],
    18: [({"l": 2.0, "k": 1.6}, [-0.5], False), ({"l": 2.0, "k": 2.0}, [-0.5], False), ({"l": 2.0, "k": 1.6}, [0.0], True),
         ({"l": 2.0, "k": 1.0}, [0.0], True), ({"l": 2.0, "k": 0.5}, [0.0], True), ({"l": 1.0, "k": 2.0}, [40.0], True)],
    19: [({"m": 0.0, "b": 1.0}, [-8.0], True), ({"m": 0.0, "b": 1.0}, [0.0], True), ({"m": 0.0, "b": 1.0}, [800.0], True),
         ({"m": 0.0, "b": 1.0}, [math.nan], False)],
    23: [({}, [-1e-6], False), ({}, [0.0], True), ({}, [50.0], True), ({}, [math.inf], False)],
    42: [({"R": 2.0}, [2.0, 0.5], False), ({"R": 2.0}, [-1.5, -1.5], False), ({"R": 1e-10}, [1e-9, 0.0], False),
         ({"R": 2.0}, [0.0, 0.0], True), ({"R": 2.0}, [-1.9, 0.0], True), ({"R": 2.0}, [math.nan, 0.0], False)],
    57: [({"a": 1.0, "b": 0.5, "c": -0.3, "d": 2.0, "t0": 0.1, "t1": -0.2}, [0.1, -0.2], True),
         ({"a": 1.0, "b": 0.0, "c": 0.0, "d": 1.0, "t0": 0.0, "t1": 0.0}, [400.0, -400.0], True),
         ({"a": 1.0, "b": 0.0, "c": 0.0, "d": 1.0, "t0": 0.0, "t1": 0.0}, [math.inf, 0.0], False)],
    60: SPHERE_QUERIES,
    61: SPHERE_QUERIES,
    62: HEMISPHERE_QUERIES,
    63: HEMISPHERE_QUERIES,
    64: WITH_N,
    93: [({"c": [1.0, 2.0, 3.0], "R": 2.5}, [1.0, 2.0, 3.0], False), ({"c": [1.0, 2.0, 3.0], "R": 2.5}, [1.0, 2.0, 5.4], False),
         ({"c": [1.0, 2.0, 3.0], "R": 2.5}, [1.0, 2.0, 5.5], True), ({"c": [1.0, 2.0, 3.0], "R": 2.5}, [1.0, -0.5, 3.0], True),
         ({"c": [1e6, 1e6, 1e6], "R": 1e-3}, [1e6, 1e6, 1e6], False)],
    107: [({"h": 0.8}, [0.3, 0.6, 0.1], False), ({"h": 0.8}, [0.5, 0.5, 0.0], False), ({"h": 0.8}, [0.5, 0.5, 0.8], True),
          ({"h": 0.8}, [1.5, 0.5, -0.8], False), ({"h": 0.8}, [-0.5, 0.5, -0.8], False), ({"h": 0.0}, [0.3, 0.6, 0.0], True),
          ({"h": 0.0}, [0.3, 0.6, 1e-3], False), ({"h": 0.8}, [0.5, 0.5, math.nan], False)],
}

# --- floats ----------------------------------------------------------------


class Precision(NamedTuple):
    """A binary floating-point format."""

    digits: int  # of the significand, the hidden one included
    least: int  # exponent of the smallest positive number
    suffix: str  # of the JSON fields

    def round(self, x):
        """Nearest number of the format (ties to even), as a Python float; may be infinite or 0."""
        if isinstance(x, list):
            return [self.round(t) for t in x]
        x = mpf(x)
        if x == 0 or not isfinite(x):
            return float(x)
        spacing = self.ulp(x)
        scaled = x / spacing
        below = floor(scaled)
        rest = scaled - below
        if rest > mpf("0.5") or (rest == mpf("0.5") and int(below) % 2):
            below += 1
        value = below * spacing
        largest = (2 - mpf(2) ** (1 - self.digits)) * mpf(2) ** (2 - self.least - self.digits)
        return float(value) if abs(value) <= largest else math.copysign(math.inf, value)

    def ulp(self, x):
        """The spacing of the format at x (mpf)."""
        if x == 0:
            return mpf(2) ** self.least
        exponent = mp.frexp(x)[1] - 1  # floor(log2 |x|)
        return mpf(2) ** max(exponent - self.digits + 1, self.least)

    def round_uniform(self, u):
        """Nearest number of the format in [0, 1)."""
        return min(self.round(u), 1 - 2.0**-self.digits)

    def unit_ulp(self):
        """The spacing at 1: condition numbers are relative changes divided by it."""
        return mpf(2) ** (1 - self.digits)


F64 = Precision(53, -1074, "")
F32 = Precision(24, -149, "32")

# --- conditions ------------------------------------------------------------


def exact(value):
    """Parameters or uniforms as mpf."""
    if isinstance(value, dict):
        return {k: exact(v) for k, v in value.items()}
    return [mpf(t) for t in value] if isinstance(value, list) else mpf(value)


def moved_parameters(p, precision):
    """Per scalar parameter, the two parameter sets with it moved by half an ulp down and up."""
    for key, value in p.items():
        for i, old in enumerate(value if isinstance(value, list) else [value]):
            pair = []
            for side in (-1, 1):
                new = old + side * precision.ulp(old) / 2
                changed = [new if j == i else t for j, t in enumerate(value)] if isinstance(value, list) else new
                pair.append({**p, key: changed})
            yield pair


def moved_point(x, precision):
    """Per coordinate, the two points with it moved by half an ulp down and up."""
    for i, old in enumerate(x):
        yield [[old + side * precision.ulp(old) / 2 if j == i else t for j, t in enumerate(x)] for side in (-1, 1)]


def condition(base, pairs, distance, precision):
    """Sum over the inputs of the larger relative change of two moves, in ulps of 1; None if undefined.

    `pairs` yields per input two functions that evaluate the result after a
    move, or give None where the move leaves the domain.
    """
    size = distance(base, None)
    if size == 0 or not isfinite(size):
        return None
    total = mpf(0)
    for pair in pairs:
        results = [f() for f in pair]
        changes = [distance(r, base) for r in results if r is not None]
        total += max(changes, default=mpf(0))
    ratio = total / size / precision.unit_ulp()
    return ratio if isfinite(ratio) else None


def distance_of_points(a, b):
    """Euclidean, or the length of a if b is None."""
    return norm(a) if b is None else norm([s - t for s, t in zip(a, b)])


def distance_of_numbers(a, b):
    """Absolute difference, or the size of a if b is None."""
    return abs(a) if b is None else abs(a - b)


def safely(f, *args):
    """f(*args), or None outside its domain (complex, division by zero, infinite)."""
    try:
        y = f(*args)
        good = all(mp.im(t) == 0 and isfinite(t) for t in (y if isinstance(y, list) else [y]))
        return y if good else None
    except (ZeroDivisionError, ValueError, TypeError):
        return None


def condition_of_pdf(s, x, p, precision):
    """Of the density, over the coordinates (moved on the manifold) and the parameters."""

    def at(point):
        moved = safely(s.project, point, p)
        return safely(s.density, moved, p) if moved is not None and s.inside(moved, p) else None

    pairs = [[lambda y=y: at(y) for y in pair] for pair in moved_point(x, precision)]
    pairs += [[lambda q=q: safely(s.density, x, q) for q in pair] for pair in moved_parameters(p, precision)]
    return condition(s.density(x, p), pairs, distance_of_numbers, precision)


def condition_of_sample(s, u, p, precision):
    """Of the point, over the uniforms and the parameters."""

    def at(v):
        return safely(s.sample, v, p) if 0 <= v[0] < 1 else None

    pairs = [[lambda v=v: at(v) for v in pair] for pair in moved_point(u, precision)]
    pairs += [[lambda q=q: safely(s.sample, u, q) for q in pair] for pair in moved_parameters(p, precision)]
    return condition(s.sample(u, p), pairs, distance_of_points, precision)


# --- the check -------------------------------------------------------------


def area_element(s, u, p):
    """sqrt(det(J^T J)) of the map at u by central differences and Gram-Schmidt."""
    volume, basis = mpf(1), []
    for j, t in enumerate(u):
        step = mpf(10) ** -25 * min(t, 1 - t)
        above, below = [s.sample([t + d if i == j else v for i, v in enumerate(u)], p) for d in (step, -step)]
        column = [(a - b) / (2 * step) for a, b in zip(above, below)]
        for q in basis:
            along = dot(column, q)
            column = [c - along * t for c, t in zip(column, q)]
        length = norm(column)
        volume *= length
        basis.append([c / length for c in column])
    return volume


def check(s, u, p):
    """Stops the script if density and map contradict each other at u."""
    if not all(0 < t < 1 for t in u) or not s.smooth(u, p):
        return
    # Digits enough to tell 1e-300 (1 + 1e-25) from 1e-300 when it is added to 1.
    with mp.workdps(400):
        x = s.sample(u, p)
        found = s.preimages(x, p) if s.preimages else [u]
        if min(norm([a - b for a, b in zip(u, v)]) for v in found) > mpf(10) ** -20:
            raise SystemExit(f"row {s.row}: {u} is not among its own preimages, {p}")
        gap = abs(s.density(x, p) / sum(1 / area_element(s, v, p) for v in found) - 1)
    if not gap < mpf(10) ** -15:
        raise SystemExit(f"row {s.row} at u = {u}, {p}: pdf * area element - 1 = {nstr(gap, 5)}")


# --- output ----------------------------------------------------------------


def digits(x):
    """17 significant digits as a string; exact zeros and infinities by name."""
    x = mpf(x)
    if mp.isnan(x):
        return "nan"
    if not isfinite(x):
        return "inf" if x > 0 else "-inf"
    return "0" if x == 0 else nstr(x, 17, min_fixed=-5, max_fixed=17)


def hexadecimal(x):
    """A float as C99 hexadecimal, which is exact."""
    return float(x).hex()


def rounded(x):
    """Four significant digits of a condition number."""
    return None if x is None else float(nstr(x, 4))


def entry_for(s, params, u, precision):
    """The fields of one point in one precision, or None where the format cannot hold it."""
    p = {k: precision.round(v) for k, v in params.items()}
    u = [precision.round_uniform(t) for t in u]
    flat = [t for v in p.values() for t in (v if isinstance(v, list) else [v])]
    q, v = exact(p), exact(u)
    if any(math.isinf(t) for t in flat):
        return None
    x = safely(s.sample, v, q)
    if x is None:
        return None
    try:
        density = s.density(x, q)
    except ZeroDivisionError:
        return None
    if precision is F64:
        check(s, v, q)
    near = precision.round(x)
    if not all(math.isfinite(t) for t in near):
        return None
    at_near = s.density(exact(near), q)
    projected = safely(s.project, exact(near), q)
    fields = {
        "params": p,
        "u": u,
        "u_hex": [hexadecimal(t) for t in u],
        "x": [digits(t) for t in x],
        "x_hex": [hexadecimal(t) for t in near],
        "pdf": digits(density),
        "pdf_at_rounded_x": digits(at_near),
        "pdf_at_projected_x": None if projected is None else digits(s.density(projected, q)),
        "condition_pdf": rounded(condition_of_pdf(s, x, q, precision)),
        "condition_sample": rounded(condition_of_sample(s, v, q, precision)),
    }
    return {k + precision.suffix: v for k, v in fields.items()}


def query_for(s, params, x, inside):
    """The fields of a density asked for at a given point."""
    p, y = exact(params), exact(x)
    density = s.density(y, p) if inside else mpf(0)
    return {
        "row": s.row,
        "name": s.name,
        "kind": "query",
        "params": params,
        "x": [digits(t) for t in x],
        "x_hex": [hexadecimal(t) for t in x],
        "pdf": digits(density),
    }


def point_for(s, params, u):
    """One point in both precisions; the f32 fields are null where f32 cannot hold the case."""
    double = entry_for(s, params, u, F64)
    if double is None:
        raise SystemExit(f"row {s.row}: {params}, {u} is outside the domain")
    single = entry_for(s, params, u, F32) or {k + "32": None for k in double}
    return {"row": s.row, "name": s.name, "kind": "point"} | double | single


def main():
    """Computes all entries and writes the file, one entry per line."""
    entries = []
    for s in SAMPLERS:
        entries += [point_for(s, params, u) for params, u in POINTS[s.row]]
        entries += [query_for(s, params, x, inside) for params, x, inside in QUERIES[s.row]]
    # JSON has no infinities among its numbers: digits() made them strings.
    lines = ",\n".join(json.dumps(e, allow_nan=False) for e in entries)
    OUTPUT.write_text("[\n" + lines + "\n]\n")
    print(f"{len(entries)} entries, {OUTPUT.stat().st_size} bytes")


if __name__ == "__main__":
    main()
