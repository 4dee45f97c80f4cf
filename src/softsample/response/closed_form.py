"""Homogeneous tests of Ogden's solids and of the foam, fast enough to be asked by a fit.

The tests are those of `softsample.constitutive.homogeneous`, of any law, which takes tens of
milliseconds a curve; here derivatives are written out, and a foam needs no iteration.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from softsample.constitutive.homogeneous import FREE
from softsample.constitutive.material import compressibility
from softsample.protocol import PRESSED_MODES, travel_sign
from softsample.shapes import IdealShape

Array = NDArray[np.float64]
Terms = tuple[tuple[float, float], ...]

SMALL = 1e-6
"""Exponents nearer to zero than this are taken to be it: what that changes is as small."""

CLOSE, ITERATIONS = 1e-11, 100
"""Change of a logarithmic stretch that ends Newton's iteration, and how many at most."""

KEPT = 64
"""Curves that are kept: a fit asks for the same ones again and again."""


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """Force of an ideal shape that deforms uniformly, per shear modulus.

    Parameters
    ----------
    shape : IdealShape
        Cuboid or cylinder.
    mode : str
        One of `softsample.protocol.DIRECTIONS`.
    displacement : (n,) float64
        Displacements of the platen along its direction [m], from zero.
    normal : bool
        Whether the force is that along +z, across a shear, in place of that along the travel.
    poisson_ratio : float
        Of Ogden's solids.
    """

    shape: IdealShape
    mode: str
    displacement: Array
    normal: bool
    poisson_ratio: float

    def ogden(self, terms: Terms) -> Array:
        """Force (n,) per shear modulus [m2] of a sum of Ogden's terms.

        Parameters
        ----------
        terms : tuple of (float, float)
            Part of the shear modulus, which sum to one, and exponent of each.
        """
        return self._ogden(terms)

    def foam(self, alpha: float, nu: float) -> Array:
        """Force (n,) per shear modulus [m2] of the foam of Ogden and Storakers.

        Parameters
        ----------
        alpha, nu : float
            Exponent, and Poisson's ratio from 0 to below 0.5.
        """
        coupling, a = nu / (1.0 - 2.0 * nu), _exponent(alpha)
        own = self._given.sum(axis=0)
        free = -coupling * own / (1.0 + coupling * self._free.sum())
        stretch = self._given + np.multiply.outer(self._free, free)
        push = np.expm1(-a * coupling * stretch.sum(axis=0))
        return self._force(stretch, 2.0 / a * (np.expm1(a * stretch) - push))

    @cached_property
    def _free(self) -> Array:
        """One for the directions (3,) that nothing holds."""
        return np.array(FREE[self.mode])

    @cached_property
    def _given(self) -> Array:
        """Logarithmic principal stretches (3, n) that the travel sets."""
        strain = self.displacement / self.shape.height
        none = np.zeros_like(strain)
        if self.mode == "shear":
            stretch = np.arcsinh(0.5 * strain)
            return np.stack([stretch, none, -stretch])
        sign = -1.0 if self.mode in PRESSED_MODES else 1.0
        return np.stack([none, none, np.log1p(sign * strain)])

    @cached_property
    def _ogden(self) -> Callable[[Terms], Array]:
        return lru_cache(KEPT)(self._solved)

    def _solved(self, terms: Terms) -> Array:
        free = self._free_stretch(terms) if self._free.any() else np.zeros(len(self.displacement))
        stretch = self._given + np.multiply.outer(self._free, free)
        return self._force(stretch, self._kirchhoff(stretch, terms))

    def _force(self, stretch: Array, kirchhoff: Array) -> Array:
        """Force (n,) [m2] from logarithmic stretches and Kirchhoff stresses per modulus (3, n)."""
        first, _, third = kirchhoff
        if self.mode == "shear":
            if self.normal:
                square = np.exp(2.0 * stretch[0])
                return np.asarray(self.shape.area * (first + square * third) / (1.0 + square))
            return np.asarray(self.shape.area * (first - third) / (2.0 * np.cosh(stretch[0])))
        sign = 1.0 if self.normal else travel_sign(self.mode)
        return np.asarray(sign * self.shape.area * third * np.exp(-stretch[2]))

    def _kirchhoff(self, stretch: Array, terms: Terms) -> Array:
        """Principal Kirchhoff stresses (3, n) per modulus."""
        volume = stretch.sum(axis=0)
        isochoric = stretch - volume / 3.0
        total = np.expm1(volume) * np.exp(volume) / compressibility(self.poisson_ratio)
        for part, alpha in terms:
            a = _exponent(alpha)
            power = np.expm1(a * isochoric)
            total = total + part * 2.0 / a * (power - power.mean(axis=0))
        return np.asarray(total)

    def _traction(self, y: Array, terms: Terms) -> tuple[Array, Array]:
        """Kirchhoff stress (n,) along y, and its slope by the free stretch `y`."""
        directions = self._free
        stretch = self._given + np.multiply.outer(directions, y)
        volume, count = stretch.sum(axis=0), directions.sum()
        isochoric, jacobian = stretch - volume / 3.0, np.exp(volume)
        bulk = 1.0 / compressibility(self.poisson_ratio)
        value = bulk * np.expm1(volume) * jacobian
        slope = bulk * count * jacobian * (2.0 * jacobian - 1.0)
        follows = (directions - count / 3.0)[:, None]
        for part, alpha in terms:
            a = _exponent(alpha)
            power = np.exp(a * isochoric)
            change = power * follows
            value = value + part * 2.0 / a * (power[1] - power.mean(axis=0))
            slope = slope + part * 2.0 * (change[1] - change.mean(axis=0))
        return value, slope

    def _free_stretch(self, terms: Terms) -> Array:
        """Logarithmic stretch (n,) that leaves the free directions without traction.

        Newton's iteration from J = 1 within an interval, as
        `softsample.constitutive.homogeneous` chooses it.
        """
        own, count = self._given.sum(axis=0), self._free.sum()
        high = np.abs(self._given).max(axis=0)
        halved = np.clip((np.log(0.5) - own) / count, -high, high)
        low = np.where(self._traction(halved, terms)[0] < 0.0, halved, -high)
        y = -own / count
        for _ in range(ITERATIONS):
            value, slope = self._traction(y, terms)
            low, high = np.where(value < 0.0, y, low), np.where(value < 0.0, high, y)
            with np.errstate(divide="ignore", invalid="ignore"):
                newton = y - value / slope
            inside = (newton >= low) & (newton <= high)
            before, y = y, np.where(inside, newton, 0.5 * (low + high))
            if np.abs(y - before).max() < CLOSE:
                break
        return np.asarray(y)


def _exponent(alpha: float | Array) -> Array:
    return np.where(np.abs(alpha) > SMALL, alpha, SMALL)


def two_terms(fraction: float, alpha: Sequence[float]) -> Terms:
    """Terms of a modulus fraction mu1 / mu and two exponents; one without modulus is left out."""
    parts = zip((fraction, 1.0 - fraction), alpha, strict=True)
    return tuple((float(part), float(a)) for part, a in parts if part > 0.0)
