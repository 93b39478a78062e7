#!/usr/bin/env python3
"""Reference values of the special functions: `make_special.py > special.txt` (needs mpmath).

Every argument is a single-precision number where the second column says 32, so that both
precisions can be tried on it, else a double. Parameters come before the argument. The value is printed as
the sum of two doubles.
"""
import struct
from mpmath import mp, mpf, beta, betainc, erf, erfc, erfinv, exp, expm1, log, sqrt, pi, lambertw, loggamma

mp.dps = 60


def f32(x):
    return struct.unpack("f", struct.pack("f", x))[0]


def erfc_inv(y):
    y = mpf(y)
    if y > 1:
        return -erfc_inv(2 - y)
    if y > mpf("0.3"):
        return erfinv(1 - y)
    w = sqrt(-log(y))
    for _ in range(80):
        e = erfc(w)
        step = (log(e) - log(y)) * e * sqrt(pi) / 2 * exp(w * w)
        w += step
        if abs(step) < mpf(10) ** -50:
            return w
    raise ArithmeticError(y)


def scaled(x):
    """1 / (sqrt(pi) exp(x^2) erfc(x)), by a continued fraction far out."""
    if x < 20:
        return exp(-x * x) / erfc(x) / sqrt(pi)
    rest = mpf(0)
    for n in range(600, 0, -1):
        rest = mpf(n) / 2 / (x + rest)
    return x + rest


def ln_erfc(x):
    return log(erfc(x)) if x < 20 else -x * x - log(scaled(x) * sqrt(pi))


def erfc_inv_exp(l):
    if l > -1:
        return erf_inv(-expm1(l))
    w = sqrt(-l)
    for _ in range(80):
        step = (ln_erfc(w) - l) / scaled(w) / 2
        w += step
        if abs(step) < mpf(10) ** -50 * w:
            return w
    raise ArithmeticError(l)


def erf_inv(x):
    return -erf_inv(-x) if x < 0 else erfc_inv(1 - mpf(x)) if x > 0.5 else erfinv(mpf(x))


def sweep(lo, hi, n):
    """Numbers with equal ratios, a little off round ones."""
    return [float(mpf(lo) * (mpf(hi) / mpf(lo)) ** (mpf(i) / n)) * (1 + 1e-3) for i in range(n)]


def show(name, xs, f):
    seen = set()
    for x in xs:
        for x, bits in ((f32(x) if abs(x) < 3e38 else x, 32), (x, 64)):
            if x in seen or (bits == 32 and (abs(x) < 1.2e-38 or abs(x) > 3e38)):
                continue
            seen.add(x)
            if name == "lambert_w" and x < -exp(-1):
                continue
            if name == "erf_inv" and abs(x) >= 1:
                continue
            if name in ("erfc_inv", "normal_quantile") and x >= (2 if name == "erfc_inv" else 1):
                continue
            y = f(mpf(x))
            hi = float(y)
            if hi == 0 or abs(hi) < 3e-308:
                continue
            print(name, bits, repr(x), repr(hi), repr(float(y - hi)))


def both(xs):
    return [s * x for x in xs for s in (1, -1)]


print("# function, bits of the argument, parameters, argument, value (two parts); by make_special.py")
real = both(sweep(1e-300, 1e-2, 20) + sweep(1e-2, 6.5, 120))
show("erf", real, erf)
show("erfc", real + sweep(6.5, 26.5, 60), erfc)
show("normal_cdf", real + both(sweep(6.5, 8, 10)) + [-x for x in sweep(8, 37.4, 60)], lambda x: erfc(-x / sqrt(2)) / 2)
small = sweep(1e-307, 1e-30, 60) + sweep(1e-30, 1e-3, 40) + sweep(1e-3, 0.5, 80)
near_one = [1 - x for x in sweep(1e-15, 0.5, 60)]
show("erf_inv", both(sweep(1e-300, 1e-2, 20) + sweep(1e-2, 0.5, 60) + near_one), erf_inv)
show("erfc_inv", [2 * x for x in small + near_one], erfc_inv)
show("normal_quantile", small + near_one, lambda u: -sqrt(2) * erfc_inv(2 * u))
show("ln_erfc", real + sweep(6.5, 1e3, 60) + sweep(1e3, 1e18, 20), ln_erfc)
logs = [-x for x in sweep(1e-30, 1e-2, 20) + sweep(1e-2, 2e3, 140) + sweep(2e3, 1e37, 30)]
show("erfc_inv_exp", logs + sweep(1e-30, 0.69, 30), erfc_inv_exp)
above = [float(-exp(-1) + mpf(t)) for t in sweep(1e-15, 0.3, 80)]
above = [x for x in above if x > -exp(-1)]
show("lambert_w", both(sweep(1e-300, 1e-2, 20)) + above + sweep(1e-2, 100, 80) + sweep(100, 1e300, 40), lambda x: lambertw(x).real)
show("ln_gamma", sweep(1e-10, 1e-2, 20) + sweep(1e-2, 100, 120) + sweep(100, 1e30, 30), loggamma)


def below(a, b, x, y):
    """I(x; a, b); large parameters by a series of positive terms."""
    if b < 30:
        return betainc(a, b, 0, x, regularized=True)
    term, total, k = mpf(1), mpf(0), 0
    while term > total * mpf(10) ** -60:
        total += term
        term *= (a + b + k) / (a + 1 + k) * x
        k += 1
    return x**a * y**b / (a * beta(a, b)) * total


def tails(a, b, x, y):
    """I(x; a, b) with y = 1 - x, and the rest to one, neither as a difference where it is small."""
    if x < a / (a + b):
        low = below(a, b, x, y)
        return low, 1 - low
    high = below(b, a, y, x)
    return 1 - high, high


def beta_inc_inv(a, b, p):
    """Newton's method on the logarithm of the smaller tail, in ln(x / (1 - x))."""
    t, lower = log(a / b), p <= 0.5
    for _ in range(200):
        x, y = 1 / (1 + exp(-t)), 1 / (1 + exp(t))
        value = tails(a, b, x, y)[0 if lower else 1]
        slope = x**a * y**b / beta(a, b) / value
        step = (log(p) - log(value)) / slope if lower else (log(value) - log(1 - p)) / slope
        t += step
        if abs(step) < mpf(10) ** -45 * (1 + abs(t)):
            return 1 / (1 + exp(-t))
    raise ArithmeticError((a, b, p))


def show_beta(name, a, b, xs, f):
    """Lines for all parameters that single precision has; arguments of both precisions."""
    for x in sorted({f32(x) for x in xs if f32(x) > 1.2e-38} | set(xs)):
        if not 0 < x < 1:
            continue
        y = f(mpf(a), mpf(b), mpf(x))
        hi = float(y)
        if 3e-308 < hi < 1:
            print(name, 32 if f32(x) == x else 64, a, b, repr(x), repr(hi), repr(float(y - hi)))


PARAMETERS = [0.25, 0.5, 1.75, 5.0, 40.0, 1000.0]
for a in PARAMETERS:
    for b in PARAMETERS:
        y = log(beta(mpf(a), mpf(b)))
        if abs(y) > 1e-30:
            print("ln_beta", 32, a, b, repr(float(y)), repr(float(y - float(y))))
        mean, spread = a / (a + b), (a * b / (a + b + 1)) ** 0.5 / (a + b)
        around = [mean + k * spread for k in (-9, -3, -0.7, 0, 0.8, 2.5, 7)]
        ends = [mean * s for s in (1e-30, 1e-6, 0.01, 0.4)] + [1 - (1 - mean) * s for s in (1e-9, 1e-3, 0.3)]
        show_beta("beta_inc", a, b, around + ends, lambda a, b, x: tails(a, b, x, 1 - x)[0])
        levels = [1e-300, 1e-30, 1e-8, 0.013, 0.31, 0.5, 0.77, 0.993, 1 - 1e-7, 1 - 1e-15]
        show_beta("beta_inc_inv", a, b, levels, beta_inc_inv)
