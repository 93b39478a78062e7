#!/usr/bin/env python3
"""Reference values of the special functions: `make_special.py > special.txt` (needs mpmath).

Every argument is a single-precision number where the second column says 32, so that both
precisions can be tried on it, else a double. The value is printed as the sum of two doubles.
"""
import struct
from mpmath import mp, mpf, erf, erfc, erfinv, exp, log, sqrt, pi, lambertw, loggamma

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


print("# function, bits of the argument, argument, value (two parts); by make_special.py")
real = both(sweep(1e-300, 1e-2, 20) + sweep(1e-2, 6.5, 120))
show("erf", real, erf)
show("erfc", real + sweep(6.5, 26.5, 60), erfc)
show("normal_cdf", real + both(sweep(6.5, 8, 10)) + [-x for x in sweep(8, 37.4, 60)], lambda x: erfc(-x / sqrt(2)) / 2)
small = sweep(1e-307, 1e-30, 60) + sweep(1e-30, 1e-3, 40) + sweep(1e-3, 0.5, 80)
near_one = [1 - x for x in sweep(1e-15, 0.5, 60)]
show("erf_inv", both(sweep(1e-300, 1e-2, 20) + sweep(1e-2, 0.5, 60) + near_one), erf_inv)
show("erfc_inv", [2 * x for x in small + near_one], erfc_inv)
show("normal_quantile", small + near_one, lambda u: -sqrt(2) * erfc_inv(2 * u))
above = [float(-exp(-1) + mpf(t)) for t in sweep(1e-15, 0.3, 80)]
above = [x for x in above if x > -exp(-1)]
show("lambert_w", both(sweep(1e-300, 1e-2, 20)) + above + sweep(1e-2, 100, 80) + sweep(100, 1e300, 40), lambda x: lambertw(x).real)
show("ln_gamma", sweep(1e-10, 1e-2, 20) + sweep(1e-2, 100, 120) + sweep(100, 1e30, 30), loggamma)
