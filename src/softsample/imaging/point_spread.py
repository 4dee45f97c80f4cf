"""Point spreads of images: what voxels hold of the inside of a surface.

References
----------
.. [1] Z.-P. Liang, P. C. Lauterbur, Principles of magnetic resonance imaging, IEEE Press 2000,
   doi:10.1109/9780470545652, chapter 8.
"""

from collections.abc import Callable
from functools import partial

import numba
import numpy as np
from scipy.special import sici

from softsample.arrays import Array
from softsample.imaging.voxels import Voxels

LEAST_ACROSS = 0.02
"""Least change of depth along an edge of a voxel or cell, over the largest: that a wall lies along
it makes no kink in what it holds, which steps to the most probable shift would meet."""

VOXEL_MEAN = "voxel_mean"

Share = Callable[[Voxels, Array], tuple[Array, Array]]


def voxel_mean(voxels: Voxels, shift: Array) -> tuple[Array, Array]:
    """What voxels hold (n,) of the inside of a surface, moved outward by `shift` (n,) [m]; slope.

    Here their share of it, as where an image holds the mean over each voxel.
    """
    across = np.abs(voxels.across) / voxels.parts
    across = np.maximum(across, LEAST_ACROSS * across.max(axis=1, keepdims=True))
    return _inside(voxels.depth, across, shift)


def band_limited(voxels: Voxels, shift: Array, slices: int | None = None) -> tuple[Array, Array]:
    """The same where an image holds all waves that its voxels can, and no shorter ones.

    So does that of a scanner, which samples these waves; along the axis of its `slices`, if it
    excites one after the other, it takes means. Through a plane edge waves make a sine integral:
    the shortest is twice as long as the largest change of depth over an edge of the voxel.
    """
    across = np.abs(voxels.across)
    least = LEAST_ACROSS * across.max(axis=1)
    waves = [axis for axis in range(3) if axis != slices]
    apart = np.maximum(across[:, waves].max(axis=1), least)
    thick = least if slices is None else np.maximum(across[:, slices], least)
    ahead = shift - voxels.depth.mean(axis=1)
    ends = [np.pi * (ahead + side * thick) / apart for side in (0.5, -0.5)]
    (high, upper), (low, lower) = ((sici(x)[0], np.cos(x)) for x in ends)
    of_mean = (ends[0] * high + upper - ends[1] * low - lower) * apart / thick
    return 0.5 + of_mean / np.pi**2, (high - low) / (np.pi * thick)


POINT_SPREADS: dict[str, Share] = {
    VOXEL_MEAN: voxel_mean,
    "band_limited": band_limited,
    **{f"slices_{name}": partial(band_limited, slices=k) for k, name in enumerate("ijk")},
}
"""What an image may hold: means over its voxels, the waves that a scanner samples, or these in
slices along one of its axes."""


@numba.njit(cache=True)
def _inside(depth: Array, across: Array, shift: Array) -> tuple[Array, Array]:
    """Mean share (n,) of cells on one side of a plane, and its slope by the plane's shift.

    The depth of a point drawn from a cell is a sum of three even variables of the widths `across`,
    whose distribution is a cubic spline of eight knots.
    """
    share, slope = np.zeros(len(depth)), np.zeros(len(depth))
    for row in range(len(depth)):
        a, b, c = across[row]
        reach = 0.5 * (a + b + c)
        for cell in range(depth.shape[1]):
            ahead = shift[row] - depth[row, cell]
            if ahead >= reach:
                share[row] += 1.0
            elif ahead > -reach:
                inside, density = _of_box(ahead, a, b, c)
                share[row] += inside
                slope[row] += density
    return share / depth.shape[1], slope / depth.shape[1]


@numba.njit(cache=True)
def _of_box(ahead: float, a: float, b: float, c: float) -> tuple[float, float]:
    """Distribution and density of a sum of three even variables of widths a, b, c about zero."""
    share = density = 0.0
    for i in (-0.5, 0.5):
        for j in (-0.5, 0.5):
            for k in (-0.5, 0.5):
                past = ahead + i * a + j * b + k * c
                if past > 0.0:
                    part = 8.0 * i * j * k * past * past
                    density += part / (2.0 * a * b * c)
                    share += part * past / (6.0 * a * b * c)
    return share, density
