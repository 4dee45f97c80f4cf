"""Where tissue ends below a film of fluid: a model of the scanner, fitted to the voxels.

A film much thinner than a voxel moves the half-maximum outward by its thickness times its
brightness, and sharpens the edge. The sharpening tells film from tissue, but so faintly that one
place alone does not show it. The shift of the boundary, the thickness of the film and the level of
the tissue are therefore fields over the surface, smooth by their priors, and estimated together:
maximum a posteriori by Gauss-Newton steps. The derivation is in ``docs/geometry.md``.

References
----------
.. [1] A. Tarantola, Inverse problem theory, SIAM 2005, doi:10.1137/1.9780898717921, chapter 3.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg
from scipy.special import ndtr

from softsample.arrays import Array
from softsample.imaging.fields import FILM, SHIFT, TYPICAL, Interpolation
from softsample.imaging.film_model import Model, descended
from softsample.imaging.point_spread import POINT_SPREADS
from softsample.imaging.voxels import SEEN, Voxels
from softsample.units import MM

ROUNDS = 15
"""Levenberg-Marquardt steps at most."""

REWEIGHTED = 3
"""Steps after which the voxels are weighted anew."""

STARTS = (0.25, 0.5, 1.0, 2.0)
"""Even films from which the search begins, over the typical one."""

UNEVEN = 0.65 / MM
"""Relative standard deviation of a film's thickness about the one found, per voxel edge [1/m].

Found on phantoms whose films vary by a third within millimetres: small voxels see it, large do not.
"""


@dataclass(frozen=True)
class Fit:
    """Where the boundary is.

    Attributes
    ----------
    places : (m, 3) float64
        On the surface [m].
    shift, sigma : (m,) float64
        Way outward from the given surface to the boundary, and its standard deviation [m].
    film : float
        Mean thickness of the film [m]; zero without one.
    misfit : float
        Robust standard deviation of what it leaves of the voxels, over that of the noise.
    point_spread : str
        One of `POINT_SPREADS`, which suits the image.
    """

    places: Array
    shift: Array
    sigma: Array
    film: float
    misfit: float
    point_spread: str

    def at(self, points: Array) -> tuple[Array, Array]:
        """Shift and its standard deviation (n,) at `points` (n, 3) [m]."""
        near = Interpolation.between(self.places, points)
        return near(self.shift), near(self.sigma)


def fit(voxels: Voxels, brightness: float) -> Fit:
    """Fit the boundary with a film and without one; a film is taken where the odds are for it.

    Both have the point spread that suits a first fit best, by itself or with an even film below:
    between two of them lie thousands in the logarithm of the odds. Both weight the voxels alike, by
    what that fit expects: their probabilities compare.

    Parameters
    ----------
    voxels : Voxels
        Near the surface.
    brightness : float
        Expected brightness of the fluid over that of the tissue.
    """
    wet = Model.over(voxels, brightness)
    dry = wet.without_film()
    state = np.zeros(len(dry.precision))
    for _ in range(REWEIGHTED):
        state = descended(dry, voxels.spread(dry.expected(state)[0]), state, 1)
    spread = voxels.spread(dry.expected(state)[0])
    pairs = ((replace(dry, point_spread=n), replace(wet, point_spread=n)) for n in POINT_SPREADS)
    dry, wet = min(
        pairs,
        key=lambda pair: min(pair[0].cost(spread, state), _best_start(pair[1], spread, state)[0]),
    )
    without = _Peak.near(dry, spread, state)
    with_film = _Peak.near(wet, spread, _best_start(wet, spread, without.state)[1])
    return (with_film if with_film.evidence > without.evidence + SEEN else without).fit(spread)


def _best_start(wet: Model, spread: Array, state: Array) -> tuple[float, Array]:
    """The best of the even `STARTS` below a `state` without film, and its cost before it."""
    starts = [wet.below_a_film(state, TYPICAL * share) for share in STARTS]
    costs = [wet.cost(spread, start) for start in starts]
    best = int(np.argmin(costs))
    return costs[best], starts[best]


@dataclass(frozen=True)
class _Peak:
    """Most probable state of a model, with the evidence by Laplace's approximation.

    Attributes
    ----------
    model : Model
    state : (u,) float64
    factor : (u, u) float64
        Cholesky factor of the inverse covariance.
    evidence : float
        Logarithm of the probability of the image under the model, but for a constant.
    """

    model: Model
    state: Array
    factor: Array
    evidence: float

    @classmethod
    def near(cls, model: Model, spread: Array, start: Array) -> "_Peak":
        """From a state to start from."""
        state = descended(model, spread, start, ROUNDS)
        factor = linalg.cholesky(model.curvature(spread, state)[0], lower=True)
        occam = float(np.sum(np.log(np.diag(factor)))) - sum(model.volumes)
        return cls(model, state, factor, -0.5 * model.cost(spread, state) - occam)

    def fit(self, spread: Array) -> Fit:
        """Fields in metres."""
        shift, _, *film = self.model.values(self.state)
        misfit = self.model.misfit(spread, self.state)
        places, point_spread = self.model.places[0], self.model.point_spread
        covariance = linalg.lapack.dpotri(self.factor, lower=1)[0]
        variance = SHIFT.local**2 * np.diag(covariance)[: len(places)]
        if not film:
            ratio = self.model.brightness
            unseen = ratio * unseen_film(self.model.voxels.thinnest_film(ratio))
            return Fit(places, shift, np.sqrt(variance + unseen**2), 0.0, misfit, point_spread)
        thickness, (ratio, _) = TYPICAL * np.exp(film[0]), self.model.ratio(self.state)
        carried = Interpolation.between(self.model.places[2], places)
        uneven = ratio * UNEVEN * self.model.voxels.edge * carried(thickness)
        sigma = np.sqrt(variance + uneven**2)
        return Fit(places, shift, sigma, float(thickness.mean()), misfit, point_spread)


def unseen_film(thinnest: float) -> float:
    """Root of the mean square thickness [m] of a film that was not seen.

    Before the image is seen there is none, or one of a log-normal thickness, as likely as not. That
    it was not seen leaves those up to the `thinnest` [m].
    """
    sigma = float(np.hypot(FILM.common, 1.0)) * FILM.local
    reach = np.log(thinnest / TYPICAL) / sigma
    square = TYPICAL**2 * np.exp(2.0 * sigma**2) * ndtr(reach - 2.0 * sigma)
    return float(np.sqrt(square / (1.0 + ndtr(reach))))
