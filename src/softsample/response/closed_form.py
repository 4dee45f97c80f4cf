"""Homogeneous tests and torsion of Ogden's solids and of the foam, fast enough for a fit.

The tests are those of `softsample.constitutive.homogeneous`, of any law, which takes tens of
milliseconds a curve; here derivatives are written out, and a foam needs no iteration. In torsion
of a cylinder each radius is in simple shear (R. S. Rivlin, Philos. Trans. R. Soc. Lond. A 242
(1949) 173, doi:10.1098/rsta.1949.0009), and the radial stress balances that around the axis.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numba import njit

from softsample.arrays import Array
from softsample.constitutive.homogeneous import CLOSE, FREE
from softsample.constitutive.material import compressibility
from softsample.protocol import PRESSED_MODES, SHEARED_MODES, travel_sign

Terms = tuple[tuple[float, float], ...]

SMALL = 1e-6
"""Exponents nearer to zero than this are taken to be it: what that changes is as small."""

ITERATIONS = 100
"""Newton's iterations at most."""

RADII = 8
"""Radii of a twisted cylinder over which stresses are integrated."""

KEPT = 256
"""States that are kept: a fit asks for the same ones again and again, and so do tests alike."""


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """Force of an ideal shape that deforms uniformly, per shear modulus.

    Parameters
    ----------
    area : float
        First area of a section [m2].
    mode : str
        One of `softsample.protocol.DIRECTIONS` but indentation.
    strain : (n,) float64
        Displacements of the platen along its direction over the height, from zero.
    normal : bool
        Whether the force is that along +z, across a shear or in torsion, in place of that along
        the travel.
    poisson_ratio : float
        Of Ogden's solids.
    """

    area: float
    mode: str
    strain: Array
    normal: bool
    poisson_ratio: float

    def ogden(self, terms: Terms) -> Array:
        """Force (n,) per shear modulus [m2] of a sum of Ogden's terms.

        Parameters
        ----------
        terms : tuple of (float, float)
            Part of the shear modulus, which sum to one, and exponent of each.
        """
        strain = self.strain.tobytes()
        return self._force(*_ogden(self.mode, self.poisson_ratio, strain, terms))

    def foam(self, alpha: float, nu: float) -> Array:
        """Force (n,) per shear modulus [m2] of the foam of Ogden and Storakers.

        Parameters
        ----------
        alpha, nu : float
            Exponent, and Poisson's ratio from 0 to below 0.5.
        """
        coupling, a = nu / (1.0 - 2.0 * nu), _exponent(alpha)
        given, free = _given(self.mode, self.strain), _free(self.mode)
        own = -coupling * given.sum(axis=0) / (1.0 + coupling * free.sum())
        stretch = given + np.multiply.outer(free, own)
        push = np.expm1(-a * coupling * stretch.sum(axis=0))
        return self._force(stretch, 2.0 / a * (np.expm1(a * stretch) - push))

    def _force(self, stretch: Array, kirchhoff: Array) -> Array:
        """Force (n,) [m2] from logarithmic stretches and Kirchhoff stresses per modulus (3, n)."""
        first, _, third = kirchhoff
        if self.mode in SHEARED_MODES:
            square = np.exp(2.0 * stretch[0])
            along = (first - third) / (2.0 * np.cosh(stretch[0]))
            up, around = first + square * third, square * first + third
            if self.mode == "shear":
                return np.asarray(self.area * (up / (1.0 + square) if self.normal else along))
            if self.normal:
                return self.area * self._over_radii((2.0 * up - around) / (1.0 + square), 2)
            return 2.0 * self.area * self._over_radii(along, 1)
        sign = 1.0 if self.normal else travel_sign(self.mode)
        return np.asarray(sign * self.area * third * np.exp(-stretch[2]))

    def _over_radii(self, stress: Array, order: int) -> Array:
        """Integral (n,) over radii from 0 to 1 of stress times radius to the power 3 - order.

        The shear strain is that of each entry times the radius; stress begins as its power `order`.
        """
        node, weight = np.polynomial.legendre.leggauss(RADII)
        radius, strain = 0.5 * (node + 1.0), self.strain
        begins = stress[1:] / strain[1:] ** order
        inside = np.interp(np.multiply.outer(strain, radius), strain[1:], begins)
        return np.asarray(strain**order * (inside @ (0.5 * weight * radius**3)))


def _given(mode: str, strain: Array) -> Array:
    """Logarithmic principal stretches (3, n) that the travel sets."""
    none = np.zeros_like(strain)
    if mode in SHEARED_MODES:
        stretch = np.arcsinh(0.5 * strain)
        return np.stack([stretch, none, -stretch])
    sign = -1.0 if mode in PRESSED_MODES else 1.0
    return np.stack([none, none, np.log1p(sign * strain)])


def _free(mode: str) -> Array:
    """One for the directions (3,) of the stretches that nothing sets."""
    return np.array(FREE["shear" if mode in SHEARED_MODES else mode])


@lru_cache(KEPT)
def _ogden(mode: str, poisson_ratio: float, strain: bytes, terms: Terms) -> tuple[Array, Array]:
    """Logarithmic principal stretches and Kirchhoff stresses per modulus (3, n) at strains."""
    given, free = _given(mode, np.frombuffer(strain)), _free(mode)
    bulk = 1.0 / compressibility(poisson_ratio)
    parts, exponents = (np.array(values) for values in zip(*terms, strict=True))
    exponents = _exponent(exponents)
    stretch = given
    if free.any():
        stretch = given + np.multiply.outer(
            free, _free_stretch(given, free, bulk, parts, exponents)
        )
    return stretch, _kirchhoff(stretch, bulk, parts, exponents)


def _kirchhoff(stretch: Array, bulk: float, parts: Array, exponents: Array) -> Array:
    """Principal Kirchhoff stresses (3, n) per modulus."""
    volume = stretch.sum(axis=0)
    isochoric = stretch - volume / 3.0
    total = bulk * np.expm1(volume) * np.exp(volume)
    for part, a in zip(parts, exponents, strict=True):
        power = np.expm1(a * isochoric)
        total = total + part * 2.0 / a * (power - power.mean(axis=0))
    return np.asarray(total)


@njit(cache=True)
def _free_stretch(given: Array, free: Array, bulk: float, parts: Array, exponents: Array) -> Array:
    """Logarithmic stretch (n,) that leaves the free directions without traction.

    Newton's iteration from J = 1 within an interval, as
    `softsample.constitutive.homogeneous` chooses it.
    """
    count = free.sum()
    found = np.empty(given.shape[1])
    for k in range(given.shape[1]):
        own = given[:, k].sum()
        high = np.abs(given[:, k]).max()
        low = -high
        halved = min(max((np.log(0.5) - own) / count, low), high)
        if _traction(halved, given[:, k], free, bulk, parts, exponents)[0] < 0.0:
            low = halved
        y = -own / count
        for _ in range(ITERATIONS):
            value, slope = _traction(y, given[:, k], free, bulk, parts, exponents)
            if value < 0.0:
                low = y
            else:
                high = y
            newton = y - value / slope if slope != 0.0 else np.inf
            before = y
            y = newton if low <= newton <= high else 0.5 * (low + high)
            if abs(y - before) < CLOSE:
                break
        found[k] = y
    return found


@njit(cache=True)
def _traction(
    y: float, given: Array, free: Array, bulk: float, parts: Array, exponents: Array
) -> tuple[float, float]:
    """Kirchhoff stress along y of stretches (3,), and its slope by the free stretch `y`."""
    stretch = given + free * y
    volume, count = stretch.sum(), free.sum()
    isochoric, jacobian = stretch - volume / 3.0, np.exp(volume)
    value = bulk * np.expm1(volume) * jacobian
    slope = bulk * count * jacobian * (2.0 * jacobian - 1.0)
    for part, a in zip(parts, exponents):  # noqa: B905 - numba knows no strict
        power = np.exp(a * isochoric)
        change = power * (free - count / 3.0)
        value += part * 2.0 / a * (power[1] - power.mean())
        slope += part * 2.0 * (change[1] - change.mean())
    return value, slope


def _exponent(alpha: float | Array) -> Array:
    return np.where(np.abs(alpha) > SMALL, alpha, SMALL)


def two_terms(fraction: float, alpha: Sequence[float]) -> Terms:
    """Terms of a modulus fraction mu1 / mu and two exponents; one without modulus is left out."""
    parts = zip((fraction, 1.0 - fraction), alpha, strict=True)
    return tuple((float(part), float(a)) for part, a in parts if part > 0.0)
