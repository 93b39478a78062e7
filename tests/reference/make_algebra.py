#!/usr/bin/env python3
"""Reference values for `tests/algebra.rs`: `make_algebra.py > algebra.txt` (needs mpmath).

A line holds the number of the sampler, its parameters and uniform (exact doubles), the sample, the
density there, the density at the sample rounded to a double, and three relative condition numbers:
of the sample in uniform and parameters, of the density in point and parameters, and of the density
of the sample in uniform and parameters.
"""
from mpmath import *

mp.dps = 50
L=log1p;E=expm1
def lg(u): return log(u)-L(-u)
def Phi(x): return erfc(-x/sqrt(2))/2
def Q(u):
    if u==0.5: return mpf(0)
    # quantile by newton on log cdf
    if u>0.5: return -Q(1-u)
    x=-sqrt(-2*log(u))
    for _ in range(100):
        e=Phi(x); st=(log(e)-log(u))*e*sqrt(2*pi)*exp(x*x/2); x-=st
        if abs(st)<mpf(10)**-45: break
    return x
def F(x): return 1/(1+exp(-x))
def phi(x): return exp(-x*x/2)/sqrt(2*pi)
def flog(x,s=1): a=abs(x)/s; return exp(-a)/(s*(1+exp(-a))**2)
def w26(D,a,b): return atan2((b-a)*D,D*D+a*b)
rows={
9:(lambda u:2*sin(asin(2*u-1)/3), lambda x:(1-x*x)*3/4),
10:(lambda u,s:s*lg(u), lambda x,s:flog(x,s)),
11:(lambda u,s,a,b:s*(lambda v,q:log(v/q))((1-u)*F(a/s)+u*F(b/s),(1-u)*F(-a/s)+u*F(-b/s)), lambda x,s,a,b:flog(x,s)/(F(b/s)-F(a/s) if a<0 else F(-a/s)-F(-b/s))),
12:(lambda u,m,s:m+s*Q(u), lambda x,m,s:phi((x-m)/s)/s),
13:(lambda u,a,b:-Q((1-u)*Phi(-a)+u*Phi(-b)) if a>0 else Q((1-u)*Phi(a)+u*Phi(b)), lambda x,a,b:phi(x)/(Phi(-a)-Phi(-b) if a>0 else Phi(b)-Phi(a))),
14:(lambda u,g:-g*cot(pi*u), lambda x,g:g/(pi*(g*g+x*x))),
20:(lambda u,m,s,xi:m+s*E(-xi*L(-u))/xi, lambda x,m,s,xi:(1+xi*(x-m)/s)**(-1/xi-1)/s),
21:(lambda u,a,b:(-E(L(-u)/b))**(1/a), lambda x,a,b:a*b*x**(a-1)*(1-x**a)**(b-1)),
22:(lambda u,a,b,p:a*exp(L(u*E((1-p)*log(b/a)))/(1-p)), lambda x,a,b,p:(1-p)*(x/a)**(-p)/(a*E((1-p)*log(b/a)))),
24:(lambda u,e,d:sinh((asinh(lg(u))+e)*d), lambda x,e,d:(lambda t:flog(sinh(t))*cosh(t)/(d*sqrt(1+x*x)))(asinh(x)/d-e)),
25:(lambda u,h:lg(u)*exp(h*lg(u)**2/2), lambda x,h:(lambda z:flog(z)*exp(-h*z*z/2)/(1+h*z*z))(sign(x)*sqrt(lambertw(h*x*x).real/h))),
26:(lambda u,D,a,b:D*tan(atan2(a,D)+u*w26(D,a,b)), lambda x,D,a,b:D/(w26(D,a,b)*(D*D+x*x))),
27:(lambda u:mpf('538')-mpf('138.888889')*atanh(mpf('0.85691062')-mpf('1.82750197')*u), lambda x:1/(mpf('138.888889')*mpf('1.82750197')*cosh((mpf(538)-x)/mpf('138.888889'))**2)),
28:(lambda u,a,b:(lambda t:2*t/(a+sqrt(a*a+2*b*t)))(-L(-u)), lambda x,a,b:(a+b*x)*exp(-a*x-b*x*x/2)),
29:(lambda u,k,h:-L(h*L(-u)/k)/h, lambda x,k,h:k*exp(-h*x)*exp(k*E(-h*x)/h)),
33:(lambda u:cos(2*pi*u), lambda x:1/(pi*sqrt((1-x)*(1+x)))),
}

# Parameters that are tried at all uniforms of UNIFORMS.
PARAMETERS = {
    9: [()], 10: [(1.0,)], 11: [(1.0, -2.0, 3.0), (0.1, 5.0, 6.0)], 12: [(0.0, 1.0), (3.0, 0.25)],
    13: [(8.0, 9.0), (0.5, 2.0)], 14: [(1.0,), (20.0,)], 20: [(0.0, 1.0, 0.25)], 21: [(2.0, 3.0)],
    22: [(1.0, 2.0, 2.0)], 24: [(0.5, 1.5)], 25: [(0.25,)], 26: [(1.0, -1.0, 3.0)], 27: [()], 28: [(1.0, 2.0)],
    29: [(1.0, 0.25)], 33: [()],
}
UNIFORMS = [2.0**-60, 1e-9, 0.3, 0.5, 0.75, 1 - 2.0**-53]

# Other points: row, parameters, uniform.
EXTREMES = [
    (9, (), 1e-12),
    (10, (1.0,), 1e-300),
    (10, (1.0,), 0.9999999999999999),
    (11, (0.1, 5.0, 6.0), 0.5),
    (11, (0.001, -3.0, 3.0), 1e-20),
    (12, (0.0, 1.0), 1e-300),
    (12, (0.0, 1.0), 0.9999999999999999),
    (13, (8.0, 9.0), 0.5),
    (13, (-40.0, -39.0), 0.5),
    (14, (1.0,), 1e-300),
    (14, (1.0,), 0.9999999999999999),
    (20, (0.0, 1.0, 1e-12), 0.7),
    (20, (0.0, 1.0, -0.5), 0.9999999999999999),
    (21, (2.0, 1000000.0), 1e-12),
    (21, (0.5, 0.5), 0.9999999999999999),
    (22, (1.0, 2.0, 1.0000000000009095), 0.3),
    (22, (1e-06, 1000000.0, 3.0), 0.999),
    (24, (0.0, 1.0), 0.9999999999999999),
    (24, (5.0, 2.0), 1e-12),
    (25, (1e-10,), 0.9),
    (25, (0.5,), 0.9999999999999999),
    (26, (1e-06, 1.0, 2.0), 0.5),
    (26, (1e-08, -1.0, 1.0), 0.25),
    (26, (1.0, 1000000.0, 1000001.0), 0.5),
    (28, (1.0, 1e-14), 0.5),
    (28, (0.0, 1.0), 1e-20),
    (29, (1.0, 1e-12), 0.5),
    (33, (), 1e-09),
    (33, (), 0.25),
]


def condition(f, arguments):
    """Sum of |a f'(a) / f| over the arguments."""
    y = f(*arguments)
    total = mpf(0)
    for i, a in enumerate(arguments):
        if a == 0 or y == 0:
            continue
        step = mpf(10) ** -20
        up, down = list(arguments), list(arguments)
        up[i], down[i] = a * (1 + step), a * (1 - step)
        total += abs((f(*up) - f(*down)) / (2 * step) / y)
    return total


def line(row, parameters, u):
    f, p = rows[row]
    a = [mpf(x) for x in parameters]
    x = f(mpf(u), *a)
    if abs(x) < mpf(10) ** -45:
        x = mpf(0)
    rounded = mpf(float(x))
    values = [x, p(x, *a), p(rounded, *a)]
    conditions = [
        condition(f, [mpf(u)] + a),
        condition(p, [x] + a),
        condition(lambda u, *a: p(f(u, *a), *a), [mpf(u)] + a),
    ]
    if any(not isinstance(v, mpf) or not isfinite(v) for v in values) or values[1] < mpf(10) ** -290:
        return None
    numbers = [repr(float(z)) for z in list(parameters) + [u] + values]
    return " ".join([str(row)] + numbers + ["%.1e" % min(max(float(c), 1), 1e300) for c in conditions])


print("# row, parameters, u, x, pdf, pdf at the rounded x, three conditions; by make_algebra.py")
points = EXTREMES + [(row, p, u) for row, ps in PARAMETERS.items() for p in ps for u in UNIFORMS]
for point in sorted(set(points)):
    try:
        text = line(*point)
    except (ZeroDivisionError, ValueError, TypeError):
        continue  # A pole of the density, or no sample at all.
    if text:
        print(text)
