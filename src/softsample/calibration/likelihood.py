"""Likelihood behind the area between curves, and what it says about each parameter.

The area is the negative log likelihood of errors with Laplace's distribution. With their scale
taken from the record, -2 log L = 2 n ln(area), where n is the number of independent points.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from softsample.arrays import Array
from softsample.calibration.profile import profile, profile_interval
from softsample.calibration.slsqp import Fit, Search

MODULI = ("mu", "mu1", "mu2")
"""What `moduli` returns, by name."""

LEAST_SHARE = 1e-4
"""Part of the modulus below which a term is as good as absent: its logarithm has to be finite."""

SHARES = np.geomspace(1e-3, 1.0, 19)
"""Parts of the modulus at which the profile of a term that may be absent is looked up."""

STEPS = 2.0 ** np.arange(-1, 8)
"""Distances of a profile's points from the optimum, in steps."""


def moduli(mu: float, mu1_fraction: float) -> Array:
    """mu, mu1 and mu2 [Pa] (3,) of a modulus [Pa] and a fraction."""
    return np.array([mu, mu * mu1_fraction, mu * (1.0 - mu1_fraction)])


@dataclass(frozen=True)
class Profile:
    """Profile likelihood of one parameter.

    Parameters
    ----------
    points : (k,) float64
        Values of the parameter, ascending [Pa or dimensionless].
    deviance : (k,) float64
        Least deviance at each, zero at the optimum.
    low, high : float
        Interval; infinite where the profile stays below the level.
    """

    points: Array
    deviance: Array
    low: float
    high: float

    def ends(self) -> dict[str, float | None]:
        """`low` and `high` for a file; None where the interval is open."""
        return {
            name: float(end) if np.isfinite(end) else None
            for name, end in (("low", self.low), ("high", self.high))
        }


class AreaLikelihood:
    """How likely variables of the `Search` of a fit are: their deviance is 2 n ln(A / A_min).

    Parameters
    ----------
    search : Search
        Objective and bounds.
    fit : Fit
        Its optimum.
    points : float
        Number of independent points n.
    """

    def __init__(self, search: Search, fit: Fit, points: float) -> None:
        self.search, self.fit, self.points = search, fit, points
        self.best = search.pack(fit.mu, fit.mu1_fraction)
        self.bounds = list(search.bounds.values())
        self._least = search(self.best)

    def __call__(self, x: Array) -> float:
        """ln(A / A_min) at variables `x`: the deviance over twice the number of points."""
        return float(np.log(self.search(x) / self._least))

    def profile(self, name: str, step: float, confidence: float) -> Profile:
        """Profile of `mu`, `mu1` or `mu2`.

        Parameters
        ----------
        name : str
            The parameter.
        step : float
            First distance from the optimum, a part of its value, doubled a few times.
        confidence : float
            Of the interval; a term whose share may be about `LEAST_SHARE` has no lower end.
        """
        split = name != "mu" and "mu1_fraction" in self.search.bounds
        deviance, best, bounds = self._of_term(name) if split else (self, self.best, self.bounds)
        found = self._profile(deviance, best, bounds, step, confidence)
        ends = (found.low, found.high)
        low, high = (float(np.exp(end)) if np.isfinite(end) else end for end in ends)
        if not (split and low <= 2.0 * LEAST_SHARE * self.fit.mu):
            return Profile(np.exp(found.points), found.deviance, low, high)
        shares = np.concatenate([[np.exp(best[0]) / self.fit.mu], SHARES])
        values = np.unique(np.clip(np.log(self.fit.mu * shares), *bounds[0]))
        depths, _ = profile(deviance, best, 0, values, bounds)
        depths, moduli = 2.0 * self.points * depths, np.exp(values)
        _, high = profile_interval(moduli, depths, float(np.exp(best[0])), confidence)
        return Profile(moduli, depths, -np.inf, high)

    def _of_term(self, name: str) -> tuple[Callable[[Array], float], Array, list]:
        """Deviance, optimum and bounds in ln(mu_i) and ln(mu_i / mu) in place of ln(mu), mu1 / mu.

        Where a term's modulus is held, the sum is what the record knows and the share follows.
        """
        sign, offset = (1.0, 0.0) if name == "mu1" else (-1.0, 1.0)

        def share(fraction: float) -> float:
            return offset + sign * fraction

        def deviance(x: Array) -> float:
            fraction = sign * (np.exp(x[1]) - offset)
            return self(np.array([x[0] - x[1], fraction]))

        logs = [float(np.log(max(share(end), LEAST_SHARE))) for end in self.bounds[1]]
        best = self.best.copy()
        best[1] = np.log(max(share(best[1]), LEAST_SHARE))
        best[0] += best[1]
        term = self.bounds[0][0] + min(logs), self.bounds[0][1] + max(logs)
        return deviance, best, [term, (min(logs), max(logs))]

    def _profile(
        self, deviance: Callable[[Array], float], best: Array, bounds: list, step: float,
        confidence: float,
    ) -> Profile:  # fmt: skip
        """Profile of the first variable."""
        values = best[0] + step * np.concatenate([-STEPS[::-1], [0.0], STEPS])
        values = np.unique(np.clip(values, *bounds[0]))
        depths, _ = profile(deviance, best, 0, values, bounds)
        depths *= 2.0 * self.points
        return Profile(values, depths, *profile_interval(values, depths, best[0], confidence))
