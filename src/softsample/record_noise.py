"""Noise of a record: what no line through neighbouring readings explains, no polynomial."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from softsample.arrays import Array, Mask

ORDER = 3
"""Of the differences that tell the noise: second ones count the curvature of sparse readings."""

SCATTER = 1.4
"""Standard error of the log of the noise, times the root of the number of differences: of a median,
whose neighbours overlap (test)."""

SURE = 3.0
"""Standard errors beyond which one noise is another."""


def white_noise(at: Array, force: Array, kept: Mask | None = None) -> tuple[float, int]:
    """Standard deviation of the white noise of a record [N], and how many differences tell it.

    From third divided differences: a parabola leaves none, readings may lie unevenly, and one may
    be missing.

    Parameters
    ----------
    at, force : (n,) float64
        What a curve is smooth over, such as time [s] or displacement [m], and readings [N]; four
        in turn of which two lie at the same place tell nothing.
    kept : (n,) bool, optional
        Readings that count; all by default.
    """
    if len(force) <= ORDER:
        return 0.0, 0
    places, forces = (sliding_window_view(x, ORDER + 1) for x in (at, force))
    apart = places[:, :, None] - places[:, None, :]
    others = ~np.eye(ORDER + 1, dtype=bool)
    told = (apart != 0.0)[:, others].all(axis=1)
    if kept is not None:
        told &= sliding_window_view(kept, ORDER + 1).all(axis=1)
    if not told.any():
        return 0.0, 0
    weights = 1.0 / np.prod(apart[told], axis=2, where=others)
    left = np.sum(weights * forces[told], axis=1) / np.linalg.norm(weights, axis=1)
    noise = 1.4826 * np.median(np.abs(left - np.median(left)))
    return float(noise), len(left)


def last_digit(force: Array) -> float:
    """Step of which all steps between readings are multiples [N]; 0 if there is none."""
    steps = np.abs(np.diff(force))
    steps = steps[steps > 0.0]
    parts = steps / steps.min(initial=np.inf)
    return float(steps.min()) if len(steps) and np.allclose(parts, parts.round(), 0, 1e-2) else 0.0


def beyond_polynomial(time: Array, means: Array, degree: int, correlation_s: float) -> Array:
    """What a polynomial leaves of means (n,) [N2], and what of unit slow and unit white noise.

    Parameters
    ----------
    time, means : (n,) float64
        Of blocks of readings [s], [N].
    degree : int
        Of the polynomial over time.
    correlation_s : float
        Correlation time of the slow noise [s].
    """
    axis = 2.0 * (time - time[0]) / (time[-1] - time[0]) - 1.0
    basis, _ = np.linalg.qr(np.stack([axis**k for k in range(degree + 1)], axis=1))
    left = np.eye(len(time)) - basis @ basis.T
    alike = np.exp(-np.abs(np.subtract.outer(time, time)) / correlation_s)
    return np.array([np.sum((left @ means) ** 2), np.trace(left @ alike), np.trace(left)])
