"""Fields over a surface: what is expected of them, and their values between places."""

from dataclasses import dataclass

import numpy as np
from scipy import linalg
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from softsample.arrays import Array, Ids
from softsample.units import MM

NEIGHBOURS = 8
"""Places that a voxel's values are interpolated from."""

TYPICAL = 0.04 * MM
"""Median of the film's thickness before the image is seen [m]."""


@dataclass(frozen=True)
class Prior:
    """What is expected of a field over the surface before the image is seen.

    Attributes
    ----------
    common : float
        Standard deviation of its mean over the sample, in units of `local`.
    local : float
        Standard deviation about that mean.
    reach : float
        Distance over which it forgets itself [m].
    patch : float
        Distance of the places that carry it [m].
    """

    common: float
    local: float
    reach: float
    patch: float

    def precision(self, places: Array) -> tuple[Array, float]:
        """Inverse covariance (n, n) between `places` (n, 3) [m] in units of `local`, and half the
        logarithm of its determinant.
        """
        factor = linalg.cholesky(
            self.common**2 + np.exp(-cdist(places, places) / self.reach), lower=True
        )
        lower = linalg.lapack.dpotri(factor, lower=1)[0]
        return lower + np.tril(lower, -1).T, -float(np.sum(np.log(np.diag(factor))))


SHIFT = Prior(5.0, 0.04 * MM, 3.0 * MM, 1.1 * MM)
"""Of the boundary outward [m]."""

FILM = Prior(3.0, 0.3, 4.0 * MM, 2.0 * MM)
"""Logarithm of the film's thickness over `TYPICAL`."""

LEVEL = Prior(1.0, 0.05, 3.0 * MM, 2.0 * MM)
"""Of the tissue, relative to that of the segmentation."""


@dataclass(frozen=True)
class Interpolation:
    """Means of the values at the nearest places of the surface.

    Attributes
    ----------
    which, weight : (n, k) int64 and float64
        Of the places taken at each point.
    """

    which: Ids
    weight: Array

    @classmethod
    def between(cls, places: Array, points: Array) -> "Interpolation":
        """From `places` (m, 3) to `points` (n, 3).

        The farthest place taken weighs nothing, so that it does not matter which of two equally
        far ones is taken.
        """
        count = min(NEIGHBOURS, len(places))
        found = cKDTree(places).query(points, k=count)
        away, which = (np.reshape(part, (len(points), count)) for part in found)
        weight = (1.0 - (away / (away[:, -1:] + 1e-12)) ** 2) ** 2 + 1e-9
        return cls(which, weight / weight.sum(axis=1, keepdims=True))

    def __call__(self, values: Array) -> Array:
        """Values (n,) at the points from those (m,) at the places."""
        return np.einsum("ij,ij->i", self.weight, values[self.which])
