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

from dataclasses import dataclass

import numpy as np
from scipy import linalg
from scipy.special import ndtr

from softsample.arrays import Array
from softsample.imaging.fields import FILM, SHIFT, TYPICAL, Interpolation
from softsample.imaging.film_model import Model, descended
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
    """

    places: Array
    shift: Array
    sigma: Array
    film: float
    misfit: float

    def at(self, points: Array) -> tuple[Array, Array]:
        """Shift and its standard deviation (n,) at `points` (n, 3) [m]."""
        near = Interpolation.between(self.places, points)
        return near(self.shift), near(self.sigma)


def fit(voxels: Voxels, brightness: float) -> Fit:
    """Fit the boundary with a film and without one; a film is taken where the odds are for it.

    Both weight the voxels alike, by what the fit without film expects: their probabilities compare.

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
    for rounds in (*[1] * REWEIGHTED, ROUNDS):
        spread = voxels.spread(dry.expected(state)[0])
        state = descended(dry, spread, state, rounds)
    without = _Peak.at(dry, spread, state)
    starts = (wet.below_a_film(state, TYPICAL * share) for share in STARTS)
    start = min(starts, key=lambda start: wet.cost(spread, start))
    with_film = _Peak.at(wet, spread, descended(wet, spread, start, ROUNDS))
    return (with_film if with_film.evidence > without.evidence + SEEN else without).fit(spread)


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
    def at(cls, model: Model, spread: Array, state: Array) -> "_Peak":
        factor = linalg.cholesky(model.curvature(spread, state)[0], lower=True)
        occam = float(np.sum(np.log(np.diag(factor)))) - sum(model.volumes)
        return cls(model, state, factor, -0.5 * model.cost(spread, state) - occam)

    def fit(self, spread: Array) -> Fit:
        """Fields in metres."""
        shift, _, *film = self.model.values(self.state)
        misfit = self.model.misfit(spread, self.state)
        places = self.model.places[0]
        covariance = linalg.lapack.dpotri(self.factor, lower=1)[0]
        variance = SHIFT.local**2 * np.diag(covariance)[: len(places)]
        if not film:
            ratio = self.model.brightness
            unseen = ratio * unseen_film(self.model.voxels.thinnest_film(ratio))
            return Fit(places, shift, np.sqrt(variance + unseen**2), 0.0, misfit)
        thickness, (ratio, _) = TYPICAL * np.exp(film[0]), self.model.ratio(self.state)
        carried = Interpolation.between(self.model.places[2], places)
        uneven = ratio * UNEVEN * self.model.voxels.edge * carried(thickness)
        sigma = np.sqrt(variance + uneven**2)
        return Fit(places, shift, sigma, float(thickness.mean()), misfit)


def unseen_film(thinnest: float) -> float:
    """Root of the mean square thickness [m] of a film that was not seen.

    Before the image is seen there is none, or one of a log-normal thickness, as likely as not. That
    it was not seen leaves those up to the `thinnest` [m].
    """
    sigma = float(np.hypot(FILM.common, 1.0)) * FILM.local
    reach = np.log(thinnest / TYPICAL) / sigma
    square = TYPICAL**2 * np.exp(2.0 * sigma**2) * ndtr(reach - 2.0 * sigma)
    return float(np.sqrt(square / (1.0 + ndtr(reach))))
