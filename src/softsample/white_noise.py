"""White noise of a record, from what no line through neighbouring readings explains."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from softsample.arrays import Array, Mask

SCATTER = 1.4
"""Standard error of the log of the noise, times the root of the number of second differences: of a
median, whose neighbours overlap (test)."""

SURE = 3.0
"""Standard errors beyond which one noise is another."""


def white_noise(at: Array, force: Array, kept: Mask | None = None) -> tuple[float, int]:
    """Standard deviation of the white noise of a record [N], and how many differences tell it.

    From second divided differences: readings may lie unevenly, and one may be missing.

    Parameters
    ----------
    at, force : (n,) float64
        What a curve is smooth over, such as time [s] or displacement [m], and readings [N]; three
        in turn of which two lie at the same place tell nothing.
    kept : (n,) bool, optional
        Readings that count; all by default.
    """
    if len(force) < 3:
        return 0.0, 0
    places, forces = (sliding_window_view(x, 3) for x in (at, force))
    before, after = np.diff(places, axis=1).T
    weights = np.stack([after, -(before + after), before], axis=1)
    told = before * after * (before + after) != 0.0
    if kept is not None:
        told &= sliding_window_view(kept, 3).all(axis=1)
    if not told.any():
        return 0.0, 0
    left = np.sum(weights * forces, axis=1)[told] / np.linalg.norm(weights[told], axis=1)
    noise = 1.4826 * np.median(np.abs(left - np.median(left)))
    return float(noise), len(left)
