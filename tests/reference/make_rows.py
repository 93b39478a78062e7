"""Reference values and condition numbers of samplers with branches, roots and several preimages.

    pip install -r tests/reference/requirements.txt
    python3 tests/reference/make_rows.py

Writes catalogue-mh.json: the fields of catalogue-e.json, in double precision only. Everything but
the samplers is make_conditions.py's, at 400 digits instead of 80: the uniform 1e-300 is added to
1 here, and what it changes must have digits left. A coordinate that is below all of them, such as
the cosine of a rounded quarter turn, is an exact 0.
"""

import json
import pathlib

from mpmath import (acos, asin, asinh, atan2, betainc, cbrt, cos, cosh, cot, erfc, exp, expm1, floor, inf, lambertw, log, log1p, loggamma, mp, mpf,
                    pi, sign, sin, sinh, sqrt, tan, tanh)

from make_conditions import (BELOW_ONE, F64, TINY, Sampler, digits, dot, entry_for, from_height, linear, logistic_density, logit, norm,
                             on_circle, over, query_for, real_power, to_unit_sphere, unit)

mp.dps = 400
NOISE = mpf(10) ** -390
OUTPUT = pathlib.Path(__file__).resolve().parent / "catalogue-mh.json"


def sub(a, b):
    """Difference of vectors."""
    return [s - t for s, t in zip(a, b)]


def cross(a, b):
    """Vector product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def combine(*terms):
    """Sum of multiples of vectors."""
    return [sum(k * v[i] for k, v in terms) for i in range(len(terms[0][1]))]


def turn(t):
    """An angle as a fraction of a turn, in [0, 1)."""
    t = t / (2 * pi)
    return t - floor(t)


# --- the line ---------------------------------------------------------------


def tent(u, p):
    """Row 6."""
    r = p["r"]
    return [r * (sqrt(2 * u[0]) - 1) if u[0] < 0.5 else r * (1 - sqrt(2 * (1 - u[0])))]


def triangular(u, p):
    """Row 7."""
    a, b, c = p["a"], p["b"], p["c"]
    below = u[0] * (c - a) < b - a
    return [a + sqrt(u[0] * (c - a) * (b - a)) if below else c - sqrt((1 - u[0]) * (c - a) * (c - b))]


def triangular_density(x, p):
    """Row 7."""
    a, b, c = p["a"], p["b"], p["c"]
    return 2 * ((x[0] - a) / (b - a) if x[0] < b else (c - x[0]) / (c - b)) / (c - a)


def student_tail(x, p):
    """Row 16: the probability of more than x > 0."""
    nu = p["nu"]
    if nu < 100:
        return betainc(nu / 2, mpf(1) / 2, 0, nu / (nu + x * x), regularized=True) / 2
    # That series has too many terms; this one, of the rest to one, takes more digits.
    with mp.workdps(mp.dps + 40):
        a, b, y = mpf(1) / 2, nu / 2, x * x / (nu + x * x)
        term = total = mpf(1)
        for n in range(10000):
            term *= (a + b + n) / (a + 1 + n) * y
            total += term
            if term < total * mpf(10) ** -mp.dps:
                break
        size = loggamma(a + b) - loggamma(a + 1) - loggamma(b)
        return (1 - exp(a * log(y) + b * log1p(-y) + size) * total) / 2


def student_density(x, p):
    """Row 16."""
    nu = p["nu"]
    return exp(loggamma((nu + 1) / 2) - loggamma(nu / 2) - (nu + 1) / 2 * log1p(x[0] ** 2 / nu)) / sqrt(nu * pi)


def student(u, p):
    """Row 16: Newton's method on the logarithm of the tail, which falls and is concave in ln x."""
    q = min(u[0], 1 - u[0])
    if u[0] == 0.5:
        return [mpf(0)]
    x = mpf(1)
    for _ in range(400):
        tail = student_tail(x, p)
        step = log(tail / q) * tail / (x * student_density([x], p))
        # Far out, the tail of many degrees of freedom is nothing.
        x *= exp(step if p["nu"] < 100 else min(step, 1 / (1 + x)))
        if abs(step) < mpf(10) ** (-mp.dps // 2 - 20):
            return [x if u[0] > 0.5 else -x]
    raise ArithmeticError((u, p))


def laplace(u, p):
    """Row 17."""
    return [p["b"] * log(2 * u[0]) if u[0] < 0.5 else -p["b"] * log(2 * (1 - u[0]))]


def rational_quadratic(u, p):
    """Row 32, one segment."""
    t, s, d0, d1 = u[0], p["s"], p["d0"], p["d1"]
    return [s * (s * t**2 + d0 * t * (1 - t)) / (s + (d1 + d0 - 2 * s) * t * (1 - t))]


def rational_quadratic_density(x, p):
    """Row 32: the parameter by the conjugate root, and the reciprocal of the derivative."""
    s, d0, d1 = p["s"], p["d0"], p["d1"]
    k = d1 + d0 - 2 * s
    a, b, c = s * (s - d0) + x[0] * k, s * d0 - x[0] * k, -s * x[0]
    t = 2 * c / (-b - sqrt(b * b - 4 * a * c))
    return (s + k * t * (1 - t)) ** 2 / (s**2 * (d1 * t**2 + 2 * s * t * (1 - t) + d0 * (1 - t) ** 2))


def teeth(x, p):
    """Row 35: the preimages."""
    return [[(x[0] + j) / p["k"]] for j in range(int(floor(p["k"])) + 1) if x[0] + j < p["k"]]


def cosine_preimages(x, p):
    """Row 33."""
    return [[acos(x[0]) / (2 * pi)], [1 - acos(x[0]) / (2 * pi)]]


def cubic_angle(x):
    """Row 36: a third of the angle with cosine 1 - 32 x; the cubic of (1 - cos t) / 2 is (1 - cos 3t) / 32."""
    return acos(1 - 32 * x[0]) / 3


def cubic_preimages(x, p):
    """Row 36."""
    t = cubic_angle(x)
    return [[sin(a / 2) ** 2] for a in (t, 2 * pi / 3 - t, 2 * pi / 3 + t)]


def cubic_density(x, p):
    """Row 36: the sum over the three preimages."""
    return 4 * sin(cubic_angle(x) + pi / 3) / (3 * sqrt(x[0] * (1 - 16 * x[0])))


def increasing_root(f, slope, target, low, high):
    """Where an increasing function has the value: Newton's method in a bracket, which is halved where that leaves it."""
    if f(low) >= target:
        return low
    t = (low + high) / 2
    for _ in range(5000):
        gap = f(t) - target
        low, high = (low, t) if gap > 0 else (t, high)
        step = gap / slope(t)
        if not low <= t - step <= high:
            step = t - (low + high) / 2
        t -= step
        if abs(step) <= abs(t) * mpf(10) ** (-mp.dps // 2 - 20):
            return t
    raise ArithmeticError((target, low, high))


def smoothstep(u, p):
    """Row 8."""
    t = increasing_root(lambda t: 2 * t**3 - t**4, lambda t: 6 * t**2 - 4 * t**3, u[0], mpf(0), mpf(1))
    return [p["a"] + (p["b"] - p["a"]) * t]


def smoothstep_density(x, p):
    """Row 8."""
    t = (x[0] - p["a"]) / (p["b"] - p["a"])
    return 2 * t**2 * (3 - 2 * t) / abs(p["b"] - p["a"])


def logistic(u, p):
    """Row 10."""
    return [p["s"] * logit(u[0])]


def truncated_logistic(u, p):
    """Row 11: the odds, by the probabilities of both tails."""
    s, a, b = p["s"], p["a"], p["b"]
    below = (1 - u[0]) / (1 + exp(-a / s)) + u[0] / (1 + exp(-b / s))
    above = (1 - u[0]) / (1 + exp(a / s)) + u[0] / (1 + exp(b / s))
    return [s * log(below / above)]


def truncated_logistic_density(x, p):
    """Row 11: the mass between a and b is sinh((b - a) / 2 s) / (2 cosh(a / 2 s) cosh(b / 2 s))."""
    s, a, b = p["s"], p["a"], p["b"]
    mass = sinh((b - a) / (2 * s)) / (2 * cosh(a / (2 * s)) * cosh(b / (2 * s)))
    return logistic_density(x[0] / s) / (s * mass)


def normal_tail(x):
    """The probability of a standard normal variable below x."""
    return erfc(-x / sqrt(mpf(2))) / 2


def normal_point(x):
    """The standard normal density."""
    return exp(-x * x / 2) / sqrt(2 * pi)


def normal_quantile(q):
    """Newton's method on the logarithm of the tail, which is concave."""
    if q > 0.5:
        return -normal_quantile(1 - q)
    x = -sqrt(-2 * log(q)) if q < 0.4 else mpf(0)
    for _ in range(400):
        tail = normal_tail(x)
        step = log(tail / q) * tail / normal_point(x)
        x -= step
        if abs(step) < mpf(10) ** (-mp.dps // 2 - 20):
            return x
    raise ArithmeticError(q)


def normal(u, p):
    """Row 12."""
    return [p["m"] + p["s"] * normal_quantile(u[0])]


def lower_normal(u, p):
    """Row 13."""
    return [normal_quantile((1 - u[0]) * normal_tail(p["a"]) + u[0] * normal_tail(p["b"]))]


def upper_normal(u, p):
    """Row 13, of the probabilities above."""
    return [-lower_normal(u, {"a": -p["a"], "b": -p["b"]})[0]]


def lower_normal_density(x, p):
    """Row 13."""
    return normal_point(x[0]) / (normal_tail(p["b"]) - normal_tail(p["a"]))


def upper_normal_density(x, p):
    """Row 13, of the probabilities above."""
    return normal_point(x[0]) / (normal_tail(-p["a"]) - normal_tail(-p["b"]))


def pareto_density(x, p):
    """Row 20."""
    return exp(-log1p(p["xi"] * (x[0] - p["m"]) / p["s"]) * (1 / p["xi"] + 1)) / p["s"]


def kumaraswamy(u, p):
    """Row 21."""
    return [real_power(-expm1(log1p(-u[0]) / p["b"]), 1 / p["a"])]


def kumaraswamy_density(x, p):
    """Row 21."""
    a, b = p["a"], p["b"]
    return a * b * real_power(x[0], a - 1) * real_power(1 - real_power(x[0], a), b - 1)


def power_law(u, p):
    """Row 22."""
    k = 1 - p["p"]
    return [p["a"] * exp(log1p(u[0] * expm1(k * log(p["b"] / p["a"]))) / k)]


def power_law_density(x, p):
    """Row 22."""
    k, a = 1 - p["p"], p["a"]
    return k * real_power(x[0] / a, -p["p"]) / (a * expm1(k * log(p["b"] / a)))


def sinh_arcsinh_density(x, p):
    """Row 24."""
    t = asinh(x[0]) / p["d"] - p["e"]
    return logistic_density(sinh(t)) * cosh(t) / (p["d"] * sqrt(1 + x[0] ** 2))


def heavy_tails(u, p):
    """Row 25."""
    z = logit(u[0])
    return [z * exp(p["h"] * z * z / 2)]


def heavy_tails_density(x, p):
    """Row 25."""
    h = p["h"]
    z = sign(x[0]) * sqrt(lambertw(h * x[0] ** 2).real / h)
    return logistic_density(z) * exp(-h * z * z / 2) / (1 + h * z * z)


def width_of_view(p):
    """Row 26: the angle under which the light sees the range."""
    return atan2((p["b"] - p["a"]) * p["d"], p["d"] ** 2 + p["a"] * p["b"])


def linear_extinction(u, p):
    """Row 28."""
    tau = -log1p(-u[0])
    return [2 * tau / (p["a"] + sqrt(p["a"] ** 2 + 2 * p["b"] * tau))]


def falling_extinction_density(x, p):
    """Row 29."""
    k, h = p["k"], p["h"]
    return k * exp(-h * x[0]) * exp(k * expm1(-h * x[0]) / h)


def kepler(u, p):
    """Row 37."""
    e = p["e"]
    return [increasing_root(lambda t: t - e * sin(t), lambda t: 1 - e * cos(t), 2 * pi * u[0], mpf(0), 2 * pi)]


def hyperexponential(u, p):
    """Row 38."""
    w, l, m = p["p"], p["l"], p["m"]
    below = lambda x: -w * expm1(-l * x) - (1 - w) * expm1(-m * x)
    high = mpf(1)
    while below(high) < u[0]:
        high *= 2
    return [increasing_root(below, lambda x: hyperexponential_density([x], p), u[0], mpf(0), high)]


def hyperexponential_density(x, p):
    """Row 38."""
    w, l, m = p["p"], p["l"], p["m"]
    return w * l * exp(-l * x[0]) + (1 - w) * m * exp(-m * x[0])


def positive(x, p):
    """On the half line."""
    return x[0] >= 0


def between(x, p):
    """Between a and b."""
    return min(p["a"], p["b"]) <= x[0] <= max(p["a"], p["b"])


def within(low, high):
    """The interval as a support."""
    return lambda x, p: low <= x[0] <= high


LINE = [
    Sampler(6, "tent", tent, lambda x, p: (p["r"] - abs(x[0])) / p["r"] ** 2, lambda x, p: abs(x[0]) <= p["r"]),
    Sampler(7, "triangular", triangular, triangular_density, lambda x, p: p["a"] <= x[0] <= p["c"]),
    Sampler(15, "student_2", lambda u, p: [(2 * u[0] - 1) / sqrt(2 * u[0] * (1 - u[0]))],
            lambda x, p: (2 + x[0] ** 2) ** mpf(-1.5)),
    Sampler(16, "student", student, student_density),
    Sampler(17, "laplace", laplace, lambda x, p: exp(-abs(x[0]) / p["b"]) / (2 * p["b"])),
    Sampler(32, "rational_quadratic", rational_quadratic, rational_quadratic_density,
            lambda x, p: 0 <= x[0] <= p["s"]),
    Sampler(33, "cosine", lambda u, p: [cos(2 * pi * u[0])], lambda x, p: 1 / (pi * sqrt((1 - x[0]) * (1 + x[0]))),
            within(-1, 1), preimages=cosine_preimages),
    Sampler(34, "parabola", lambda u, p: [4 * u[0] * (1 - u[0])], lambda x, p: 1 / (2 * sqrt(1 - x[0])), within(0, 1),
            preimages=lambda x, p: [[(1 - sqrt(1 - x[0])) / 2], [(1 + sqrt(1 - x[0])) / 2]]),
    Sampler(34, "square", lambda u, p: [(2 * u[0] - 1) ** 2], lambda x, p: 1 / (2 * sqrt(x[0])), within(0, 1),
            preimages=lambda x, p: [[(1 - sqrt(x[0])) / 2], [(1 + sqrt(x[0])) / 2]]),
    Sampler(34, "fold", lambda u, p: [abs(2 * u[0] - 1)], lambda x, p: mpf(1), within(0, 1), smooth=lambda u, p: u[0] != 0.5,
            preimages=lambda x, p: [[(1 - x[0]) / 2], [(1 + x[0]) / 2]]),
    Sampler(35, "sawtooth", lambda u, p: [p["k"] * u[0] - floor(p["k"] * u[0])], lambda x, p: len(teeth(x, p)) / p["k"], within(0, 1),
            preimages=teeth, smooth=lambda u, p: u[0] > 1e-20),
    Sampler(36, "cubic", lambda u, p: [u[0] * (u[0] * (u[0] - mpf(3) / 2) + mpf(9) / 16)], cubic_density, within(0, mpf(1) / 16),
            preimages=cubic_preimages, smooth=lambda u, p: u[0] > 1e-20 and u[0] not in (0.25, 0.75)),
    Sampler(8, "smoothstep", smoothstep, smoothstep_density, between),
    Sampler(9, "epanechnikov", lambda u, p: [2 * sin(asin(2 * u[0] - 1) / 3)], lambda x, p: 3 * (1 - x[0]) * (1 + x[0]) / 4, within(-1, 1)),
    Sampler(10, "logistic", logistic, lambda x, p: logistic_density(x[0] / p["s"]) / p["s"]),
    Sampler(11, "truncated_logistic", truncated_logistic, truncated_logistic_density, between),
    Sampler(11, "truncated_logistic_as_printed", truncated_logistic, truncated_logistic_density, between),
    Sampler(12, "normal", normal, lambda x, p: normal_point((x[0] - p["m"]) / p["s"]) / p["s"]),
    Sampler(13, "lower_normal", lower_normal, lower_normal_density, between),
    Sampler(13, "upper_normal", upper_normal, upper_normal_density, between),
    Sampler(14, "cauchy", lambda u, p: [-p["g"] * cot(pi * u[0])], lambda x, p: p["g"] / (pi * (p["g"] ** 2 + x[0] ** 2))),
    Sampler(20, "pareto", lambda u, p: [p["m"] + p["s"] * expm1(-p["xi"] * log1p(-u[0])) / p["xi"]], pareto_density,
            lambda x, p: x[0] >= p["m"] and p["xi"] * (x[0] - p["m"]) > -p["s"]),
    Sampler(21, "kumaraswamy", kumaraswamy, kumaraswamy_density, within(0, 1)),
    Sampler(22, "power_law", power_law, power_law_density, between),
    Sampler(24, "sinh_arcsinh", lambda u, p: [sinh((asinh(logit(u[0])) + p["e"]) * p["d"])], sinh_arcsinh_density),
    Sampler(25, "heavy_tails", heavy_tails, heavy_tails_density),
    Sampler(26, "equiangular", lambda u, p: [p["d"] * tan(atan2(p["a"], p["d"]) + u[0] * width_of_view(p))],
            lambda x, p: p["d"] / (width_of_view(p) * (p["d"] ** 2 + x[0] ** 2)), between),
    Sampler(28, "linear_extinction", linear_extinction,
            lambda x, p: (p["a"] + p["b"] * x[0]) * exp(-p["a"] * x[0] - p["b"] * x[0] ** 2 / 2), positive),
    Sampler(29, "falling_extinction", lambda u, p: [-log1p(p["h"] * log1p(-u[0]) / p["k"]) / p["h"]], falling_extinction_density, positive),
    Sampler(37, "kepler", kepler, lambda x, p: (1 - p["e"] * cos(x[0])) / (2 * pi), lambda x, p: 0 <= x[0] <= 2 * pi),
    Sampler(38, "hyperexponential", hyperexponential, hyperexponential_density, positive),
]

# --- the plane --------------------------------------------------------------


def concentric(u, p=None):
    """Row 43."""
    a, b = 2 * u[0] - 1, 2 * u[1] - 1
    if a == 0 and b == 0:
        return [mpf(0), mpf(0)]
    r, t = (a, pi / 4 * b / a) if abs(a) > abs(b) else (b, pi / 2 - pi / 4 * a / b)
    return [r * cos(t), r * sin(t)]


def off_diagonals(u, p):
    """Row 43: where the map has derivatives."""
    return abs(2 * u[0] - 1) != abs(2 * u[1] - 1)


def in_sector(x, p):
    """Row 44."""
    return p["a"] <= norm(x) <= p["b"] and turn(atan2(x[1], x[0]) - p["p"]) * 2 * pi <= p["d"]


def annular_sector(u, p):
    """Row 44."""
    r, t = sqrt((1 - u[0]) * p["a"] ** 2 + u[0] * p["b"] ** 2), p["p"] + p["d"] * u[1]
    return [r * cos(t), r * sin(t)]


def normals(u):
    """Two independent standard normal variables."""
    return on_circle(sqrt(-2 * log1p(-u[0])), u[1])


def bivariate_normal(u, p):
    """Row 50."""
    x, y = normals(u)
    return [p["l11"] * x, p["l21"] * x + p["l22"] * y]


def bivariate_normal_density(x, p):
    """Row 50."""
    z = x[0] / p["l11"]
    w = (x[1] - p["l21"] * z) / p["l22"]
    return exp(-(z * z + w * w) / 2) / (2 * pi * p["l11"] * p["l22"])


def corners(p):
    """Row 54."""
    return [[p[k + "x"], p[k + "y"]] for k in "abcd"]


def bilinear_quad(u, p):
    """Row 54."""
    s, t = u
    a, b, c, d = corners(p)
    return combine(((1 - s) * (1 - t), a), (s * (1 - t), b), (s * t, c), ((1 - s) * t, d))


def wedge(a, b):
    """Vector product of the plane."""
    return a[0] * b[1] - a[1] * b[0]


def bilinear_quad_inverse(x, p):
    """Row 54: the root inside of the quadratic for t."""
    a, b, c, d = corners(p)
    e, f, g, h = sub(b, a), sub(d, a), combine((1, a), (-1, b), (1, c), (-1, d)), sub(x, a)
    k2, k1, k0 = wedge(g, f), wedge(e, f) + wedge(h, g), wedge(h, e)
    found = []
    for side in (-1, 1):
        bottom = -k1 + side * sqrt(k1 * k1 - 4 * k0 * k2)
        if bottom == 0:
            continue
        t = 2 * k0 / bottom
        q = combine((1, e), (t, g))
        i = 0 if abs(q[0]) > abs(q[1]) else 1
        s = (h[i] - f[i] * t) / q[i]
        found.append([s, t])
    return min(found, key=lambda v: max(abs(v[0] - 0.5), abs(v[1] - 0.5)))


def bilinear_quad_density(x, p):
    """Row 54."""
    a, b, c, d = corners(p)
    e, f, g = sub(b, a), sub(d, a), combine((1, a), (-1, b), (1, c), (-1, d))
    s, t = bilinear_quad_inverse(x, p)
    return 1 / abs(wedge(combine((1, e), (t, g)), combine((1, f), (s, g))))


def radial_flow(u, p):
    """Row 116."""
    z = normals(u)
    return combine((1 + p["beta"] / (p["alpha"] + norm(z)), z))


def radial_flow_density(x, p):
    """Row 116."""
    al, be = p["alpha"], p["beta"]
    g = norm(x)
    a = al + be - g
    r = (sqrt(a * a + 4 * al * g) - a) / 2
    return exp(-r * r / 2) / (2 * pi) / ((1 + be / (al + r)) * (1 + be * al / (al + r) ** 2))


def affine_coupling(u, p):
    """Row 117."""
    a = logit(u[0])
    return [a, logit(u[1]) * exp(p["s"] * tanh(a)) + p["t"] * a * a]


def affine_coupling_density(x, p):
    """Row 117."""
    k = exp(-p["s"] * tanh(x[0]))
    return logistic_density(x[0]) * logistic_density((x[1] - p["t"] * x[0] ** 2) * k) * k


def complex_square_preimages(x, p):
    """Row 56."""
    v = turn(atan2(x[1], x[0])) / 2
    return [[norm(x), v], [norm(x), v + mpf(1) / 2]]


def regular_polygon(u, p):
    """Row 52."""
    n = p["n"]
    k = floor(n * u[1])
    t = n * u[1] - k
    a, b = on_circle(mpf(1), k / n), on_circle(mpf(1), (k + 1) / n)
    return combine((sqrt(u[0]) * (1 - t), a), (sqrt(u[0]) * t, b))


def pentagon(u, p):
    """Row 52."""
    return regular_polygon(u, {"n": mpf(5)})


def elliptical_grid(u, p):
    """Row 46."""
    a, b = 2 * u[0] - 1, 2 * u[1] - 1
    return [a * sqrt(1 - b * b / 2), b * sqrt(1 - a * a / 2)]


def elliptical_grid_density(x, p):
    """Row 46: by the closed inverse."""
    d, root = x[0] ** 2 - x[1] ** 2, sqrt(mpf(8))
    a = (sqrt(2 + d + root * x[0]) - sqrt(2 + d - root * x[0])) / 2
    b = (sqrt(2 - d + root * x[1]) - sqrt(2 - d - root * x[1])) / 2
    return sqrt((1 - a * a / 2) * (1 - b * b / 2)) / (4 - 2 * a * a - 2 * b * b)


def complex_square_xy(u, p):
    """Row 56, from uniform points of the disk."""
    x, y = on_circle(sqrt(u[0]), u[1])
    return [x * x - y * y, 2 * x * y]


def bilinear_density(u, p):
    """Row 53."""
    a, b = p["w00"] + p["w10"], p["w01"] + p["w11"]
    y = linear(u[1:], {"a": a, "b": b})[0]
    c, d = (1 - y) * p["w00"] + y * p["w01"], (1 - y) * p["w10"] + y * p["w11"]
    return linear(u[:1], {"a": c, "b": d}) + [y]


def bilinear_density_density(x, p):
    """Row 53."""
    (s, t), w = x, [p[k] for k in ("w00", "w10", "w01", "w11")]
    return 4 * ((1 - t) * ((1 - s) * w[0] + s * w[1]) + t * ((1 - s) * w[2] + s * w[3])) / sum(w)


PLANE = [
    Sampler(46, "elliptical_grid", elliptical_grid, elliptical_grid_density, lambda x, p: norm(x) <= 1),
    Sampler(53, "bilinear_density", bilinear_density, bilinear_density_density, lambda x, p: min(x) >= 0 and max(x) <= 1),
    Sampler(56, "complex_square_xy", complex_square_xy, lambda x, p: 1 / (2 * pi * norm(x)), lambda x, p: norm(x) <= 1,
            preimages=complex_square_preimages),
    Sampler(52, "pentagon", pentagon, lambda x, p: 2 / (5 * sin(2 * pi / 5))),
    Sampler(52, "regular_polygon", regular_polygon, lambda x, p: 2 / (p["n"] * sin(2 * pi / p["n"]))),
    Sampler(43, "concentric_disk", concentric, lambda x, p: 1 / pi, lambda x, p: norm(x) <= 1,
            smooth=off_diagonals),
    Sampler(44, "annular_sector", annular_sector, lambda x, p: 2 / (p["d"] * (p["b"] - p["a"]) * (p["b"] + p["a"])), in_sector),
    Sampler(50, "bivariate_normal", bivariate_normal, bivariate_normal_density),
    Sampler(51, "ggx_slopes", lambda u, p: on_circle(p["alpha"] * sqrt(u[0] / (1 - u[0])), u[1]),
            lambda x, p: 1 / (pi * p["alpha"] ** 2 * (1 + dot(x, x) / p["alpha"] ** 2) ** 2)),
    Sampler(54, "bilinear_quad", bilinear_quad, bilinear_quad_density),
    Sampler(56, "complex_square", lambda u, p: on_circle(u[0], 2 * u[1]),
            lambda x, p: 1 / (2 * pi * norm(x)) if norm(x) else inf, lambda x, p: norm(x) <= 1,
            preimages=complex_square_preimages),
    Sampler(116, "radial_flow", radial_flow, radial_flow_density),
    Sampler(117, "affine_coupling", affine_coupling, affine_coupling_density),
]

# --- directions -------------------------------------------------------------


def concentric_hemisphere(u, p):
    """Row 66."""
    x, y = concentric(u)
    q = x * x + y * y
    return [x * sqrt(2 - q), y * sqrt(2 - q), 1 - q]


def from_depth(h, v):
    """The direction at height 1 - h and azimuth 2 pi v."""
    return on_circle(sqrt(max(mpf(0), h * (2 - h))), v) + [1 - h]


def double_lune(u, p):
    """Row 69."""
    t = 4 * p["t"] * u[0] - p["t"] if u[0] < 0.5 else 4 * p["t"] * u[0] + pi - 3 * p["t"]
    return from_height(1 - 2 * u[1], t / (2 * pi))


def von_mises_fisher_density(x, p):
    """Row 74."""
    return p["kappa"] * exp(p["kappa"] * depth(x) * -1) / (-2 * pi * expm1(-2 * p["kappa"]))


def depth(x):
    """1 - z of a direction, from all of its coordinates."""
    return 1 - x[2] if x[2] < 0.5 else (x[0] ** 2 + x[1] ** 2) / (1 + x[2])


def henyey_greenstein(u, p):
    """Row 75."""
    g = p["g"]
    return from_depth(2 * (1 - g) ** 2 * (1 - u[0]) * (1 + g * u[0]) / (1 - g + 2 * g * u[0]) ** 2, u[1])


def henyey_greenstein_density(x, p):
    """Row 75."""
    g = p["g"]
    return (1 - g * g) / (4 * pi * ((1 - g) ** 2 + 2 * g * depth(x)) ** mpf(1.5))


def columns(p):
    """Row 77: the columns of the matrix."""
    return p["a"], p["b"], p["c"]


def transformed_cosine(u, p):
    """Row 77."""
    w = on_circle(sqrt(u[0]), u[1]) + [sqrt(1 - u[0])]
    return unit(combine(*zip(w, columns(p))))


def transformed_cosine_density(x, p):
    """Row 77."""
    a, b, c = columns(p)
    det = dot(a, cross(b, c))
    w = [dot(x, cross(b, c)) / det, dot(x, cross(c, a)) / det, dot(x, cross(a, b)) / det]
    return w[2] / (pi * abs(det) * norm(w) ** 4)


def transformed_upper(x, p):
    """Row 77."""
    a, b, c = columns(p)
    return dot(x, cross(a, b)) * dot(a, cross(b, c)) >= 0


def beckmann(u, p):
    """Row 81."""
    return unit(on_circle(p["alpha"] * sqrt(-log1p(-u[0])), u[1]) + [mpf(1)])


def beckmann_density(x, p):
    """Row 81."""
    return exp(-(x[0] ** 2 + x[1] ** 2) / (x[2] * p["alpha"]) ** 2) / (pi * p["alpha"] ** 2 * x[2] ** 3)


def ggx(u, p):
    """Rows 82 and 83."""
    x, y = on_circle(sqrt(u[0] / (1 - u[0])), u[1])
    return unit([p.get("ax", p.get("alpha")) * x, p.get("ay", p.get("alpha")) * y, mpf(1)])


def ggx_density(x, p):
    """Rows 82 and 83."""
    ax, ay = p.get("ax", p.get("alpha")), p.get("ay", p.get("alpha"))
    return x[2] / (pi * ax * ay * ((x[0] / ax) ** 2 + (x[1] / ay) ** 2 + x[2] ** 2) ** 2)


def ashikhmin_shirley(u, p):
    """Row 84."""
    nu, nv, t = p["nu"], p["nv"], 2 * pi * u[1]
    phi = atan2(sqrt(nu + 1) * sin(t), sqrt(nv + 1) * cos(t))
    n = nu * cos(phi) ** 2 + nv * sin(phi) ** 2
    return from_height((1 - u[0]) ** (1 / (n + 1)), phi / (2 * pi))


def ashikhmin_shirley_density(x, p):
    """Row 84."""
    nu, nv = p["nu"], p["nv"]
    r = x[0] ** 2 + x[1] ** 2
    n = (nu * x[0] ** 2 + nv * x[1] ** 2) / r if r else mpf(0)
    return sqrt((nu + 1) * (nv + 1)) / (2 * pi) * real_power(1 - depth(x), n)


def mixture(u, p):
    """Row 91."""
    if u[0] < p["p"]:
        return from_height(real_power(u[0] / p["p"], 1 / (p["n"] + 1)), u[1])
    v = (u[0] - p["p"]) / (1 - p["p"])
    return on_circle(sqrt(v), u[1]) + [sqrt(1 - v)]


def mixture_density(x, p):
    """Row 91."""
    return p["p"] * (p["n"] + 1) / (2 * pi) * real_power(x[2], p["n"]) + (1 - p["p"]) * x[2] / pi


def mixture_preimages(x, p):
    """Row 91."""
    v = turn(atan2(x[1], x[0]))
    return [[p["p"] * x[2] ** (p["n"] + 1), v], [p["p"] + (1 - p["p"]) * (x[0] ** 2 + x[1] ** 2), v]]


def sheen(u, p):
    """Row 92."""
    s = real_power(u[0], p["alpha"] / (2 * p["alpha"] + 1))
    return on_circle(s, u[1]) + [sqrt((1 - s) * (1 + s))]


def sheen_density(x, p):
    """Row 92."""
    return (2 + 1 / p["alpha"]) * real_power(norm(x[:2]), 1 / p["alpha"]) * x[2] / (2 * pi)


def octahedral(u, p):
    """Row 67."""
    a, b = 2 * u[0] - 1, 2 * u[1] - 1
    s = 1 - abs(a) - abs(b)
    r = 1 - abs(s)
    phi = pi / 4 * ((abs(b) - abs(a)) / r + 1)
    h, one = r * sqrt(2 - r * r), lambda t: -1 if t < 0 else 1
    return [one(a) * h * cos(phi), one(b) * h * sin(phi), one(s) * (1 - r * r)]


def view(p):
    """The direction w: a vector of any length stands for the one along it, one of length one to rounding for itself."""
    w = p["w"]
    return w if abs(dot(w, w) - 1) < mpf(2) ** -48 else unit(w)


def roughness(p):
    """Along both axes."""
    return p.get("alpha_x", p.get("alpha")), p.get("alpha_y", p.get("alpha"))


def stretched(p):
    """Rows 85 and 86: the direction in which facets of roughness one are seen alike."""
    (x, y, z), (ax, ay) = view(p), roughness(p)
    return unit([ax * x, ay * y, z])


def flattened(n, p):
    """Rows 85 and 86: a normal of facets of roughness one as that of these."""
    ax, ay = roughness(p)
    return unit([ax * n[0], ay * n[1], n[2]])


def heitz_normals(u, p):
    """Row 85: a point of the disk, moved into the half of it that is seen."""
    v = stretched(p)
    t1 = unit([-v[1], v[0], mpf(0)]) if v[0] != 0 or v[1] != 0 else [mpf(1), mpf(0), mpf(0)]
    a, b = on_circle(sqrt(u[0]), u[1])
    s = (1 + v[2]) / 2
    b = (1 - s) * sqrt(1 - a * a) + s * b
    n = combine((a, t1), (b, cross(v, t1)), (sqrt(1 - a * a - b * b), v))
    return flattened(n, p)


def visible_normals(u, p):
    """Row 86: a point of the spherical cap, added to the stretched direction."""
    v = stretched(p)
    n = unit(combine((1, from_height(1 - u[1] * (1 + v[2]), u[0])), (1, v)))
    return flattened(n, p)


def visible_normals_density(x, p):
    """Rows 85 and 86: 2 max(0, w . h) D(h) / (w.z + the length of the stretched w)."""
    (ax, ay), w = roughness(p), view(p)
    d = 1 / (pi * ax * ay * ((x[0] / ax) ** 2 + (x[1] / ay) ** 2 + x[2] ** 2) ** 2)
    return 2 * dot(w, x) * d / (w[2] + norm([ax * w[0], ay * w[1], w[2]]))


def is_visible(x, p):
    """Rows 85 and 86."""
    return x[2] >= 0 and dot(x, view(p)) >= 0


def angle(x):
    """Between a direction and +z."""
    return atan2(norm(x[:2]), x[2])


def small_angles(u, p):
    """Row 108."""
    t = p["r1"] * real_power(p["r2"] / p["r1"], u[0])
    return on_circle(sin(t), u[1]) + [cos(t)]


def small_angles_density(x, p):
    """Row 108."""
    return 1 / (2 * pi * log(p["r2"] / p["r1"]) * angle(x) * norm(x[:2]))


def half_of_reflection(x, p):
    """Row 89: the half vector, on the upper side."""
    h = unit(combine((1, x), (1, view(p))))
    return h if h[2] >= 0 else combine((-1, h))


def reflected_ggx(u, p):
    """Row 89."""
    h = ggx(u, p)
    return combine((2 * dot(h, view(p)), h), (-1, view(p)))


def reflected_ggx_density(x, p):
    """Row 89."""
    h = half_of_reflection(x, p)
    return ggx_density(h, p) / (4 * abs(dot(view(p), h)))


def half_of_refraction(x, p):
    """Row 90: the half vector on the side of w."""
    h = unit(combine((p["eta"], x), (1, view(p))))
    return h if p["eta"] < 1 else combine((-1, h))


def refracted_ggx(u, p):
    """Row 90."""
    h = ggx(u, p)
    c = dot(h, view(p))
    root = sqrt(1 - (1 - c * c) / p["eta"] ** 2)
    return combine((c / p["eta"] - root, h), (-1 / p["eta"], view(p)))


def refracted_ggx_density(x, p):
    """Row 90."""
    h = half_of_refraction(x, p)
    inner, outer = dot(view(p), h), p["eta"] * dot(x, h)
    return ggx_density(h, p) * p["eta"] * abs(outer) / (inner + outer) ** 2


def is_refracted(x, p):
    """Row 90: the half vector is above the surface, w and x on its two sides."""
    h = half_of_refraction(x, p)
    return h[2] >= 0 and dot(view(p), h) >= 0 and dot(x, h) <= 0


def in_view(x, p):
    """Row 99."""
    return x[2] > 0 and abs(x[0] / x[2]) <= p["t"] and abs(x[1] / x[2]) <= p["t"] * p["a"]


def upper(x, p):
    """On the upper half of the sphere."""
    return x[2] >= 0


def corner_directions(p):
    """Row 70: the corners, on the sphere."""
    return [unit(p[k]) for k in "abc"]


def solid_angle_of_triangle(p):
    """Row 70: by Van Oosterom and Strackee."""
    a, b, c = corner_directions(p)
    return 2 * atan2(abs(dot(a, cross(b, c))), 1 + dot(a, b) + dot(b, c) + dot(c, a))


def seen_triangle(u, p):
    """Row 70: as Arvo prints it, by the angle at a."""
    a, b, c = corner_directions(p)
    s, t = unit(cross(a, b)), unit(cross(a, c))
    ca, sa = dot(s, t), norm(cross(s, t))
    psi = u[0] * solid_angle_of_triangle(p) - atan2(sa, ca)
    q, w = cos(psi) - ca, sin(psi) + sa * dot(a, b)
    k = ((w * cos(psi) - q * sin(psi)) * ca - w) / ((w * sin(psi) + q * cos(psi)) * sa)
    end = combine((k, a), (sqrt((1 - k) * (1 + k)), unit(combine((1, c), (-dot(c, a), a)))))
    z = 1 - u[1] * (1 - dot(end, b))
    if z == 1:
        return b
    return combine((z, b), (sqrt((1 - z) * (1 + z)), unit(combine((1, end), (-dot(end, b), b)))))


def in_seen_triangle(x, p):
    """Row 70: on the inner side of all three planes."""
    a, b, c = corner_directions(p)
    turn = dot(a, cross(b, c))
    return all(dot(x, cross(s, t)) * turn >= 0 for s, t in ((a, b), (b, c), (c, a)))


def seen_corners(p):
    """Row 71: the angles at the corners, and the heights of the normals of the planes of the lower and the upper side."""
    x0, y0, x1, y1, z0 = [p[k] for k in ("x0", "y0", "x1", "y1", "z0")]
    corners = [[x0, y0, z0], [x1, y0, z0], [x1, y1, z0], [x0, y1, z0]]
    normals = [unit(cross(corners[i], corners[(i + 1) % 4])) for i in range(4)]
    angles = [acos(-dot(normals[i], normals[(i + 1) % 4])) for i in range(4)]
    return angles, normals[0][2], normals[2][2]


def seen_rectangle(u, p):
    """Row 71: as Urena, Fajardo and King print it."""
    angles, b0, b1 = seen_corners(p)
    z0 = p["z0"]
    turn = u[0] * (sum(angles) - 2 * pi) + 2 * pi - angles[2] - angles[3]
    f = (cos(turn) * b0 - b1) / sin(turn)
    c = sign(f) / sqrt(f * f + b0 * b0)
    x = -c * z0 / sqrt((1 - c) * (1 + c))
    d = sqrt(x * x + z0 * z0)
    low, high = [y / sqrt(d * d + y * y) for y in (p["y0"], p["y1"])]
    h = (1 - u[1]) * low + u[1] * high
    return unit([x, h * d / sqrt((1 - h) * (1 + h)), z0])


def in_seen_rectangle(x, p):
    """Row 71."""
    if x[2] >= 0:
        return False
    s, t = [x[i] * p["z0"] / x[2] for i in range(2)]
    return p["x0"] <= s <= p["x1"] and p["y0"] <= t <= p["y1"]


def rayleigh(u, p):
    """Row 76, by the real root of c^3 + 3 c + 4 = 8 u."""
    b = 4 * u[0] - 2
    t = cbrt(abs(b) + sqrt(b * b + 1))
    c = t - 1 / t
    return from_height(mpf(-1) if u[0] == 0 else c if b > 0 else -c, u[1])


DIRECTIONS = [
    Sampler(67, "equal_area_octahedral", octahedral, lambda x, p: 1 / (4 * pi), project=to_unit_sphere,
            smooth=lambda u, p: 0.5 not in u and abs(2 * u[0] - 1) + abs(2 * u[1] - 1) != 1),
    Sampler(85, "heitz_normals", heitz_normals, visible_normals_density, is_visible, to_unit_sphere),
    Sampler(86, "visible_normals", visible_normals, visible_normals_density, is_visible, to_unit_sphere),
    Sampler(85, "anisotropic_normals_as_printed", heitz_normals, visible_normals_density, is_visible, to_unit_sphere),
    Sampler(86, "anisotropic_normals", visible_normals, visible_normals_density, is_visible, to_unit_sphere),
    Sampler(70, "seen_triangle", seen_triangle, lambda x, p: 1 / solid_angle_of_triangle(p), in_seen_triangle, to_unit_sphere),
    Sampler(71, "seen_rectangle", seen_rectangle, lambda x, p: 1 / (sum(seen_corners(p)[0]) - 2 * pi), in_seen_rectangle, to_unit_sphere),
    Sampler(108, "small_angles", small_angles, small_angles_density, lambda x, p: p["r1"] <= angle(x) <= p["r2"], to_unit_sphere),
    Sampler(89, "reflected_ggx", reflected_ggx, reflected_ggx_density, project=to_unit_sphere),
    Sampler(90, "refracted_ggx", refracted_ggx, refracted_ggx_density, is_refracted, to_unit_sphere),
    Sampler(76, "rayleigh", rayleigh, lambda x, p: 3 * (1 + (1 - depth(x)) ** 2) / (16 * pi), project=to_unit_sphere),
    Sampler(68, "zonal_window", lambda u, p: from_height((1 - u[0]) * p["z0"] + u[0] * p["z1"], (p["p"] + p["d"] * u[1]) / (2 * pi)),
            lambda x, p: 1 / ((p["z1"] - p["z0"]) * p["d"]), lambda x, p: p["z0"] <= x[2] <= p["z1"], to_unit_sphere),
    Sampler(65, "cone", lambda u, p: from_depth(p["m"] * u[0], u[1]), lambda x, p: 1 / (2 * pi * p["m"]),
            lambda x, p: depth(x) <= p["m"], to_unit_sphere),
    Sampler(66, "concentric_hemisphere", concentric_hemisphere, lambda x, p: 1 / (2 * pi), upper, to_unit_sphere,
            smooth=off_diagonals),
    Sampler(69, "double_lune", double_lune, lambda x, p: 1 / (8 * p["t"]),
            lambda x, p: abs(atan2(x[1], abs(x[0]))) <= p["t"], to_unit_sphere,
            smooth=lambda u, p: u[0] != 0.5),
    Sampler(74, "von_mises_fisher", lambda u, p: from_depth(-log1p((1 - u[0]) * expm1(-2 * p["kappa"])) / p["kappa"], u[1]),
            von_mises_fisher_density, project=to_unit_sphere),
    Sampler(75, "henyey_greenstein", henyey_greenstein, henyey_greenstein_density, project=to_unit_sphere),
    Sampler(77, "transformed_cosine", transformed_cosine, transformed_cosine_density, transformed_upper, to_unit_sphere),
    Sampler(81, "beckmann", beckmann, beckmann_density, upper, to_unit_sphere),
    Sampler(82, "ggx", ggx, ggx_density, upper, to_unit_sphere),
    Sampler(83, "anisotropic_ggx", ggx, ggx_density, upper, to_unit_sphere),
    Sampler(84, "ashikhmin_shirley", ashikhmin_shirley, ashikhmin_shirley_density, upper, to_unit_sphere),
    Sampler(91, "mixture", mixture, mixture_density, upper, to_unit_sphere, mixture_preimages,
            lambda u, p: u[0] != p["p"] and 0 < p["p"] < 1),
    Sampler(92, "sheen", sheen, sheen_density, upper, to_unit_sphere),
    Sampler(99, "perspective", lambda u, p: unit([p["t"] * (2 * u[0] - 1), p["t"] * p["a"] * (2 * u[1] - 1), mpf(1)]),
            lambda x, p: 1 / (4 * p["t"] ** 2 * p["a"] * x[2] ** 3), in_view, to_unit_sphere),
]

# --- space ------------------------------------------------------------------


def edges(p):
    """Two edges of a triangle."""
    return sub(p["b"], p["a"]), sub(p["c"], p["a"])


def on_triangle(b1, b2, p):
    """The point with these barycentric coordinates."""
    e, f = edges(p)
    return combine((1, p["a"]), (b1, e), (b2, f))


def barycentric(x, p):
    """The coordinates of the point of the plane below x."""
    (e, f), d = edges(p), sub(x, p["a"])
    n = cross(e, f)
    return dot(cross(d, f), n) / dot(n, n), dot(cross(e, d), n) / dot(n, n)


def triangle(u, p):
    """Row 47."""
    s = sqrt(1 - u[0])
    return on_triangle(s * (1 - u[1]), s * u[1], p)


def triangle_heitz(u, p):
    """Row 48."""
    u, v = u
    return on_triangle(v - u / 2, u / 2, p) if v > u else on_triangle(v / 2, u - v / 2, p)


def triangle_fold(u, p):
    """Row 49."""
    return on_triangle(*(u if u[0] + u[1] <= 1 else [1 - t for t in u]), p)


def triangle_fold_preimages(x, p):
    """Row 49."""
    b1, b2 = barycentric(x, p)
    return [[b1, b2], [1 - b1, 1 - b2]]


def triangle_density(x, p):
    """Rows 47 to 49: one over the area."""
    return 2 / norm(cross(*edges(p)))


def in_triangle(x, p):
    """Rows 47 to 49."""
    b1, b2 = barycentric(x, p)
    return b1 >= 0 and b2 >= 0 and b1 + b2 <= 1


def to_triangle(x, p):
    """The point of the plane next to x."""
    return on_triangle(*barycentric(x, p), p)


def axes(p):
    """Row 94."""
    return [p["s1"], p["s2"], p["s3"]]


def ellipsoid(u, p):
    """Row 94."""
    return [s * w for s, w in zip(axes(p), from_height(1 - 2 * u[0], u[1]))]


def ellipsoid_density(x, p):
    """Row 94."""
    s1, s2, s3 = axes(p)
    return 1 / (4 * pi * s1 * s2 * s3 * norm([t / s**2 for t, s in zip(x, axes(p))]))


def to_ellipsoid(x, p):
    """The point of the ellipsoid on the ray through x."""
    return [s * w for s, w in zip(axes(p), unit([t / s for t, s in zip(x, axes(p))]))]


def torus(u, p):
    """Row 96."""
    y, z = on_circle(p["small"], u[1])
    return on_circle(p["large"] + y, u[0]) + [z]


def to_torus(x, p):
    """The point of the torus next to x."""
    r = norm(x[:2])
    y, z = [p["small"] * t for t in unit([r - p["large"], x[2]])]
    return [(p["large"] + y) * x[0] / r, (p["large"] + y) * x[1] / r, z]


def shell(u, p):
    """Row 103."""
    r = cbrt((1 - u[0]) * p["a"] ** 3 + u[0] * p["b"] ** 3)
    return [r * w for w in from_height(1 - 2 * u[1], u[2])]


def tetrahedron(u, p):
    """Row 104."""
    r, s = cbrt(u[0]), sqrt(u[1])
    return combine((1, p["a"]), (r * (1 - s), sub(p["b"], p["a"])), (r * s * (1 - u[2]), sub(p["c"], p["a"])),
                   (r * s * u[2], sub(p["d"], p["a"])))


def tetrahedron_density(x, p):
    """Row 104."""
    b, c, d = [sub(p[k], p["a"]) for k in "bcd"]
    return 6 / abs(dot(b, cross(c, d)))


def in_tetrahedron(x, p):
    """Row 104."""
    b, c, d = [sub(p[k], p["a"]) for k in "bcd"]
    h, det = sub(x, p["a"]), dot(b, cross(c, d))
    w = [dot(h, cross(c, d)) / det, dot(h, cross(d, b)) / det, dot(h, cross(b, c)) / det]
    return min(w) >= 0 and sum(w) <= 1


def simplex(u, p):
    """Row 105."""
    x = 1 - sqrt(1 - u[0])
    y = (1 - x) * u[1]
    return [x, y, 1 - x - y]


def ordered(u, p):
    """Row 113."""
    x = logit(u[0])
    y = x + exp(logit(u[1]))
    return [x, y, y + exp(logit(u[2]))]


def ordered_density(x, p):
    """Row 113."""
    return logistic_density(x[0]) / ((1 + x[1] - x[0]) * (1 + x[2] - x[1])) ** 2


def quaternion(u, p):
    """Row 79."""
    a, b = on_circle(sqrt(1 - u[0]), u[1]), on_circle(sqrt(u[0]), u[2])
    return [a[1], a[0], b[1], b[0]]


def correlation_factor(u, p):
    """Row 114."""
    a, b, c = [2 * t - 1 for t in u]
    root = [sqrt((1 - t) * (1 + t)) for t in (a, b, c)]
    return [a, root[0], b, c * root[1], root[1] * root[2]]


def correlation_factor_density(x, p):
    """Row 114."""
    return x[1] * x[4] / (8 * sqrt((1 - x[2]) * (1 + x[2])))


def helix(u, p):
    """Row 40."""
    t = p["T"] * u[0]
    return [p["r"] * cos(t), p["r"] * sin(t), p["c"] * t]


def truncated_cone(u, p):
    """Row 95."""
    r0, r1 = p["r0"], p["r1"]
    t = u[0] * (r0 + r1) / (r0 + sqrt((1 - u[0]) * r0**2 + u[0] * r1**2))
    return on_circle((1 - t) * r0 + t * r1, u[1]) + [p["h"] * t]


def to_cone(x, p):
    """The point at the same height and azimuth."""
    t = x[2] / p["h"]
    r = (1 - t) * p["r0"] + t * p["r1"]
    return [r * x[0] / norm(x[:2]), r * x[1] / norm(x[:2]), x[2]]


def onto_plane(u, p):
    """Row 97."""
    w = on_circle(sqrt(u[0]), u[1]) + [sqrt(1 - u[0])]
    return combine((1, p["o"]), (dot(p["n"], sub(p["p0"], p["o"])) / dot(p["n"], w), w))


def onto_plane_density(x, p):
    """Row 97."""
    d = sub(x, p["o"])
    return d[2] * abs(dot(d, unit(p["n"]))) / (pi * dot(d, d) ** 2)


def centre(p):
    """Row 98."""
    return [mpf(0), mpf(0), p["d"]]


def sphere_light(u, p):
    """Row 98: the near one of the two points of the sphere in the direction."""
    w = from_depth(p["m"] * u[0], u[1])
    d, r = p["d"], p["r"]
    return combine(((d * d - r * r) / (d * w[2] + sqrt(r * r - d * d * (w[0] ** 2 + w[1] ** 2))), w))


def sphere_light_density(x, p):
    """Row 98: the density of the cone times the cosine at the sphere over the squared distance."""
    return abs(dot(x, sub(x, centre(p)))) / (2 * pi * p["m"] * p["r"] * norm(x) ** 3)


def on_near_side(x, p):
    """Row 98: in the cone, and before the horizon."""
    return depth(unit(x)) <= p["m"] and dot(x, sub(x, centre(p))) <= 0


def to_light(x, p):
    """Row 98: the point of the sphere nearest to x."""
    return combine((1, centre(p)), (p["r"], unit(sub(x, centre(p)))))


def cosine_direction(u):
    """Row 63."""
    return on_circle(sqrt(u[0]), u[1]) + [sqrt(1 - u[0])]


def chained_frames(u, p):
    """Row 102: the frame turns z to the first direction about the axis that is orthogonal to both."""
    n, w = cosine_direction(u[:2]), cosine_direction(u[2:])
    along = (w[0] * n[0] + w[1] * n[1]) / (1 + n[2])
    return n + [w[0] + (w[2] - along) * n[0], w[1] + (w[2] - along) * n[1], w[2] * n[2] - w[0] * n[0] - w[1] * n[1]]


def frame_around(n):
    """The frame of Duff et al. about a direction."""
    side = mpf(1) if n[2] >= 0 else mpf(-1)
    a = -1 / (side + n[2])
    b = n[0] * n[1] * a
    return [1 + side * n[0] ** 2 * a, side * b, -side * n[0]], [b, side + n[1] ** 2 * a, -n[1]], n


def scattered_twice(u, p):
    """Row 102: the second direction in the frame about the first."""
    n = henyey_greenstein(u[:2], p)
    c = real_power(u[2], 1 / (p["n"] + 1))
    w = on_circle(sqrt(1 - c * c), u[3]) + [c]
    return n + combine(*zip(w, frame_around(n)))


def scattered_twice_density(x, p):
    """Row 102: the phase function times the lobe."""
    return henyey_greenstein_density(x[:3], p) * (p["n"] + 1) / (2 * pi) * real_power(dot(x[:3], x[3:]), p["n"])


def scattering_vertex(u, p):
    """Row 106."""
    t = -log1p(u[0] * expm1(-p["s"] * p["d"])) / p["s"]
    return combine((1, p["o"]), (t, henyey_greenstein(u[1:], p)))


def scattering_vertex_density(x, p):
    """Row 106."""
    d = sub(x, p["o"])
    t = norm(d)
    return p["s"] * exp(-p["s"] * t) / -expm1(-p["s"] * p["d"]) * henyey_greenstein_density(unit(d), p) / t**2


def stick_breaking(u, p):
    """Row 111: three breaks, the k-th of logit(u) - log(4 - k)."""
    x, rest = [], mpf(1)
    for k, t in zip((3, 2, 1), u):
        x.append(rest * t / (t + k * (1 - t)))
        rest *= k * (1 - t) / (t + k * (1 - t))
    return x + [rest]


def stick_breaking_density(x, p):
    """Row 111."""
    density = mpf(1) / 2
    for i, k in enumerate((3, 2, 1)):
        rest = sum(x[i:])
        density *= k / (rest * (1 + (k - 1) * x[i] / rest) ** 2)
    return density


def thin_lens(u, p):
    """Row 100: a point of the lens, and the direction from it to one of the plane of focus."""
    x, y = on_circle(p["r"] * sqrt(u[0]), u[1])
    return [x, y] + unit([p["a"] * (2 * u[2] - 1) - x, p["b"] * (2 * u[3] - 1) - y, p["f"]])


def thin_lens_density(x, p):
    """Row 100."""
    return p["f"] ** 2 / (pi * p["r"] ** 2 * 4 * p["a"] * p["b"] * x[4] ** 3)


def through_lens(x, p):
    """Row 100: in the lens, and towards the rectangle in the plane of focus."""
    if x[4] <= 0:
        return False
    focus = [x[i] + p["f"] * x[2 + i] / x[4] for i in range(2)]
    return norm(x[:2]) <= p["r"] and abs(focus[0]) <= p["a"] and abs(focus[1]) <= p["b"]


def portal_segment(u, p):
    """Row 101: where a line through a triangular opening meets the planes above and below."""
    s = sqrt(u[0])
    x = [p["a"] * (1 - s), p["a"] * s * u[1], mpf(0)]
    w = on_circle(sqrt(u[2]), u[3]) + [sqrt(1 - u[2])]
    return combine((1, x), (p["h"] / w[2], w)) + combine((1, x), (-p["k"] / w[2], w))


def portal_segment_density(x, p):
    """Row 101: uniform in the opening, cosines at both ends over the squared distance, and those of the opening cancel."""
    edge = sub(x[:3], x[3:])
    cosine = edge[2] / norm(edge)
    return 2 * cosine**2 / (pi * p["a"] ** 2 * dot(edge, edge))


def through_portal(x, p):
    """Row 101: whether the line passes the opening."""
    hole = [(p["k"] * s + p["h"] * t) / (p["h"] + p["k"]) for s, t in zip(x[:2], x[3:5])]
    return min(hole) >= 0 and sum(hole) <= p["a"] and x[2] > x[5]


def tilted_portal(u, p):
    """Row 101: where a line through a triangular opening meets a plane above and one below."""
    s = sqrt(u[0])
    x = [p["a"] * (1 - s), p["a"] * s * u[1], mpf(0)]
    w = on_circle(sqrt(1 - u[2] ** 2), u[3]) + [u[2]]
    above = dot(p["n"], sub(p["p"], x)) / dot(p["n"], w)
    below = dot(p["m"], sub(x, p["q"])) / dot(p["m"], w)
    return combine((1, x), (above, w)) + combine((1, x), (-below, w)) if above > 0 and below > 0 else None


def tilted_portal_density(x, p):
    """Row 101: uniform in the opening and in direction, cosines at both ends over that of the opening and the squared distance."""
    edge = sub(x[:3], x[3:])
    cosines = [abs(dot(p[k], edge)) / norm(p[k]) / norm(edge) for k in "nm"]
    return cosines[0] * cosines[1] / (pi * p["a"] ** 2 * norm(edge) * edge[2])


def through_tilted_portal(x, p):
    """Row 101: whether the ends are on their planes and the line passes the opening."""
    if not x[2] > 0 > x[5]:
        return False
    off = [abs(dot(p[k], sub(end, p[o]))) for k, o, end in (("n", "p", x[:3]), ("m", "q", x[3:]))]
    hole = [(t * x[2] - s * x[5]) / (x[2] - x[5]) for s, t in zip(x[:2], x[3:5])]
    return max(off) < 1e-9 and min(hole) >= 0 and sum(hole) <= p["a"]


def onto_planes(x, p):
    """Row 101: the ends on their planes."""
    foot = lambda y, o, n: combine((1, y), (dot(n, sub(o, y)) / dot(n, n), n))
    return foot(x[:3], p["p"], p["n"]) + foot(x[3:], p["q"], p["m"])


def patch_edges(p):
    """Row 54 in space: the two edges from a, and what makes the patch no parallelogram."""
    a, b, c, d = [p[k] for k in "abcd"]
    return sub(b, a), sub(d, a), combine((1, a), (-1, b), (1, c), (-1, d))


def bilinear_patch(u, p):
    """Row 54 in space."""
    e, f, g = patch_edges(p)
    return combine((1, p["a"]), (u[0], e), (u[1], f), (u[0] * u[1], g))


def patch_normal(s, t, p):
    """Row 54 in space: the normal, as long as the area is stretched."""
    e, f, g = patch_edges(p)
    return cross(combine((1, e), (t, g)), combine((1, f), (s, g)))


def bilinear_patch_inverse(x, p):
    """Row 54 in space: along the normal in the middle; the root inside."""
    e, f, g = patch_edges(p)
    h, n, half = sub(x, p["a"]), patch_normal(mpf(1) / 2, mpf(1) / 2, p), mpf(1) / 2
    k0, k2 = -dot(n, cross(e, h)), dot(n, cross(g, f))
    k1 = dot(n, cross(e, f)) - dot(n, cross(g, h))
    found = []
    for side in (-1, 1):
        bottom = -k1 + side * sqrt(k1 * k1 - 4 * k0 * k2)
        if bottom == 0:
            continue
        t = 2 * k0 / bottom
        q = cross(combine((1, e), (t, g)), n)
        found.append([dot(sub(h, combine((t, f))), cross(n, q)) / dot(combine((1, e), (t, g)), cross(n, q)), t])
    return min(found, key=lambda v: max(abs(v[0] - half), abs(v[1] - half)))


SPACE = [
    Sampler(100, "thin_lens", thin_lens, thin_lens_density, through_lens, lambda x, p: x[:2] + unit(x[2:])),
    Sampler(101, "portal_segment", portal_segment, portal_segment_density, through_portal,
            lambda x, p: x[:2] + [p["h"]] + x[3:5] + [-p["k"]]),
    Sampler(101, "tilted_portal", tilted_portal, tilted_portal_density, through_tilted_portal, onto_planes),
    Sampler(54, "bilinear_patch", bilinear_patch, lambda x, p: 1 / norm(patch_normal(*bilinear_patch_inverse(x, p), p)),
            lambda x, p: all(0 <= t <= 1 for t in bilinear_patch_inverse(x, p)),
            lambda x, p: bilinear_patch(bilinear_patch_inverse(x, p), p)),
    Sampler(98, "sphere_light", sphere_light, sphere_light_density, on_near_side, to_light),
    Sampler(102, "chained_frames", chained_frames, lambda x, p: x[2] * dot(x[:3], x[3:]) / pi**2,
            lambda x, p: x[2] >= 0 and dot(x[:3], x[3:]) >= 0, lambda x, p: unit(x[:3]) + unit(x[3:])),
    Sampler(102, "scattered_twice", scattered_twice, scattered_twice_density,
            lambda x, p: dot(x[:3], x[3:]) >= 0, lambda x, p: unit(x[:3]) + unit(x[3:])),
    Sampler(106, "scattering_vertex", scattering_vertex, scattering_vertex_density,
            lambda x, p: norm(sub(x, p["o"])) <= p["d"]),
    Sampler(111, "stick_breaking", stick_breaking, stick_breaking_density, lambda x, p: min(x) >= 0,
            lambda x, p: [t - (sum(x) - 1) / 4 for t in x]),
    Sampler(40, "helix", helix, lambda x, p: 1 / (p["T"] * sqrt(p["r"] ** 2 + p["c"] ** 2)),
            lambda x, p: 0 <= x[2] <= p["c"] * p["T"], lambda x, p: helix([x[2] / (p["c"] * p["T"])], p)),
    Sampler(95, "truncated_cone", truncated_cone,
            lambda x, p: 1 / (pi * (p["r0"] + p["r1"]) * sqrt(p["h"] ** 2 + (p["r1"] - p["r0"]) ** 2)),
            lambda x, p: 0 <= x[2] <= p["h"], to_cone),
    Sampler(97, "onto_plane", onto_plane, onto_plane_density, lambda x, p: x[2] >= p["o"][2],
            lambda x, p: combine((1, x), (-dot(sub(x, p["p0"]), p["n"]) / dot(p["n"], p["n"]), p["n"]))),
    Sampler(47, "triangle", triangle, triangle_density, in_triangle, to_triangle),
    Sampler(48, "triangle_heitz", triangle_heitz, triangle_density, in_triangle, to_triangle,
            smooth=lambda u, p: u[0] != u[1]),
    Sampler(49, "triangle_fold", triangle_fold, triangle_density, in_triangle, to_triangle, triangle_fold_preimages),
    Sampler(79, "quaternion", quaternion, lambda x, p: 1 / (2 * pi**2), project=to_unit_sphere),
    Sampler(94, "ellipsoid", ellipsoid, ellipsoid_density, project=to_ellipsoid),
    Sampler(96, "torus", torus, lambda x, p: 1 / (4 * pi**2 * p["small"] * norm(x[:2])), project=to_torus),
    Sampler(103, "shell", shell, lambda x, p: 3 / (4 * pi * (p["b"] ** 3 - p["a"] ** 3)),
            lambda x, p: p["a"] <= norm(x) <= p["b"]),
    Sampler(104, "tetrahedron", tetrahedron, tetrahedron_density, in_tetrahedron),
    Sampler(105, "simplex", simplex, lambda x, p: 2 / sqrt(mpf(3)), lambda x, p: min(x) >= 0,
            lambda x, p: [t - (sum(x) - 1) / 3 for t in x]),
    Sampler(113, "ordered", ordered, ordered_density, lambda x, p: x[0] < x[1] < x[2]),
    Sampler(114, "correlation_factor", correlation_factor, correlation_factor_density,
            project=lambda x, p: unit(x[:2]) + unit(x[2:])),
]

# --- the points -------------------------------------------------------------

INNER = [[0.3], [0.5], [0.7183098861837907]]
ENDS = [[0.0], [TINY], [1e-300], [1 - 2.0**-20], [BELOW_ONE]]
PAIRS = [[0.3, 0.6], [0.7183098861837907, 0.15915494309189535], [TINY, 0.3], [BELOW_ONE, 0.25], [0.5, 0.0], [0.5, BELOW_ONE],
         [0.0, 0.3]]
TRIPLES = [[0.3, 0.6, 0.2], [0.7183098861837907, 0.15915494309189535, 0.4], [TINY, 0.3, 0.9], [BELOW_ONE, 0.25, 0.6],
           [0.5, TINY, 0.1], [0.5, BELOW_ONE, 0.3], [0.2, 0.7, 0.0], [0.2, 0.7, BELOW_ONE]]
ISOSCELES = {"a": -1.0, "b": 0.5, "c": 3.0}
RQ = {"s": 1.5, "d0": 2.5, "d1": 0.4}
SECTOR = {"a": 1.0, "b": 2.0, "p": 2.5, "d": 3.0}
CHOLESKY = {"l11": 1.5, "l21": -0.7, "l22": 0.4}
QUAD = {"ax": 0.0, "ay": 0.0, "bx": 2.0, "by": 0.25, "cx": 2.5, "cy": 1.75, "dx": -0.25, "dy": 1.0}
SQUARE = {"ax": 0.0, "ay": 0.0, "bx": 1.0, "by": 0.0, "cx": 1.0, "cy": 1 + 2.0**-45, "dx": 0.0, "dy": 1.0}
FLOW = {"alpha": 0.7, "beta": 1.3}
COUPLING = {"s": 0.9, "t": 0.4}
MATRIX = {"a": [1.0, 0.1, 0.2], "b": [0.0, 0.5, 0.0], "c": [0.3, 0.0, 1.1]}
FLAT = {"a": [1e-3, 0.0, 0.0], "b": [0.0, 1.0, 0.0], "c": [0.0, 0.0, 1.0]}
MIX = {"p": 0.35, "n": 8.0}
T3 = {"a": [0.0, 0.0, 1.0], "b": [2.0, 0.0, 1.5], "c": [0.3, 1.7, 0.2]}
SLIVER = {"a": [0.0, 0.0, 0.0], "b": [1.0, 0.0, 0.0], "c": [0.5, 1e-9, 0.0]}
FAR = {"a": [1e6, 1e6, 1e6], "b": [1e6 + 1, 1e6, 1e6], "c": [1e6, 1e6 + 1, 1e6 + 1]}
CRATE = {"a": [0.0, 0.0, 0.0], "b": [1.0, 0.1, 0.0], "c": [0.2, 1.0, 0.3], "d": [0.1, -0.2, 1.5]}

TILTED = {"o": [0.1, 0.2, 0.0], "p0": [0.0, 0.0, 2.0], "n": [0.2, -0.1, 1.0]}
DISTANT = {"o": [1e6, 1e6, 0.0], "p0": [1e6, 1e6, 2.0], "n": [0.2, -0.1, 1.0]}
NEAR = {"o": [0.0, 0.0, 0.0], "p0": [0.0, 0.0, 1e-6], "n": [0.0, 0.0, 1.0]}
WINDOW = {"z0": -0.2, "z1": 0.7, "p": 2.5, "d": 1.4}
FRUSTUM = {"r0": 1.0, "r1": 0.25, "h": 2.0}
WEIGHTS = {"w00": 1.0, "w10": 3.0, "w01": 5.0, "w11": 7.0}
CORNER = {"w00": 0.0, "w10": 0.0, "w01": 0.0, "w11": 1.0}
BULB = {"m": 0.2 - 2.0**-40, "d": 1.25, "r": 0.75}
HAZE = {"o": [0.0, 0.0, 0.0], "s": 0.8, "d": 2.0, "g": 0.6}
FOG = {"o": [1.0, 2.0, -0.5], "s": 3.0, "d": 10.0, "g": 0.3}
COIL = {"r": 1.5, "c": 0.2, "T": 20.0}

SADDLE = {"a": [0.0, 0.0, 0.0], "b": [2.0, 0.25, 0.5], "c": [2.5, 1.75, -0.25], "d": [-0.25, 1.0, 0.75]}
TILTED_QUAD = {"a": [1.0, 0.0, 0.0], "b": [3.0, 0.0, 1.0], "c": [4.0, 2.0, 2.5], "d": [1.0, 1.0, 0.5]}
WALL = {"a": [0.5, 0.0, 0.0], "b": [0.5, 2.0, 0.0], "c": [0.5, 2.0, 1.0], "d": [0.5, 0.0, 1.0]}
GRAZING = {"alpha": 0.1, "w": [1.0, 0.0, 1e-7]}
UPRIGHT = {"alpha": 0.5, "w": [0.0, 0.0, 1.0]}
STEEP = {"alpha": 0.3, "w": [0.36, 0.48, 0.8]}
SMOOTH = {"alpha": 0.1, "eta": 1 + 2.0**-20, "w": [0.4, 0.1, 0.8]}
PORTAL = {"a": 1.0, "h": 2.0, "k": 1.0}
ATTIC = {"a": 1.0, "p": [0.5, 0.25, 2.0], "n": [0.48, -0.36, 0.8], "q": [1.0, -0.5, -1.0], "m": [0.0, 0.28, 0.96]}
ASLANT = {"a": 1e-3, "p": [0.0, 0.0, 100.0], "n": [0.6, 0.0, 0.8], "q": [0.0, 0.0, -0.01], "m": [0.28, 0.0, 0.96]}
KEYHOLE = {"a": 1e-6, "h": 100.0, "k": 0.01}
LENS = {"r": 0.5, "f": 2.0, "a": 0.8, "b": 0.6}
PINHOLE = {"r": 1e-6, "f": 1e6, "a": 1.2, "b": 0.8}
RING = {"r1": 0.125, "r2": 1.0}
NARROW = {"r1": 1e-8, "r2": 0.01}
QUADRUPLES = [[0.3, 0.6, 0.2, 0.9], [0.7183098861837907, 0.15915494309189535, 0.4, 0.3], [TINY, 0.3, 0.9, 0.6], [BELOW_ONE, 0.25, 0.6, 0.1],
              [0.3, 0.6, TINY, 0.1], [0.3, 0.6, BELOW_ONE, 0.7], [0.3, 0.6, 0.5, 0.0]]
TINY_TRIANGLE = {"a": [0.0, 0.0, 1.0], "b": [1e-5, 0.0, 1.0], "c": [0.0, 1e-5, 1.0]}
SEEN_SLIVER = {"a": [0.0, 0.0, 1.0], "b": [1.0, 0.0, 1.0], "c": [1.0, 1e-8, 1.0]}
SEEN_TRIANGLE = {"a": [1.0, 0.0, 0.25], "b": [0.25, 1.0, 0.5], "c": [-0.25, 0.125, 1.0]}
TURNED_TRIANGLE = {"a": [1.0, 0.0, 0.25], "b": [-0.25, 0.125, 1.0], "c": [0.25, 1.0, 0.5]}
OCTANT = {"a": [0.0, 0.0, 1.0], "b": [1.0, 0.0, 0.0], "c": [0.0, 1.0, 0.0]}
TINY_RECTANGLE = {"x0": 3.0, "y0": 3.0, "x1": 3 + 1e-6, "y1": 3 + 1e-6, "z0": -1.0}
FLAT_RECTANGLE = {"x0": -1.0, "y0": -1.0, "x1": 1.0, "y1": 1.0, "z0": -1e-6}
SEEN_RECTANGLE = {"x0": 0.25, "y0": -0.375, "x1": 1.25, "y1": 0.75, "z0": -1.0}
LOW_RECTANGLE = {"x0": -2.0, "y0": -3.0, "x1": -0.25, "y1": -0.5, "z0": -2.0}
VIEW = {"alpha": 0.3, "w": [0.48, 0.64, 0.6]}
BRUSHED = {"alpha_x": 0.1, "alpha_y": 0.6, "w": [0.48, 0.64, 0.6]}
ACROSS = {"alpha_x": 0.5, "alpha_y": 0.02, "w": [0.6, 0.0, 0.8]}
GLASS = {"alpha": 0.3, "eta": 1.5, "w": [0.48, 0.0, 0.8772684879784525]}
OUT_OF_GLASS = {"alpha": 0.1, "eta": 0.75, "w": [0.28, 0.0, 0.96]}

POINTS = {
    "smoothstep": over({"a": 0.0, "b": 1.0}, [[0.5], [1e-18]] + INNER[::2] + ENDS) + over({"a": 2.0, "b": -5.0}, INNER),
    "epanechnikov": over({}, [[1e-12]] + INNER + ENDS),
    "logistic": over({"s": 1.0}, [[1e-300], [BELOW_ONE]]) + over({"s": 0.25}, INNER + ENDS[1:]),
    "truncated_logistic": [({"s": 0.1, "a": 5.0, "b": 6.0}, [0.5]), ({"s": 1e-3, "a": -3.0, "b": 3.0}, [1e-20])]
    + over({"s": 1.0, "a": -2.0, "b": 3.0}, INNER + ENDS) + over({"s": 0.5, "a": -1.0, "b": 20.0}, INNER),
    "truncated_logistic_as_printed": over({"s": 1.0, "a": -2.0, "b": 3.0}, INNER + ENDS),
    "normal": over({"m": 0.0, "s": 1.0}, [[1e-300], [BELOW_ONE]]) + over({"m": 3.0, "s": 0.25}, INNER + ENDS[1:]),
    "lower_normal": [({"a": -40.0, "b": -39.0}, [0.5])] + over({"a": -9.0, "b": -8.0}, INNER + ENDS) + over({"a": -1.0, "b": 2.0}, INNER),
    "upper_normal": [({"a": 8.0, "b": 9.0}, [0.5])] + over({"a": 0.5, "b": 2.0}, INNER + ENDS) + over({"a": 8.0, "b": 9.0}, [[0.3], [BELOW_ONE]]),
    "cauchy": over({"g": 1.0}, [[1e-300], [BELOW_ONE]]) + over({"g": 20.0}, INNER + ENDS[1:]),
    "pareto": [({"m": 0.0, "s": 1.0, "xi": 1e-12}, [0.7]), ({"m": 0.0, "s": 1.0, "xi": -0.5}, [BELOW_ONE])]
    + over({"m": 0.0, "s": 1.0, "xi": 0.25}, INNER + ENDS) + over({"m": 1.0, "s": 2.0, "xi": -0.5}, INNER),
    "kumaraswamy": [({"a": 2.0, "b": 1e6}, [1e-12]), ({"a": 0.5, "b": 0.5}, [BELOW_ONE])] + over({"a": 2.0, "b": 3.0}, INNER + ENDS)
    + [({"a": 0.5, "b": 100.0}, [0.3])],
    "power_law": [({"a": 1.0, "b": 2.0, "p": 1 + 2.0**-40}, [0.3]), ({"a": 1e-6, "b": 1e6, "p": 3.0}, [0.999])]
    + over({"a": 1.0, "b": 2.0, "p": 2.0}, INNER + ENDS) + over({"a": 0.5, "b": 4.0, "p": 3.5}, INNER),
    "sinh_arcsinh": [({"e": 0.0, "d": 1.0}, [BELOW_ONE]), ({"e": 5.0, "d": 2.0}, [1e-12])] + over({"e": 0.5, "d": 1.5}, INNER + ENDS[1:])
    + [({"e": -1.0, "d": 0.25}, [0.3])],
    "heavy_tails": [({"h": 1e-10}, [0.9]), ({"h": 0.5}, [BELOW_ONE])] + over({"h": 0.25}, INNER[::2] + [[TINY], [1e-9], [1 - 2.0**-20]]),
    "equiangular": [({"d": 1e-6, "a": 1.0, "b": 2.0}, [0.5]), ({"d": 1e-8, "a": -1.0, "b": 1.0}, [0.25]), ({"d": 1.0, "a": 1e6, "b": 1e6 + 1}, [0.5])]
    + over({"d": 1.0, "a": -1.0, "b": 3.0}, INNER + ENDS) + over({"d": 0.5, "a": 1.0, "b": 2.0}, INNER) + [({"d": 1e-3, "a": -1.0, "b": 1.0}, [0.3])],
    "linear_extinction": [({"a": 1.0, "b": 1e-14}, [0.5]), ({"a": 0.0, "b": 1.0}, [1e-20])] + over({"a": 1.0, "b": 2.0}, INNER + ENDS)
    + [({"a": 1.0, "b": 1e-10}, [0.3])],
    "falling_extinction": [({"k": 1.0, "h": 1e-12}, [0.5])] + over({"k": 2.0, "h": 0.125}, INNER + ENDS[:4]) + over({"k": 1.0, "h": 0.5}, INNER + ENDS[:3]),
    "kepler": [({"e": 1 - 2.0**-20}, [1e-9]), ({"e": 0.99}, [0.5])] + over({"e": 0.6}, INNER + ENDS),
    "hyperexponential": over({"p": 0.3, "l": 2.0, "m": 0.1}, INNER + ENDS[:3]) + [({"p": 0.0, "l": 1.0, "m": 3.0}, [0.25]),
                                                                             ({"p": 1e-9, "l": 1e-3, "m": 1e3}, [0.9])],
    "thin_lens": [(PINHOLE, [0.3, 0.6, 0.2, 0.9])] + over(LENS, QUADRUPLES),
    "portal_segment": over(PORTAL, QUADRUPLES) + over(KEYHOLE, QUADRUPLES[:2]),
    "tilted_portal": over(ATTIC, QUADRUPLES[:3:2] + [[0.72, 0.16, 0.8, 0.3], [BELOW_ONE, 0.25, 0.3, 0.1], [0.3, 0.6, 1e-9, 0.1], [0.3, 0.6, 0.25, 0.0], [0.9, 0.05, 0.3, 0.6]])
    + over(ASLANT, [[0.3, 0.6, 0.2, 0.9], [0.9, 0.1, 0.5, 0.25]]),
    "equal_area_octahedral": over({}, [[0.5, 0.5 + 2.0**-50]] + PAIRS[:4] + [[0.2, 0.9], [0.9, 0.2], [0.6, 0.7], [0.1, 0.2], [0.45, 0.3], [0.999, 0.998]]),
    "visible_normals": over(VIEW, PAIRS[:3] + PAIRS[4:5]) + [({"alpha": 0.5, "w": [0.0, 0.0, 1.0]}, [0.3, 0.6])]
    + [({"alpha": 0.1, "w": [0.9999999999999950, 0.0, 1e-7]}, [0.3, 0.6]), ({"alpha": 1e-3, "w": [0.6, 0.0, 0.8]}, [0.3, 0.6])]
    + over(GRAZING, [[0.3, 0.6], [0.3, BELOW_ONE]]),
    "heitz_normals": over(STEEP, PAIRS[:3] + PAIRS[4:5]) + over(GRAZING, PAIRS[:2]) + over(UPRIGHT, PAIRS[:2]) + [(VIEW, [0.3, 0.6])],
    "seen_triangle": [(TINY_TRIANGLE, [0.3, 0.6]), (SEEN_SLIVER, [0.3, 0.6])] + over(SEEN_TRIANGLE, PAIRS[:4] + PAIRS[5:]) + over(TURNED_TRIANGLE, PAIRS[:2]) + over(OCTANT, PAIRS[:2]),
    "seen_rectangle": [(TINY_RECTANGLE, [0.3, 0.6]), (FLAT_RECTANGLE, [0.3, 0.6])] + over(SEEN_RECTANGLE, PAIRS) + over(LOW_RECTANGLE, PAIRS[:2]),
    "small_angles": [(NARROW, [0.01, 0.6])] + over(RING, PAIRS) + [(NARROW, [0.99, 0.2])],
    "anisotropic_normals": over(BRUSHED, PAIRS[:3] + PAIRS[4:5]) + over(ACROSS, PAIRS[:2]) + [({"alpha_x": 0.1, "alpha_y": 0.1, "w": [1.0, 0.0, 1e-7]}, [0.3, 0.6])],
    "anisotropic_normals_as_printed": over(BRUSHED, PAIRS[:3] + PAIRS[4:5]) + over(ACROSS, PAIRS[:2]),
    "reflected_ggx": over(VIEW, PAIRS[:3] + PAIRS[4:5]) + [({"alpha": 0.1, "w": [0.0, 0.0, 1.0]}, [0.3, 0.6]), ({"alpha": 1.0, "w": [0.8, 0.0, 0.6]}, [0.9, 0.4]),
                                                        ({"alpha": 1e-3, "w": [1.0, 0.0, 1e-4]}, [0.3, 0.6])],
    "refracted_ggx": over(GLASS, PAIRS[:3] + PAIRS[4:5]) + over(OUT_OF_GLASS, PAIRS[:2]) + [(SMOOTH, [0.3, 0.6])],
    "bilinear_patch": over(SADDLE, PAIRS) + over(TILTED_QUAD, PAIRS[:3]) + over(WALL, PAIRS[:3]),
    "cubic": over({}, INNER + ENDS + [[0.1], [0.9], [0.25], [0.75], [0.25 + 2.0**-20]]),
    "elliptical_grid": over({}, [[1 - 2.0**-20, 1 - 2.0**-20], [0.5 + 2.0**-30, 0.7]] + PAIRS + [[0.5, 0.5], [0.001, 0.999]]),
    "bilinear_density": over(WEIGHTS, PAIRS + [[0.3, 0.2]]) + over(CORNER, [[1e-12, 1e-12], [0.3, 0.6]])
    + over({"w00": 1.0, "w10": 1.0, "w01": 1.0, "w11": 1.0}, PAIRS[:2]) + over({"w00": 1.0, "w10": 0.0, "w01": 0.0, "w11": 1.0}, PAIRS[:2]),
    "complex_square_xy": over({}, PAIRS[:-1]),
    "rayleigh": over({}, [[1e-18, 0.1]] + PAIRS + [[0.5, 0.1], [0.01, 0.7], [1e-300, 0.4]]),
    "sphere_light": [({"m": 5e-19, "d": 1e6, "r": 1e-3}, [0.3, 0.6]), ({"m": 0.998, "d": 1.000001, "r": 1.0}, [0.5, 0.6])] + over(BULB, PAIRS)
    + [({"m": 0.05, "d": 2.0, "r": 1.0}, [0.3, 0.6])],
    "chained_frames": over({}, [[0.3, 0.6, 0.2, 0.9], [0.7183098861837907, 0.15915494309189535, 0.4, 0.3], [TINY, 0.3, 0.9, 0.6], [0.9, 0.6, TINY, 0.1],
                                [BELOW_ONE, 0.25, 0.6, 0.1], [0.3, 0.6, BELOW_ONE, 0.7], [0.5, 0.0, 0.5, 0.0], [0.0, 0.3, 0.2, 0.4], [0.2, 0.4, 0.0, 0.3]]),
    "scattered_twice": over({"g": 0.75, "n": 20.0}, [[0.3, 0.6, 0.2, 0.9], [0.05, 0.15915494309189535, 0.4, 0.3], [TINY, 0.3, 0.9, 0.6], [0.9, 0.6, TINY, 0.1],
                                                     [BELOW_ONE, 0.25, 0.6, 0.1], [0.3, 0.6, BELOW_ONE, 0.7], [0.5, 0.0, 0.5, 0.0], [0.0, 0.3, 0.2, 0.4]])
    + over({"g": -0.5, "n": 1.0}, [[0.3, 0.6, 0.2, 0.9], [0.8, 0.1, 0.7, 0.4]]) + over({"g": 0.99, "n": 1e4}, [[0.3, 0.6, 0.2, 0.9], [1e-9, 0.1, 0.5, 0.7]])
    + over({"g": 1e-10, "n": 0.0}, [[0.3, 0.1, 0.2, 0.9], [0.9, 0.6, 0.7, 0.3]]) + [({"g": 0.0, "n": 3.0}, [0.3, 0.1, 0.2, 0.9])],
    "scattering_vertex": [({"o": [1e6, 0.0, 0.0], "s": 0.8, "d": 1e-3, "g": 0.9}, [0.5, 0.3, 0.6])] + over(HAZE, TRIPLES)
    + over(FOG, TRIPLES[:2] + TRIPLES[3:]),
    "stick_breaking": over({}, [[1e-12, 0.5, BELOW_ONE]] + TRIPLES + [[0.0, 0.3, 0.6], [0.5, 0.0, 0.5]]),
    "pentagon": over({}, PAIRS[:3] + [[0.7, 0.25], [0.7, 0.5], [0.3, BELOW_ONE]]),
    "regular_polygon": over({"n": 3.0}, PAIRS[:3] + [[0.7, 0.4], [0.3, BELOW_ONE]]) + over({"n": 6.0}, PAIRS[:3] + [[0.7, 0.25], [0.3, BELOW_ONE]])
    + over({"n": 8.0}, PAIRS[:3] + [[0.3, 0.45], [0.3, BELOW_ONE]]),
    "zonal_window": [({"z0": 1 - 2.0**-40, "z1": 1.0, "p": 0.0, "d": 1.0}, [0.5, 0.5])] + over(WINDOW, PAIRS[:5]),
    "helix": [({"r": 1e6, "c": 1e-3, "T": 20.0}, [0.5])] + over(COIL, INNER + ENDS),
    "truncated_cone": over(FRUSTUM, PAIRS) + [({"r0": 1.0, "r1": 1.0, "h": 2.0}, [0.3, 0.6]), ({"r0": 1.0, "r1": 0.0, "h": 2.0}, [0.9, 0.6])],
    "onto_plane": [(DISTANT, [0.3, 0.6]), (NEAR, [0.9999, 0.6])] + over(TILTED, PAIRS[:3] + PAIRS[4:]),
    "tent": over({"r": 1.0}, [[BELOW_ONE], [1e-30]]) + over({"r": 2.0}, INNER + ENDS) + [({"r": 1e-6}, [0.25]), ({"r": 1e8}, [0.75])],
    "triangular": over(ISOSCELES, INNER + ENDS + [[0.375]])
    + [({"a": 0.0, "b": 0.0, "c": 1.0}, [0.3]), ({"a": 0.0, "b": 1.0, "c": 1.0}, [0.3]), ({"a": 0.0, "b": 1.0, "c": 1.0}, [BELOW_ONE]),
       ({"a": 0.0, "b": 0.0, "c": 1.0}, [0.0])],
    "student_2": over({}, [[1e-20]] + INNER + ENDS[1:]),
    "student": over({"nu": 3.5}, [[1e-12]] + INNER + ENDS[1:]) + over({"nu": 50.0}, [[0.99], [0.5000001], [1e-300]])
    + over({"nu": 1e6}, [[1e-12], [0.2], [0.4], [0.501], [0.8], [BELOW_ONE]]) + over({"nu": 1e3}, [[0.2], [0.8]])
    + [({"nu": 0.5}, [0.3]), ({"nu": 1.0}, [TINY]), ({"nu": 3.5}, [0.75]), ({"nu": 100.0}, [0.2]), ({"nu": 100.0}, [0.9]), ({"nu": 100.0}, [1e-30])],
    "laplace": over({"b": 1.0}, [[BELOW_ONE]]) + over({"b": 1.5}, INNER + ENDS[1:]) + [({"b": 1e-6}, [0.3]), ({"b": 1e8}, [0.9])],
    "rational_quadratic": over(RQ, INNER + ENDS) + [({"s": 1.0, "d0": 1.0, "d1": 1.0}, [0.3]), ({"s": 2.0, "d0": 2.0, "d1": 0.5}, [0.7]),
                                                   ({"s": 0.1, "d0": 10.0, "d1": 10.0}, [0.4]), ({"s": 1.0, "d0": 1.0, "d1": 1 + 2.0**-40}, [0.6])],
    "cosine": over({}, [[1e-9], [0.25]] + INNER[::2] + [[1e-4], [0.9999], [0.75], [0.1]]),
    "parabola": over({}, [[0.5 - 2.0**-30]] + INNER[::2] + ENDS + [[0.9]]),
    "square": over({}, INNER[::2] + ENDS + [[0.5 - 2.0**-30], [0.9]]),
    "fold": over({}, INNER + ENDS + [[0.5 - 2.0**-30], [0.9]]),
    "sawtooth": over({"k": 3.0}, INNER + ENDS + [[0.9]]),
    "concentric_disk": over({}, [[0.5 + 2.0**-40, 0.5], [0.0, 0.5], [0.5, 0.5]] + PAIRS + [[0.2, 0.9], [0.75, 0.75], [0.25, 0.25], [0.2, 0.4]]),
    "annular_sector": [({"a": 1.0, "b": 1 + 2.0**-30, "p": 0.0, "d": 1.0}, [0.5, 0.5])] + over(SECTOR, PAIRS)
    + [({"a": 0.0, "b": 1.0, "p": -1.0, "d": 6.0}, [0.3, 0.9]), ({"a": 3.0, "b": 4.0, "p": 7.0, "d": 1.0}, [0.3, 0.9])],
    "bivariate_normal": [({"l11": 1.0, "l21": 0.0, "l22": 1.0}, [1e-300, 0.3]), ({"l11": 1.0, "l21": 0.999999999, "l22": 1e-9}, [0.5, 0.25])]
    + over(CHOLESKY, PAIRS),
    "ggx_slopes": [({"alpha": 1e-4}, [BELOW_ONE, 0.3])] + over({"alpha": 0.3}, PAIRS) + [({"alpha": 1e3}, [0.3, 0.6])],
    "bilinear_quad": [(SQUARE, [0.3, 0.7])] + over(QUAD, PAIRS)
    + [({"ax": 0.0, "ay": 0.0, "bx": 2.0, "by": 0.0, "cx": 3.0, "cy": 1.0, "dx": 1.0, "dy": 1.0}, [0.3, 0.6]),
       ({"ax": 1e6, "ay": 1e6, "bx": 1e6 + 1, "by": 1e6, "cx": 1e6 + 2, "cy": 1e6 + 2, "dx": 1e6, "dy": 1e6 + 1}, [0.3, 0.6])],
    "complex_square": over({}, [[0.3, 0.6], [0.7183098861837907, 0.15915494309189535], [TINY, 0.3], [BELOW_ONE, 0.25], [0.5, 0.0], [0.5, BELOW_ONE]]),
    "radial_flow": over(FLOW, PAIRS) + [({"alpha": 1e-3, "beta": 5.0}, [0.3, 0.6]), ({"alpha": 1.0, "beta": 0.0}, [0.3, 0.6])],
    "affine_coupling": over(COUPLING, [[0.3, 0.6], [0.7183098861837907, 0.15915494309189535], [TINY, 0.3], [BELOW_ONE, 0.25], [0.5, 0.5], [0.4, BELOW_ONE]])
    + [({"s": 0.0, "t": 0.0}, [0.3, 0.6]), ({"s": 20.0, "t": -3.0}, [0.3, 0.6])],
    "cone": [({"m": 5e-19}, [0.5, 0.1])] + over({"m": 0.1}, PAIRS) + [({"m": 2.0}, [0.9, 0.1]), ({"m": 1.0}, [BELOW_ONE, 0.1])],
    "concentric_hemisphere": over({}, [[0.5 + 2.0**-40, 0.5], [0.0, 0.5], [0.5, 0.5]] + PAIRS + [[0.2, 0.9], [0.2, 0.4]]),
    "double_lune": over({"t": 0.3}, PAIRS[:4] + [[0.5, BELOW_ONE], [0.9, 0.2]]) + [({"t": 1e-6}, [0.3, 0.6]), ({"t": 1e-6}, [0.8, 0.6])],
    "von_mises_fisher": [({"kappa": 1e-12}, [0.3, 0.1]), ({"kappa": 1e12}, [0.3, 0.1])] + over({"kappa": 10.0}, PAIRS) + [({"kappa": 500.0}, [0.3, 0.1])],
    "henyey_greenstein": [({"g": 1e-10}, [0.3, 0.1]), ({"g": 1 - 2.0**-20}, [0.3, 0.1]), ({"g": -(1 - 2.0**-20)}, [1e-9, 0.1])]
    + over({"g": 0.8}, PAIRS) + [({"g": 0.0}, [0.3, 0.1]), ({"g": -0.5}, [0.3, 0.1])],
    "transformed_cosine": [(FLAT, [0.3, 0.6])] + over(MATRIX, PAIRS),
    "beckmann": [({"alpha": 1e-4}, [0.5, 0.1]), ({"alpha": 1.0}, [BELOW_ONE, 0.1])] + over({"alpha": 0.3}, PAIRS),
    "ggx": [({"alpha": 1e-4}, [0.5, 0.1]), ({"alpha": 1e-4}, [BELOW_ONE, 0.1])] + over({"alpha": 0.2}, PAIRS) + [({"alpha": 2.0}, [0.3, 0.6])],
    "anisotropic_ggx": [({"ax": 1e-3, "ay": 1.0}, [0.5, 0.13])] + over({"ax": 0.1, "ay": 0.5}, PAIRS),
    "ashikhmin_shirley": [({"nu": 1.0, "nv": 1e5}, [0.3, 0.26])] + over({"nu": 10.0, "nv": 200.0}, PAIRS + [[0.4, 0.5], [0.3, 0.75]])
    + [({"nu": 0.0, "nv": 0.0}, [0.3, 0.6]), ({"nu": 1e6, "nv": 1e6}, [0.5, 0.1])],
    "mixture": over(MIX, [[0.1, 0.6], [0.7183098861837907, 0.15915494309189535], [TINY, 0.3], [BELOW_ONE, 0.25], [0.35, 0.6], [0.5, 0.0], [0.2, BELOW_ONE]])
    + [({"p": 0.0, "n": 8.0}, [0.3, 0.6]), ({"p": 1.0, "n": 8.0}, [0.3, 0.6]), ({"p": 0.5, "n": 1e6}, [0.3, 0.6])],
    "sheen": over({"alpha": 0.4}, PAIRS) + [({"alpha": 1e-3}, [0.3, 0.6]), ({"alpha": 100.0}, [0.3, 0.6])],
    "perspective": [({"t": 1e4, "a": 1.0}, [0.999, 0.2])] + over({"t": 0.7, "a": 0.6}, PAIRS + [[0.5, 0.5]]) + [({"t": 1e-4, "a": 0.5}, [0.3, 0.2])],
    "triangle": [(SLIVER, [0.3, 0.6]), (FAR, [0.3, 0.6]), (T3, [TINY, 0.5])] + over(T3, PAIRS),
    "triangle_heitz": [(SLIVER, [0.3, 0.6])] + over(T3, PAIRS + [[0.4, 0.4]]),
    "triangle_fold": [(SLIVER, [0.3, 0.6])] + over(T3, PAIRS + [[0.9, 0.4]]),
    "quaternion": over({}, TRIPLES),
    "ellipsoid": [({"s1": 1.0, "s2": 1.0, "s3": 1e-8}, [0.3, 0.6])] + over({"s1": 2.0, "s2": 1.0, "s3": 0.5}, PAIRS),
    "torus": over({"large": 2.0, "small": 0.6}, [[0.3, 0.6], [0.7183098861837907, 0.15915494309189535], [TINY, 0.3], [BELOW_ONE, 0.25], [0.4, 0.0],
                                                 [0.4, 0.5]]) + [({"large": 1.0, "small": 1 - 2.0**-20}, [0.3, 0.5]), ({"large": 1e3, "small": 1e-3}, [0.3, 0.2])],
    "shell": [({"a": 1.0, "b": 1 + 2.0**-30}, [0.3, 0.2, 0.6])] + over({"a": 0.5, "b": 2.0}, TRIPLES) + [({"a": 0.0, "b": 1.0}, [TINY, 0.2, 0.6])],
    "tetrahedron": over(CRATE, TRIPLES),
    "simplex": over({}, PAIRS),
    "ordered": over({}, TRIPLES[:4] + [[0.5, BELOW_ONE, 0.3], [0.2, 0.7, BELOW_ONE], [0.5, 1e-9, 1e-9]]),
    "correlation_factor": over({}, [[BELOW_ONE, 0.5, 0.5]] + TRIPLES[:6] + [[0.2, 0.7, BELOW_ONE]]),
}

NAN, INF = float("nan"), float("inf")


def outside(params, *points):
    """Points without a density."""
    return [(params, list(x), False) for x in points]


def inside(params, *points):
    """Points with one."""
    return [(params, list(x), True) for x in points]


BELOW = outside({}, (0.0, 0.6, -0.8), (0.0, 0.6, 0.1), (0.0, 0.0, -1.0), (NAN, 0.0, 1.0))
NORTH = (0.0, 0.0, 1.0)


def given(params, queries):
    """The same queries with other parameters."""
    return [(params, x, good) for _, x, good in queries]


QUERIES = {
    "smoothstep": outside({"a": 0.0, "b": 1.0}, [-0.1], [1.1], [NAN]) + inside({"a": 0.0, "b": 1.0}, [0.0], [0.25], [1.0]),
    "epanechnikov": outside({}, [-1.1], [1.5], [NAN]) + inside({}, [0.0], [-0.75], [1.0]),
    "logistic": inside({"s": 1.0}, [800.0], [0.0], [-700.0]) + outside({"s": 1.0}, [INF], [NAN]),
    "truncated_logistic": outside({"s": 1.0, "a": -2.0, "b": 3.0}, [-2.5], [3.5], [NAN]) + inside({"s": 1.0, "a": -2.0, "b": 3.0}, [0.0], [2.5]),
    "normal": inside({"m": 0.0, "s": 1.0}, [0.0], [-37.0], [8.0]) + outside({"m": 0.0, "s": 1.0}, [INF], [NAN]),
    "lower_normal": outside({"a": -9.0, "b": -8.0}, [-9.5], [-7.5], [NAN]) + inside({"a": -9.0, "b": -8.0}, [-8.5]),
    "upper_normal": outside({"a": 8.0, "b": 9.0}, [7.5], [9.5], [NAN]) + inside({"a": 8.0, "b": 9.0}, [8.5]),
    "cauchy": inside({"g": 1.0}, [-1e9], [0.0], [1e9]) + outside({"g": 1.0}, [INF], [NAN]),
    "pareto": outside({"m": 1.0, "s": 2.0, "xi": -0.5}, [0.5], [5.5], [NAN]) + inside({"m": 1.0, "s": 2.0, "xi": -0.5}, [1.0], [2.5]),
    "kumaraswamy": outside({"a": 2.0, "b": 3.0}, [-0.1], [1.1], [NAN]) + inside({"a": 2.0, "b": 3.0}, [0.0], [0.25]),
    "power_law": outside({"a": 1.0, "b": 2.0, "p": 2.0}, [0.5], [2.5], [NAN]) + inside({"a": 1.0, "b": 2.0, "p": 2.0}, [1.0], [1.5]),
    "sinh_arcsinh": inside({"e": 0.5, "d": 1.5}, [0.0], [-3.0], [100.0]) + outside({"e": 0.5, "d": 1.5}, [NAN]),
    "heavy_tails": inside({"h": 0.25}, [-1e9], [1e-9], [3.0]) + outside({"h": 0.25}, [NAN]),
    "truncated_logistic_as_printed": outside({"s": 1.0, "a": -2.0, "b": 3.0}, [-2.5], [3.5], [NAN]) + inside({"s": 1.0, "a": -2.0, "b": 3.0}, [0.0], [2.5]),
    "anisotropic_normals": outside(BRUSHED, [0.6, 0.0, -0.8], [-0.8, -0.6, 0.0], [0.0, 0.6, 0.1], [NAN, 0.0, 1.0]) + inside(BRUSHED, NORTH, [0.6, 0.0, 0.8]),
    "anisotropic_normals_as_printed": outside(BRUSHED, [-0.8, -0.6, 0.0], [0.0, 0.6, 0.1], [NAN, 0.0, 1.0]) + inside(BRUSHED, NORTH, [0.6, 0.0, 0.8]),
    "equiangular": outside({"d": 1.0, "a": -1.0, "b": 3.0}, [-1.5], [3.5], [NAN]) + inside({"d": 1.0, "a": -1.0, "b": 3.0}, [0.0], [2.0]),
    "linear_extinction": outside({"a": 1.0, "b": 2.0}, [-0.1], [NAN], [INF]) + inside({"a": 1.0, "b": 2.0}, [0.0], [0.75]),
    "falling_extinction": outside({"k": 1.0, "h": 0.5}, [-0.1], [NAN]) + inside({"k": 1.0, "h": 0.5}, [0.0], [0.75], [20.0]),
    "kepler": outside({"e": 0.6}, [-0.1], [6.5], [NAN]) + inside({"e": 0.6}, [0.0], [1.5], [5.0]),
    "hyperexponential": outside({"p": 0.3, "l": 2.0, "m": 0.1}, [-0.1], [NAN], [INF]) + inside({"p": 0.3, "l": 2.0, "m": 0.1}, [0.0], [0.75], [100.0]),
    "heitz_normals": outside(STEEP, [0.6, 0.0, -0.8], [-0.8, -0.6, 0.0], [0.0, 0.6, 0.1], [NAN, 0.0, 1.0])
    + inside(STEEP, NORTH, [0.6, 0.0, 0.8], [-0.48, 0.64, 0.6]),
    "seen_triangle": outside(SEEN_TRIANGLE, [0.0, 0.0, -1.0], [0.6, 0.0, -0.8], [-0.6, 0.8, 0.0], [0.0, 0.6, 0.1], [NAN, 0.0, 1.0])
    + inside(SEEN_TRIANGLE, [0.6, 0.48, 0.64], [0.36, 0.48, 0.8]),
    "seen_rectangle": outside(SEEN_RECTANGLE, [0.0, 0.0, -1.0], [0.6, 0.0, 0.8], [0.48, -0.64, -0.6], [0.0, 0.6, 0.1], [NAN, 0.0, 1.0])
    + inside(SEEN_RECTANGLE, [0.6, 0.0, -0.8], [0.48, 0.36, -0.8]),
    "small_angles": outside(RING, NORTH, [0.0, 0.6, -0.8], [0.0, 1.0, 0.0], [NAN, 0.0, 1.0]) + inside(RING, [0.6, 0.0, 0.8], [0.0, -0.28, 0.96]),
    "thin_lens": outside(LENS, [0.6, 0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 0.0, -1.0], [0.0, 0.0, 0.8, 0.0, 0.6], [0.0, 0.25, NAN, 0.0, 1.0])
    + inside(LENS, [0.0, 0.0, 0.0, 0.0, 1.0], [0.25, -0.25, 0.0, 0.28, 0.96]),
    "portal_segment": outside(PORTAL, [0.0, 0.0, 2.0, 3.0, 3.0, -1.0], [0.0, 0.0, 2.0, -1.5, 0.0, -1.0], [0.25, 0.25, 1.5, 0.25, 0.25, -1.0],
                              [NAN, 0.0, 2.0, 0.0, 0.0, -1.0])
    + inside(PORTAL, [0.25, 0.25, 2.0, 0.25, 0.25, -1.0], [1.5, -0.75, 2.0, -0.5, 0.75, -1.0]),
    "tilted_portal": outside(ATTIC, [0.5, 0.25, 2.0, 0.25, 0.25, -1.5], [0.5, 0.25, 2.0, 4.0, 0.25, -1.21875], [NAN, 0.25, 2.0, 0.25, 0.25, -1.21875])
    + inside(ATTIC, [0.5, 0.25, 2.0, 0.25, 0.25, -1.21875], [0.5, 0.25, 2.0, 0.0, -0.02, -1.14], [1.0, 1.25, 2.15, 0.0, -0.26, -1.07]),
    "equal_area_octahedral": outside({}, [0.0, 0.6, 0.1], [NAN, 0.0, 1.0]) + inside({}, [0.6, 0.48, 0.64], [-0.6, 0.48, -0.64], [0.6, -0.48, -0.64], [-0.48, -0.64, 0.6]),
    "visible_normals": outside(VIEW, [0.6, 0.0, -0.8], [-0.8, -0.6, 0.0], [0.0, 0.6, 0.1], [NAN, 0.0, 1.0]) + inside(VIEW, NORTH, [0.6, 0.0, 0.8], [-0.48, 0.64, 0.6]),
    "reflected_ggx": inside(VIEW, NORTH, [0.6, 0.0, 0.8], [-0.48, -0.64, 0.6], [-0.6, 0.0, -0.8]) + outside(VIEW, [0.0, 0.6, 0.1], [NAN, 0.0, 1.0]),
    "refracted_ggx": outside(GLASS, NORTH, [0.6, 0.0, 0.8], [0.0, 0.6, 0.1], [NAN, 0.0, 1.0]) + inside(GLASS, [0.0, 0.0, -1.0], [-0.6, 0.0, -0.8]),
    "bilinear_patch": outside(SADDLE, [3.0, 0.0, 0.0], [1.0, 0.75, 1.0], [NAN, 0.0, 0.0]) + inside(WALL, [0.5, 1.0, 0.5], [0.5, 0.25, 0.75])
    + outside(WALL, [0.5, 2.5, 0.5], [0.75, 1.0, 0.5], [0.5, 1.0, -0.25]),
    "cubic": outside({}, [-0.01], [0.07], [NAN]) + inside({}, [0.03125], [0.001], [0.0624]),
    "elliptical_grid": outside({}, [0.8, 0.8], [-2.0, 0.0], [NAN, 0.0]) + inside({}, [0.0, 0.0], [0.5, 0.5], [-0.5, 0.5], [0.0, -0.9]),
    "bilinear_density": outside(WEIGHTS, [-0.1, 0.5], [0.5, 1.1], [NAN, 0.5]) + inside(WEIGHTS, [0.0, 0.0], [0.25, 0.75]),
    "complex_square_xy": outside({}, [1.5, 0.0], [-0.9, 0.9], [NAN, 0.0]) + inside({}, [0.5, 0.0], [0.0, -0.25], [-0.5, 0.0]),
    "rayleigh": inside({}, NORTH, [0.0, 0.0, -1.0], [0.6, 0.0, -0.8], [1.0, 0.0, 0.0]) + outside({}, [0.0, 0.6, 0.1], [NAN, 0.0, 1.0]),
    "sphere_light": outside(BULB, [0.0, 0.0, 2.0], [0.0, 0.0, 0.6], [0.75, 0.0, 1.25], [0.45, 0.0, 1.85], [NAN, 0.0, 0.5]) + inside(BULB, [0.0, 0.0, 0.5]),
    "chained_frames": outside({}, [0.0, 0.6, -0.8, 0.0, 0.0, -1.0], [0.0, 0.6, 0.8, 0.0, 0.0, -1.0], [0.0, 0.6, 0.1, 0.0, 0.0, 1.0], [0.0, 0.6, 0.8, 0.0, 0.6, 0.1],
                              [NAN, 0.0, 1.0, 0.0, 0.0, 1.0])
    + inside({}, [0.0, 0.6, 0.8, 0.0, 0.0, 1.0], [0.6, 0.0, 0.8, 0.8, 0.0, 0.6], [0.6, 0.0, 0.8, 0.96, 0.0, -0.28]),
    "scattered_twice": outside({"g": 0.75, "n": 20.0}, [0.0, 0.6, 0.8, 0.0, 0.0, -1.0], [0.0, 0.6, -0.8, 0.0, 0.6, 0.8], [0.0, 0.6, 0.1, 0.0, 0.0, 1.0],
                               [0.0, 0.6, 0.8, 0.0, 0.6, 0.1], [NAN, 0.0, 1.0, 0.0, 0.0, 1.0])
    + inside({"g": 0.75, "n": 20.0}, [0.0, 0.6, 0.8, 0.0, 0.0, 1.0], [0.6, 0.0, -0.8, 0.8, 0.0, -0.6], [0.0, 0.0, 1.0, 0.48, 0.64, 0.6], [0.0, 0.0, -1.0, 0.6, 0.0, -0.8]),
    "scattering_vertex": outside(HAZE, [2.5, 0.0, 0.0], [0.0, 0.0, -2.25], [NAN, 0.0, 0.0]) + inside(HAZE, [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.5, -0.25, 0.25]),
    "stick_breaking": outside({}, [0.5, 0.5, 0.5, 0.5], [0.5, 0.75, -0.25, 0.0], [0.25, 0.25, 0.25, 0.3])
    + inside({}, [0.25, 0.25, 0.25, 0.25], [0.5, 0.125, 0.125, 0.25], [0.0, 0.5, 0.25, 0.25]),
    "regular_polygon": outside({"n": 6.0}, [1.0, 0.1], [0.0, 0.9], [-0.9, 0.5]) + inside({"n": 6.0}, [0.1, 0.2], [-0.8, 0.0], [0.0, 0.0])
    + outside({"n": 4.0}, [0.6, 0.5]) + inside({"n": 4.0}, [0.001, 0.001], [-0.3, -0.6]),
    "pentagon": outside({}, [1.0, 0.1], [-0.9, 0.0], [0.0, 1.0]) + inside({}, [0.1, 0.2], [-0.8, 0.0], [0.0, 0.0]),
    "zonal_window": outside(WINDOW, [0.6, 0.0, 0.8], [0.6, 0.8, 0.0], [0.0, -1.0, 0.0]) + inside(WINDOW, [-1.0, 0.0, 0.0], [-0.8, 0.0, 0.6]),
    "helix": outside(COIL, [1.5, 0.0, 0.1], [0.0, 0.0, 1.0], [1.5, 0.0, 5.0]) + inside(COIL, [1.5, 0.0, 0.0]),
    "truncated_cone": outside(FRUSTUM, [0.5, 0.0, 0.5], [0.0, 0.0, 1.0], [1.0, 0.0, -0.5]) + inside(FRUSTUM, [1.0, 0.0, 0.0], [0.0, -0.625, 1.0]),
    "onto_plane": outside(NEAR, [0.0, 0.0, -1e-6], [1e-6, 0.0, 2e-6], [NAN, 0.0, 1e-6]) + inside(NEAR, [0.0, 0.0, 1e-6], [1e-6, 1e-6, 1e-6]),
    "tent": outside({"r": 2.0}, [2.5], [-2.5], [NAN], [INF]) + inside({"r": 2.0}, [0.0], [1.0]),
    "triangular": outside(ISOSCELES, [-1.5], [3.5], [NAN]) + inside(ISOSCELES, [0.0], [0.75]),
    "student_2": inside({}, [-1e9], [0.0], [1e9]) + outside({}, [INF], [NAN]),
    "student": inside({"nu": 3.5}, [-1e9], [0.0], [1e-9], [1e9]) + outside({"nu": 3.5}, [INF], [NAN]),
    "laplace": inside({"b": 1.0}, [-700.0], [0.0], [700.0]) + outside({"b": 1.0}, [INF], [NAN]),
    "rational_quadratic": outside(RQ, [-0.1], [1.6], [NAN]) + inside(RQ, [0.0], [0.75]),
    "cosine": outside({}, [-1.5], [1.5], [NAN]) + inside({}, [0.0], [-0.5], [0.951]),
    "parabola": outside({}, [-0.5], [1.5], [NAN]) + inside({}, [0.0], [0.75]),
    "square": outside({}, [-0.5], [1.5], [NAN]) + inside({}, [0.25], [0.01]),
    "fold": outside({}, [-0.5], [1.5], [NAN]) + inside({}, [0.25], [0.5]),
    "sawtooth": outside({"k": 3.0}, [-0.5], [1.5], [NAN]) + inside({"k": 3.0}, [0.25], [0.5]) + inside({"k": 2.5}, [0.25], [0.75]),
    "concentric_disk": outside({}, [0.8, 0.8], [-2.0, 0.0], [NAN, 0.0]) + inside({}, [0.0, 0.0], [0.5, 0.5], [-0.5, 0.5], [0.0, -0.9]),
    "annular_sector": outside(SECTOR, [0.0, 0.0], [1.5, 0.0], [-3.0, 0.0], [0.0, 1.5]) + inside(SECTOR, [-1.5, 0.0], [0.0, -1.5]),
    "bivariate_normal": inside(CHOLESKY, [0.0, 0.0], [10.0, 1.0]) + outside(CHOLESKY, [NAN, 0.0], [INF, 0.0]),
    "ggx_slopes": inside({"alpha": 0.3}, [0.0, 0.0], [1e6, 0.0]) + outside({"alpha": 0.3}, [NAN, 0.0]),
    "bilinear_quad": outside(QUAD, [3.0, 0.0], [-1.0, 0.5], [1.0, 3.0], [NAN, 0.0]) + inside(QUAD, [1.0, 0.75], [0.0, 0.0]),
    "complex_square": outside({}, [1.5, 0.0], [-0.9, 0.9], [NAN, 0.0]) + inside({}, [0.5, 0.0], [0.0, -0.25]),
    "radial_flow": inside(FLOW, [0.0, 0.0], [3.0, 4.0]) + outside(FLOW, [NAN, 0.0]),
    "affine_coupling": inside(COUPLING, [0.0, 0.0], [3.0, -4.0], [-700.0, 0.0]) + outside(COUPLING, [NAN, 0.0]),
    "cone": given({"m": 0.1}, BELOW) + outside({"m": 0.1}, [0.6, 0.0, 0.8]) + inside({"m": 0.1}, NORTH),
    "concentric_hemisphere": BELOW + inside({}, NORTH, [0.6, 0.0, 0.8], [0.0, 1.0, 0.0]),
    "double_lune": outside({"t": 0.3}, [0.0, 0.6, 0.8], [0.0, -1.0, 0.0]) + inside({"t": 0.3}, [0.6, 0.0, 0.8], [-1.0, 0.0, 0.0]),
    "von_mises_fisher": inside({"kappa": 10.0}, NORTH, [0.0, 0.0, -1.0], [0.6, 0.0, -0.8]) + outside({"kappa": 10.0}, [0.0, 0.6, 0.1]),
    "henyey_greenstein": inside({"g": 0.8}, NORTH, [0.0, 0.0, -1.0], [0.6, 0.0, -0.8]) + outside({"g": 0.8}, [0.0, 0.6, 0.1]),
    "transformed_cosine": outside(MATRIX, [0.0, 0.6, -0.8], [0.0, 0.6, 0.1], [0.0, 0.0, -1.0]) + inside(MATRIX, NORTH, [0.6, 0.0, 0.8]),
    "beckmann": given({"alpha": 0.3}, BELOW) + inside({"alpha": 0.3}, NORTH, [0.6, 0.0, 0.8]),
    "ggx": given({"alpha": 0.2}, BELOW) + inside({"alpha": 0.2}, NORTH, [0.6, 0.0, 0.8]),
    "anisotropic_ggx": given({"ax": 0.1, "ay": 0.5}, BELOW) + inside({"ax": 0.1, "ay": 0.5}, NORTH, [0.6, 0.0, 0.8]),
    "ashikhmin_shirley": given({"nu": 10.0, "nv": 200.0}, BELOW) + inside({"nu": 10.0, "nv": 200.0}, NORTH, [0.6, 0.0, 0.8], [0.0, 0.6, 0.8]),
    "mixture": given(MIX, BELOW) + inside(MIX, NORTH, [0.6, 0.0, 0.8]),
    "sheen": given({"alpha": 0.4}, BELOW) + inside({"alpha": 0.4}, [0.6, 0.0, 0.8], [0.0, 0.8, 0.6]),
    "perspective": given({"t": 0.7, "a": 0.6}, BELOW) + outside({"t": 0.7, "a": 0.6}, [0.6, 0.0, 0.8], [0.6, 0.0, -0.8]) + inside({"t": 0.7, "a": 0.6}, NORTH),
    "triangle": outside(T3, [0.0, 0.0, 0.0], [2.0, 2.0, 1.0], [0.7, 0.5, 1.0], [NAN, 0.0, 0.0]) + inside(T3, [0.0, 0.0, 1.0], [2.0, 0.0, 1.5], [0.3, 1.7, 0.2], [1.0, 0.0, 1.25]),
    "triangle_heitz": outside(T3, [0.0, 0.0, 0.0], [2.0, 2.0, 1.0], [0.7, 0.5, 1.0]) + inside(T3, [0.0, 0.0, 1.0], [1.0, 0.0, 1.25]),
    "triangle_fold": outside(T3, [0.0, 0.0, 0.0], [2.0, 2.0, 1.0], [0.7, 0.5, 1.0]) + inside(T3, [0.0, 0.0, 1.0], [1.0, 0.0, 1.25]),
    "quaternion": outside({}, [0.5, 0.5, 0.5, 0.6], [0.0, 0.0, 0.0, 0.0]) + inside({}, [0.5, 0.5, 0.5, 0.5], [-0.5, -0.5, 0.5, -0.5], [0.0, 0.0, 0.0, 1.0]),
    "ellipsoid": outside({"s1": 2.0, "s2": 1.0, "s3": 0.5}, [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]) + inside({"s1": 2.0, "s2": 1.0, "s3": 0.5}, [2.0, 0.0, 0.0], [0.0, 0.0, -0.5]),
    "torus": outside({"large": 2.0, "small": 0.6}, [2.0, 0.0, 0.0], [0.0, 0.0, 0.0], [2.0, 0.0, 0.5]) + inside({"large": 2.0, "small": 0.6}, [2.0, 0.0, 0.6], [0.0, -2.6, 0.0]),
    "shell": outside({"a": 0.5, "b": 2.0}, [0.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.1, 0.1, 0.1]) + inside({"a": 0.5, "b": 2.0}, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.5]),
    "tetrahedron": outside(CRATE, [1.0, 1.0, 1.0], [-0.1, 0.0, 0.0], [NAN, 0.0, 0.0]) + inside(CRATE, [0.25, 0.125, 0.25], [0.0, 0.0, 0.0]),
    "simplex": outside({}, [0.5, 0.5, 0.4], [0.5, 0.75, -0.25], [-0.25, 0.5, 0.75]) + inside({}, [0.25, 0.25, 0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
    "ordered": outside({}, [1.0, 0.0, 2.0], [1.0, 2.0, 1.5]) + inside({}, [-1.0, 0.5, 2.5]),
    "correlation_factor": outside({}, [0.6, 0.8, 0.6, 0.8, 0.5], [0.6, -0.8, 0.0, 0.0, 1.0]) + inside({}, [0.6, 0.8, 0.0, 0.0, 1.0], [0.0, 1.0, 0.6, 0.0, 0.8]),
}


# Samplers that are in the catalogue in a second spelling too, as they are usually printed.
AS_PRINTED = ["equiangular", "von_mises_fisher", "henyey_greenstein"]


def spellings(s):
    """The sampler under all of its names."""
    return [s, s._replace(name=s.name + "_as_printed")] if s.name in AS_PRINTED else [s]


def cleaned(s):
    """The sampler with exact zeros, and an infinite density where the closed form divides by zero."""

    def sample(u, p):
        return [t if abs(t) > NOISE else mpf(0) for t in s.sample(u, p)]

    def density(x, p):
        try:
            return s.density(x, p)
        except ZeroDivisionError:
            return inf

    return s._replace(sample=sample, density=density)


def main():
    """Computes all entries and writes the file, one entry per line."""
    entries = []
    for s in (cleaned(t) for s in LINE + PLANE + DIRECTIONS + SPACE for t in spellings(s)):
        name = s.name if s.name in POINTS else s.name.removesuffix("_as_printed")
        for params, u in POINTS[name]:
            found = entry_for(s, params, u, F64)
            if found is None:
                raise SystemExit(f"row {s.row}: {params}, {u} is outside the domain")
            if "nan" in found.values():
                raise SystemExit(f"row {s.row}: {params}, {u} has no density")
            entries.append({"row": s.row, "name": s.name, "kind": "point"} | found)
        entries += [query_for(s, params, x, good) for params, x, good in QUERIES[name]]
    lines = ",\n".join(json.dumps(e, allow_nan=False) for e in entries)
    OUTPUT.write_text("[\n" + lines + "\n]\n")
    print(f"{len(entries)} entries, {OUTPUT.stat().st_size} bytes")


if __name__ == "__main__":
    main()
