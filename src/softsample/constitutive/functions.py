"""Functions that the texts of the laws call.

A law is written once: its text runs on NumPy arrays, real or complex, and `softsample.fem.lanes`
teaches the compiler these functions, so that the same text is a part of the solver's kernel.
"""

from typing import Any

import numpy as np

TINY = 1e-30
"""Keeps a ratio defined at nothing over nothing; in the range of single precision."""


def exp(x: Any) -> Any:
    """Exponential; on lanes for results in the range of normal numbers."""
    return np.exp(x)


def expm1(x: Any) -> Any:
    """exp(x) - 1 with its digits near zero."""
    return np.expm1(x)


def log(x: Any) -> Any:
    """Natural logarithm of normal x > 0."""
    return np.log(x)


def lesser(x: Any, limit: float) -> Any:
    """The lesser of x and a real limit."""
    return np.where(np.real(x) < limit, x, limit)


def positive(x: Any) -> Any:
    """One where x is positive, zero elsewhere."""
    return np.where(np.real(x) > 0.0, 1.0, 0.0)


def growth(x: Any) -> Any:
    """(exp(x) - 1) / x, which is one at zero."""
    x = x + TINY
    return expm1(x) / x
