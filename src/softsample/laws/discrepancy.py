"""Error of a law's form: how large it is, and what residuals are worth beside it.

A test's residual is white noise, an error that is correlated along the displacement, and an error
of the scale of the whole test. The last two have one size, which restricted maximum likelihood
takes from the residuals: it knows that parameters were fitted to them. On top come what mesh and
element type leave open of a simulated response, in proportion to it and smooth along the
displacement, and what an image leaves open of the point at which contact begins.

References
----------
M. C. Kennedy, A. O'Hagan, J. R. Stat. Soc. B 63 (2001) 425, doi:10.1111/1467-9868.00294 (model
discrepancy).
D. A. Harville, J. Am. Stat. Assoc. 72 (1977) 320, doi:10.2307/2286796 (restricted likelihood).
"""

from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve, cholesky, solve_triangular

from softsample.arrays import Array, Mask
from softsample.laws.fit import LawFit, Problem
from softsample.laws.test import LawTest

LENGTH = 0.25
"""Correlation length of the error along the displacement, as a part of the largest one."""

SIZES = np.geomspace(1e-4, 1.0, 41)
"""Sizes of the error, as parts of the peak force, of which the likeliest is taken."""

JITTER = 1e-4
"""Noise, as a part of the peak, that a record has at least: that of the responses."""


def covariance(test: LawTest, model: Array, kept: Mask, size: float) -> Array:
    """Covariance (n, n) [N2] of the points of a test that count.

    Parameters
    ----------
    model : (n,) float64
        Predicted forces [N] of these points, for the error of scale.
    kept : (n_points,) bool
        Points that count.
    size : float
        Of the error of form and of that of scale, as parts of the peak of these points.
    """
    way, peak = test.displacement[kept], np.abs(test.force[kept]).max()
    apart = np.abs(np.subtract.outer(way, way)) / (LENGTH * test.stroke)
    scale = np.outer(model, model)
    error = size**2 * (peak**2 * np.exp(-apart) + scale)
    error += test.scale_error**2 * scale * np.exp(-0.5 * (LENGTH * apart) ** 2)
    if test.contact_zero and len(way) > 1:
        moved = test.contact_zero * np.gradient(model, way)
        error += np.outer(moved, moved)
    noise = test.noise**2 + (JITTER * peak) ** 2
    return np.asarray(error + noise * np.eye(len(way)))


class Discrepancy:
    """Residual model of a fit.

    Parameters
    ----------
    problem : Problem
        Tests and points that count.
    fit : LawFit
        Of them, by any weights.
    """

    def __init__(self, problem: Problem, fit: LawFit) -> None:
        self.problem, self.fit = problem, fit
        self._residual = {k: (t.force - fit.force(t))[problem.kept[k]] for k, t in problem.pairs}
        self.size = float(SIZES[int(np.argmax([self._likelihood(size) for size in SIZES]))])
        self._factor = {k: cholesky(self._covariance(k, self.size), lower=True)
                        for k, _ in problem.pairs}  # fmt: skip

    def whiten(self, k: int, values: Array) -> Array:
        """White values of the points of the k-th test that count."""
        return np.asarray(solve_triangular(self._factor[k], values, lower=True, check_finite=False))

    @property
    def weighted(self) -> Problem:
        """The problem with the weights of this residual model."""
        return Problem(self.problem.tests, self.problem.kept, self.whiten)

    def _covariance(self, k: int, size: float) -> Array:
        test, kept = self.problem.tests[k], self.problem.kept[k]
        return covariance(test, self.fit.force(test)[kept], kept, size)

    def _likelihood(self, size: float) -> float:
        """Restricted log likelihood of a size."""
        count = self.fit.candidate.size
        total, information = 0.0, np.zeros((count, count))
        for k, jacobian in self._jacobians.items():
            factor = cholesky(self._covariance(k, size), lower=True)
            white = solve_triangular(factor, self._residual[k], lower=True)
            total -= 0.5 * float(white @ white) + float(np.log(np.diag(factor)).sum())
            information = information + jacobian.T @ cho_solve((factor, True), jacobian)
        shown = np.linalg.eigvalsh(information)
        return total - 0.5 * float(np.log(shown[shown > 1e-9 * shown.max()]).sum())

    @cached_property
    def _jacobians(self) -> dict[int, Array]:
        """Changes [N] of the points of each test by the parameters (n, n_parameters)."""
        plain = Problem(self.problem.tests, self.problem.kept, lambda _, values: values)
        counts = [int(self.problem.kept[k].sum()) for k, _ in self.problem.pairs]
        parts = np.split(plain.jacobian(self.fit), np.cumsum(counts)[:-1])
        return dict(zip((k for k, _ in self.problem.pairs), parts, strict=True))
