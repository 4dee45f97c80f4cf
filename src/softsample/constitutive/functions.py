"""Functions that the texts of the laws call.

A law is written once: its text runs on NumPy arrays, real or complex, and `softsample.fem.lanes`
teaches the compiler these functions, so that the same text is a part of the solver's kernel.
"""

import numpy as np

TINY = 1e-30
"""Keeps a ratio defined at nothing over nothing; in the range of single precision."""


def exp(x):
    """Exponential; on lanes for results in the range of normal numbers."""
    return np.exp(x)


def expm1(x):
    """exp(x) - 1 with its digits near zero."""
    return np.expm1(x)


def log(x):
    """Natural logarithm of normal x > 0."""
    return np.log(x)


def lesser(x, y):
    """The lesser of x and a real y."""
    return np.where(np.real(x) < y, x, y)


def positive(x):
    """One where x is positive, zero elsewhere."""
    return np.where(np.real(x) > 0.0, 1.0, 0.0)


def growth(x):
    """(exp(x) - 1) / x, which is one at zero."""
    shifted = x + TINY
    return expm1(shifted) / shifted
