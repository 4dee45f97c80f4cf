"""Fit of a law: the modulus in closed form, shape parameters by Gauss-Newton within bounds.

References
----------
G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413, doi:10.1137/0710036 (variable
projection).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from softsample.laws.candidates import Candidate
from softsample.laws.test import LawTest, Mask

Array = NDArray[np.float64]
Whiten = Callable[[int, Array], Array]

STEP = 1e-5
"""Step of differences, as a part of a parameter's range."""

STARTS = 4
"""Starts along each shape parameter."""

MOST_STARTS = 4
"""Starts that are followed to their end: those that fit best."""

AT_BOUND = 1e-3
"""Part of a range within which a parameter is at its bound."""


@dataclass(frozen=True, eq=False)
class LawFit:
    """A law fitted to tests.

    Parameters
    ----------
    candidate : Candidate
    mu : float
        Shear modulus [Pa], >= 0.
    shape : (n_shape,) float64
    cost : float
        Weighted sum of squares.
    """

    candidate: Candidate
    mu: float
    shape: Array
    cost: float

    def force(self, test: LawTest) -> Array:
        """Force (n,) [N] at the points of a test."""
        return self.mu * test.unit_force(self.candidate, self.shape)

    @property
    def bounds_met(self) -> list[str]:
        """Parameters that are at an end of their range, in words."""
        found = []
        for value, s in zip(self.shape, self.candidate.shape, strict=True):
            margin = AT_BOUND * (s.high - s.low)
            if value - s.low < margin:
                found.append(f"{s.name} at its minimum, {s.low:g}")
            if s.high - value < margin:
                found.append(f"{s.name} at its maximum, {s.high:g}")
        return found


class Problem:
    """Sum of squares of some points of some tests.

    Parameters
    ----------
    tests : sequence of LawTest
    kept : sequence of (n,) bool
        Points of each that count.
    whiten : callable, optional
        White residual of the points that count of the k-th test; by default each test counts by
        its largest force, and its points share its weight.
    """

    def __init__(
        self, tests: Sequence[LawTest], kept: Sequence[Mask], whiten: Whiten | None = None
    ) -> None:
        self.pairs = [(k, t) for k, t in enumerate(tests) if kept[k].any()]
        self.kept, self.tests = kept, tests
        self.whiten = whiten or self._by_peak

    def _by_peak(self, k: int, values: Array) -> Array:
        peak = np.abs(self.tests[k].force[self.kept[k]]).max()
        return values / (peak * np.sqrt(len(values)))

    def stacked(self, values: Callable[[LawTest], Array]) -> Array:
        """White values of all points that count."""
        return np.concatenate([self.whiten(k, values(t)[self.kept[k]]) for k, t in self.pairs])

    def unit(self, candidate: Candidate, shape: Array) -> Array:
        """White forces per modulus."""
        return self.stacked(lambda test: test.unit_force(candidate, shape))

    @property
    def measured(self) -> Array:
        """White forces of the records."""
        return self.stacked(lambda test: test.force)

    def projected(self, candidate: Candidate, shape: Array, y: Array) -> tuple[float, Array]:
        """The modulus >= 0 that fits best [Pa], and the white residual."""
        unit = self.unit(candidate, shape)
        mu = max(0.0, float(unit @ y) / max(float(unit @ unit), 1e-300))
        return mu, y - mu * unit

    def fit(
        self,
        candidate: Candidate,
        starts: Sequence[Array] | None = None,
        held: dict[int, float] | None = None,
    ) -> LawFit:
        """The best of descents from several starts.

        Parameters
        ----------
        candidate : Candidate
        starts : sequence of (n_shape,) float64, optional
            Where to set out from; by default a grid in the ranges.
        held : dict, optional
            Values of shape parameters by index, which are not fitted.
        """
        y, held = self.measured, held or {}
        low, high = candidate.bounds
        free = [k for k in range(len(low)) if k not in held]
        span = high - low

        def whole(x: Array) -> Array:
            shape = np.empty(len(low))
            shape[free] = low[free] + x * span[free]
            for k, value in held.items():
                shape[k] = value
            return shape

        def residual(x: Array) -> Array:
            return self.projected(candidate, whole(x), y)[1]

        found = []
        tried = [(s[free] - low[free]) / span[free] for s in starts or candidate.starts(STARTS)]
        if len(tried) > MOST_STARTS:
            tried.sort(key=lambda x: float(residual(x) @ residual(x)))
            tried = tried[:MOST_STARTS]
        for x in tried if free else [np.empty(0)]:
            if free:
                inner = np.clip(x, 1e-6, 1.0 - 1e-6)
                x = least_squares(
                    residual, inner, bounds=(0.0, 1.0), diff_step=STEP, xtol=1e-7, ftol=1e-9,
                    max_nfev=40,
                ).x  # fmt: skip
            mu, left = self.projected(candidate, whole(x), y)
            found.append(LawFit(candidate, mu, whole(x), float(left @ left)))
        return min(found, key=lambda fit: fit.cost)

    def jacobian(self, fit: LawFit) -> Array:
        """Change of the white forces (n, 1 + n_shape) by ln(mu) and by each whole range."""
        low, high = fit.candidate.bounds
        columns = [fit.mu * self.unit(fit.candidate, fit.shape)]
        for k, span in enumerate(high - low):
            step = 1e-4 * span
            ends = [fit.shape.copy(), fit.shape.copy()]
            ends[0][k], ends[1][k] = (
                max(low[k], fit.shape[k] - step),
                min(high[k], fit.shape[k] + step),
            )
            below, above = (fit.mu * self.unit(fit.candidate, end) for end in ends)
            columns.append((above - below) * span / (ends[1][k] - ends[0][k]))
        return np.stack(columns, axis=1)
