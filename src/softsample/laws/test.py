"""One loading as a law is fitted to it: few points, and the response that predicts them."""

from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from softsample.laws.candidates import Candidate

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

POINTS = 40
"""Points of a loading at most: a law is smooth, and what is rough is noise."""


class Response(Protocol):
    """Response of one piece in one test."""

    def unit_force(self, candidate: Candidate, shape: Array, displacement: Array) -> Array:
        """Force per shear modulus (n,) [m2] at displacements (n,) [m], both along the loading."""


@dataclass(frozen=True, eq=False)
class LawTest:
    """A loading of one sample.

    Parameters
    ----------
    sample, mode, specimen : str
        Of the row of the study.
    displacement, force : (n,) float64
        Along the loading [m, N].
    noise : float
        Standard deviation of a point [N].
    response : Response
        What predicts it.
    """

    sample: str
    mode: str
    specimen: str
    displacement: Array
    force: Array
    noise: float
    response: Response

    @classmethod
    def of(
        cls,
        row: dict[str, str],
        displacement: Array,
        force: Array,
        response: Response,
    ) -> Self:
        """From the points of a loading, of which means are taken over equal displacements."""
        x, y, count = reduced(displacement, force)
        names = (row["sample"], row["mode"], row["specimen"])
        return cls(*names, x, y, white_noise(force) / np.sqrt(count), response)

    @property
    def peak(self) -> float:
        """Largest force [N]."""
        return float(np.abs(self.force).max())

    @property
    def stroke(self) -> float:
        """Largest displacement [m]."""
        return float(self.displacement.max())

    def unit_force(self, candidate: Candidate, shape: Array) -> Array:
        """Force per shear modulus (n,) [m2] at the points."""
        return self.response.unit_force(candidate, shape, self.displacement)


def reduced(displacement: Array, force: Array, points: int = POINTS) -> tuple[Array, Array, float]:
    """Means of displacement and force over `points` equal parts, and the points in a mean."""
    if len(force) <= points:
        order = np.argsort(displacement, kind="stable")
        return displacement[order], force[order], 1.0
    edges = np.linspace(displacement.min(), displacement.max(), points + 1)
    part = np.clip(np.searchsorted(edges, displacement, side="right") - 1, 0, points - 1)
    count = np.bincount(part, minlength=points)
    there = count > 0
    means = [
        np.bincount(part, values, points)[there] / count[there] for values in (displacement, force)
    ]
    return means[0], means[1], float(np.median(count[there]))


def white_noise(force: Array) -> float:
    """Standard deviation of white noise (0 where there is none) from second differences [N]."""
    second = np.diff(force, 2)
    return 1.4826 * float(np.median(np.abs(second))) / np.sqrt(6.0) if len(second) else 0.0
