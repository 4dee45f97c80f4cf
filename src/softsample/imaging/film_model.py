"""Model of the scanner with a film on the tissue or without one, and its most probable state."""

from dataclasses import dataclass, replace
from typing import Any

import numba
import numpy as np
from scipy import linalg

from softsample.arrays import Array, Ids
from softsample.imaging.fields import FILM, LEVEL, SHIFT, TYPICAL, Interpolation, Prior
from softsample.imaging.point_spread import POINT_SPREADS, VOXEL_MEAN
from softsample.imaging.voxels import Voxels
from softsample.units import MM

CONVERGED = 0.005
"""Gain in minus twice the logarithm of the probability, per unknown, that ends the steps."""

LONGEST_STEP = 3.0
"""Largest change of an unknown in a step, in standard deviations of its prior."""

OUTLIER = 4.0
"""Residuals beyond this many standard deviations lose weight (Huber)."""

BRIGHTNESS_SIGMA = 0.15
"""Standard deviation of the fluid's brightness over the tissue's, before the image is seen."""

MOST_SIGMAS = 2.0
"""Bound of the brightness on either side, in its standard deviations."""


@dataclass(frozen=True)
class Model:
    """Fields over the surface, whitened: one standard deviation of the prior is 1.

    Attributes
    ----------
    voxels : Voxels
    priors, places : tuple of Prior, tuple of (m, 3) float64
        Shift, level and, with a film, the logarithm of its thickness.
    carry : tuple of Interpolation
        From places to voxels.
    precision : (u, u) float64
        Of the prior; with a film, its brightness is the last unknown.
    volumes : tuple of float
        Half the logarithm of the determinant of each field's part of it.
    brightness : float
        Expected.
    point_spread : str
        One of `POINT_SPREADS`.
    """

    voxels: Voxels
    priors: tuple[Prior, ...]
    places: tuple[Array, ...]
    carry: tuple[Interpolation, ...]
    precision: Array
    volumes: tuple[float, ...]
    brightness: float
    point_spread: str = VOXEL_MEAN

    @classmethod
    def over(cls, voxels: Voxels, brightness: float) -> "Model":
        """The model with a film, of voxels that hold means."""
        priors = (SHIFT, LEVEL, FILM)
        places = tuple(_places(voxels, prior.patch) for prior in priors)
        blocks, volumes = zip(*map(Prior.precision, priors, places), strict=True)
        carry = tuple(Interpolation.between(place, voxels.place) for place in places)
        precision = linalg.block_diag(*blocks, np.eye(1))
        return cls(voxels, priors, places, carry, precision, volumes, brightness)

    def without_film(self) -> "Model":
        """The same without film."""
        count = len(self.places[0]) + len(self.places[1])
        names = ("priors", "places", "carry", "volumes")
        fields: dict[str, Any] = {name: getattr(self, name)[:2] for name in names}
        return replace(self, precision=self.precision[:count, :count], **fields)

    @property
    def with_film(self) -> bool:
        """Whether one of the fields is a film."""
        return len(self.priors) == 3

    def below_a_film(self, state: Array, thickness: float) -> Array:
        """State with an even film whose half-maximum is that of a `state` without film."""
        even = np.full(len(self.places[2]), np.log(thickness / TYPICAL) / FILM.local)
        wet = np.concatenate([state, even, np.zeros(1)])
        wet[: len(self.places[0])] -= self.brightness * thickness / SHIFT.local
        return wet

    def values(self, state: Array) -> list[Array]:
        """Fields at their places."""
        parts = np.split(state, np.cumsum([len(place) for place in self.places]))
        return [prior.local * part for prior, part in zip(self.priors, parts, strict=False)]

    def ratio(self, state: Array) -> tuple[float, float]:
        """Brightness of the fluid, and its slope; bounded, or it were a shift by another name."""
        share = np.tanh(state[-1] / MOST_SIGMAS)
        ratio = self.brightness + BRIGHTNESS_SIGMA * MOST_SIGMAS * share
        return float(ratio), float(BRIGHTNESS_SIGMA * (1.0 - share**2))

    def expected(self, state: Array) -> tuple[Array, list[Array]]:
        """Expected intensity (n,) and its slopes by the fields and, with a film, by the state's
        brightness.
        """
        fields = [carry(part) for carry, part in zip(self.carry, self.values(state), strict=False)]
        level = 1.0 + fields[1]
        share = POINT_SPREADS[self.point_spread]
        tissue, at_tissue = share(self.voxels, fields[0])
        if not self.with_film:
            return level * tissue, [level * at_tissue, tissue]
        film, (ratio, at_ratio) = TYPICAL * np.exp(fields[2]), self.ratio(state)
        wet, at_wet = share(self.voxels, fields[0] + film)
        signal = tissue + ratio * (wet - tissue)
        slopes = [
            level * (at_tissue + ratio * (at_wet - at_tissue)),
            signal,
            level * ratio * at_wet * film,
            level * (wet - tissue) * at_ratio,
        ]
        return level * signal, slopes

    def jacobian(self, slopes: list[Array]) -> tuple[Ids, Array]:
        """Unknowns that each voxel depends on, and the derivatives by them, (n, k)."""
        starts = np.cumsum([0, *(len(place) for place in self.places)])
        which = [carry.which + start for carry, start in zip(self.carry, starts, strict=False)]
        slope = [
            carry.weight * (prior.local * part)[:, None]
            for carry, prior, part in zip(self.carry, self.priors, slopes, strict=False)
        ]
        if self.with_film:
            which.append(np.full((len(slopes[3]), 1), starts[-1]))
            slope.append(slopes[3][:, None])
        return np.concatenate(which, axis=1), np.concatenate(slope, axis=1)

    def cost(self, spread: Array, state: Array) -> float:
        """Minus twice the logarithm of the probability of a state, but for a constant."""
        residual, far = self._residuals(spread, self.expected(state)[0])
        misfit = np.sum(residual**2 * (2.0 / far - 1.0 / far**2))
        return float(misfit + state @ self.precision @ state)

    def curvature(self, spread: Array, state: Array) -> tuple[Array, Array]:
        """Half the second derivative (u, u) of the cost, minus half the first (u,).

        The former is Gauss-Newton's; its lower half alone is filled.
        """
        expected, slopes = self.expected(state)
        residual, far = self._residuals(spread, expected)
        slope = 2.0 * expected / spread
        which, jacobian = self.jacobian([slope * part for part in slopes])
        hessian = self.precision.copy()
        descent = -self.precision @ state
        _add_products(which, jacobian, residual, 1.0 / far, hessian, descent)
        return hessian, descent

    def misfit(self, spread: Array, state: Array) -> float:
        """Robust standard deviation of what a state leaves, over the expected one."""
        residual, _ = self._residuals(spread, self.expected(state)[0])
        return float(1.4826 * np.median(np.abs(residual)))

    def _residuals(self, spread: Array, expected: Array) -> tuple[Array, Array]:
        """Residuals in standard deviations, and how far beyond the bound of outliers."""
        residual = (self.voxels.power - expected**2) / spread
        return residual, np.maximum(np.abs(residual) / OUTLIER, 1.0)


@numba.njit(cache=True)
def _add_products(
    which: Ids, jacobian: Array, residual: Array, weight: Array, hessian: Array, descent: Array
) -> None:
    """Add J'WJ (lower half) to `hessian` and J'Wr to `descent`; J has the entries `which`."""
    for row in range(which.shape[0]):
        for a in range(which.shape[1]):
            i, left = which[row, a], weight[row] * jacobian[row, a]
            if left != 0.0:
                descent[i] += left * residual[row]
                for b in range(which.shape[1]):
                    j = which[row, b]
                    if j <= i:
                        hessian[i, j] += left * jacobian[row, b]


def descended(model: Model, spread: Array, state: Array, rounds: int) -> Array:
    """Most probable state, by damped Gauss-Newton steps (Levenberg-Marquardt)."""
    cost, damping = model.cost(spread, state), 0.0
    for _ in range(rounds):
        hessian, descent = model.curvature(spread, state)
        diagonal, gain = np.diag(hessian).copy(), -1.0
        while gain <= 0.0 and damping < 10.0:
            np.fill_diagonal(hessian, (1.0 + damping) * diagonal)
            step = linalg.cho_solve(linalg.cho_factor(hessian, lower=True), descent)
            step /= max(1.0, float(np.abs(step).max()) / LONGEST_STEP)
            gain = cost - model.cost(spread, state + step)
            damping = 0.3 * damping if gain > 0.0 else max(10.0 * damping, 0.1)
        if gain > 0.0:
            state, cost = state + step, cost - gain
        if gain < CONVERGED * len(state):
            break
    return state


def _places(voxels: Voxels, patch: float) -> Array:
    """Places (m, 3) about `patch` apart on the surface: means of what lies in each cube."""
    near = np.abs(voxels.depth.mean(axis=1)) < max(0.3 * MM, 0.75 * voxels.edge)
    points = voxels.place[near]
    _, cube = np.unique(np.floor(points / patch), axis=0, return_inverse=True)
    count = np.bincount(cube.ravel())
    return np.stack([np.bincount(cube.ravel(), points[:, k]) / count for k in range(3)], axis=1)
