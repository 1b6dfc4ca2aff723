#!/usr/bin/env python3
"""Prints the polynomial coefficients of core/math/so3.h and core/math/rotation_error.h with their errors.

Needs mpmath (Debian: python3-mpmath). usage: so3_coefficients.py
"""
from mpmath import acos, cos, lu_solve, matrix, mp, mpf, nstr, pi, polyval, sin, sqrt

mp.dps = 60


def interpolate(f, a, b, terms):
    """Monomial coefficients of the interpolant at the Chebyshev points of [a, b], rounded to double."""
    nodes = [(a + b) / 2 + (b - a) / 2 * cos(pi * (2 * k + 1) / (2 * terms)) for k in range(terms)]
    powers = matrix(terms, terms)
    values = matrix(terms, 1)
    for i, x in enumerate(nodes):
        values[i] = f(x)
        for j in range(terms):
            powers[i, j] = x**j
    return [float(c) for c in lu_solve(powers, values)]


def worst_error(coefficients, f, a, b, samples=1000):
    points = [a + (b - a) * mpf(i) / samples for i in range(samples + 1)]
    p = [mpf(c) for c in reversed(coefficients)]
    return max(abs(polyval(p, x) - f(x)) for x in points)


def log_factor(z):
    w = 1 - z
    return mpf(2) if abs(z) < mpf(10)**-25 else 2 * acos(w) / sqrt(1 - w * w)


def curvature(z):
    if abs(z) < mpf(10)**-20:
        return mpf(1) / 12
    w = 1 - z
    alpha = 2 * acos(w)
    return (1 - alpha / 2 * w / sqrt(1 - w * w)) / alpha**2


def sinc(x):
    return sin(sqrt(x)) / sqrt(x) if x > 0 else mpf(1)


for name, f, a, b, terms in (
        ("exp_so3 sinc", sinc, mpf(0), pi**2 / 4, 9),
        ("exp_so3 cosine", lambda x: cos(sqrt(x)), mpf(0), pi**2 / 4, 10),
        ("log_factor", log_factor, mpf(0), mpf("1.06"), 22),
        ("error_curvature", curvature, mpf(0), mpf("0.62"), 6)):
    c = interpolate(f, a, b, terms)
    print(f"{name}: {terms} terms on [{nstr(a, 3)}, {nstr(b, 6)}], worst absolute error {nstr(worst_error(c, f, a, b), 3)}")
    print(",\n".join(f"    {v:.17e}" for v in c))
