"""Unit-modulus response curves of one sample as a smooth function of mu1 / mu and displacement."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, Self

import numpy as np
import pandas as pd
from scipy.interpolate import PchipInterpolator

from softsample.arrays import Array
from softsample.errors import CalibrationError
from softsample.protocol import PRESSED_MODES, SHEARED_MODES, travel_sign
from softsample.response.memory import remembered

SMOOTH = 12
"""Degree of polynomials that follow all of a curve but its roughness."""

FINER = 8
"""Points for each one of a simulated curve: chords of a stiffening curve would show."""

ONWARDS = 4
"""Degree of the polynomials along which curves go on beyond their ends. A tenth of the travel
further, they are within 0.3 % of what runs of blocks find; a pull goes over into a push."""

FOLLOWED = 0.2
"""Part of the travel for which they are followed, straight lines beyond."""

CHANNELS = {"force": "force_per_mu_mm2", "force_normal": "normal_force_per_mu_mm2"}
"""Forces of a test, and the columns of their curves."""


def refined(displacement: Array, curve: Array, times: int) -> Array:
    """Curve (n,) on a grid `times` as fine, ((n - 1) times + 1,), by a shape-preserving spline."""
    steps = np.arange(len(curve))
    fine = np.linspace(0.0, steps[-1], times * steps[-1] + 1)
    if curve is displacement:
        return np.interp(fine, steps, displacement)
    where = np.interp(fine, steps, displacement)
    return np.asarray(PchipInterpolator(displacement, curve)(where))


class ResponseCurves:
    """Force per modulus of one sample and geometry, interpolated between computed fractions.

    Parameters
    ----------
    fractions : (k,) float64
        Computed values of the modulus fraction mu1 / mu; a single one serves all fractions.
    displacement : (n,) float64
        Platen displacement along its direction [m], from zero, ascending.
    force_per_mu : (k, n) float64
        Force along the displacement per shear modulus [m2].
    before : str
        What the curves are at negative displacements: `none` (no contact), `smooth` (they go on
        as they begin), `odd` or `even` (mirrored).

    Raises
    ------
    CalibrationError
        If the curves are not finite or do not belong together.
    """

    def __init__(
        self, fractions: Array, displacement: Array, force_per_mu: Array, before: str = "smooth"
    ) -> None:
        if force_per_mu.shape != (len(fractions), len(displacement)):
            raise CalibrationError(
                f"{force_per_mu.shape} forces for {len(fractions)} modulus fractions at "
                f"{len(displacement)} displacements; simulate the sample again"
            )
        if not np.all(np.isfinite(force_per_mu)):
            raise CalibrationError("a simulated force is not finite; simulate the sample again")
        self.fractions, self.displacement, self.before = fractions, displacement, before
        self.bounds = float(fractions.min()), float(fractions.max())
        self._nodes = np.sqrt(1.0 - fractions)  # in which the force is smooth
        apart = np.subtract.outer(self._nodes, self._nodes) + np.eye(len(fractions))
        self._weights = 1.0 / np.prod(apart, axis=1)
        self._forces = force_per_mu
        self._last: tuple[float, Array] = (np.nan, force_per_mu[0])

    @classmethod
    def of_table(cls, table: pd.DataFrame, mode: str, channel: str = "force") -> Self:
        """Curves of a file, `mu1_fraction`, `displacement_mm`, ..., in one of `CHANNELS`.

        A rough top meets the platen node by node: that roughness is taken out where a platen
        presses.
        """
        forces = table.pivot_table(
            CHANNELS[channel], index="mu1_fraction", columns="displacement_mm", observed=True
        ).sort_index(axis=1, key=np.abs)
        sign = travel_sign(mode) if channel == "force" else 1.0
        found = cls(
            forces.index.to_numpy(),
            np.asarray(1e-3 * abs(forces.columns.to_numpy()), dtype=np.float64),
            np.asarray(1e-6 * sign * forces.to_numpy(), dtype=np.float64),
            before_zero(mode, channel),
        )
        return found.smoothed() if mode in PRESSED_MODES else found

    def like(self, forces: Array) -> Self:
        """Other forces (k, n) at the same fractions and displacements."""
        return type(self)(self.fractions, self.displacement, forces, self.before)

    @property
    def grain(self) -> Array:
        """Discretisation noise of each point of a curve (k,) [m2], from fourth differences.

        Their variance is 70 times its.
        """
        if len(self.displacement) < 5:
            return np.zeros(len(self._forces))
        return np.sqrt(np.mean(np.diff(self._forces, 4, axis=1) ** 2, axis=1) / 70.0)

    def smoothed(self) -> Self:
        """The same curves without their roughness: polynomials of degree `SMOOTH`, from zero on."""
        points = len(self.displacement)
        if points < 2 * SMOOTH:
            return self
        place = np.linspace(-1.0, 1.0, points)
        basis = np.polynomial.chebyshev.chebvander(place, SMOOTH)
        basis, _ = np.linalg.qr((basis - basis[0])[:, 1:])  # no force at no displacement
        return self.like(self._forces @ basis @ basis.T)

    def minus(self, other: Self) -> Self:
        """What its forces have more than those of another sample, at the fractions of that one."""
        curves = [
            self.force_per_mu(r, other.displacement) - other.curve(r) for r in other.fractions
        ]
        return other.like(np.stack(curves))

    def curve(self, fraction: float) -> Array:
        """Force per modulus (n,) [m2] at the computed displacements: Lagrange's polynomial."""
        return np.asarray(self._shares(fraction) @ self._forces)

    @remembered
    def force_per_mu(self, fraction: float, displacement: Array) -> Array:
        """Force per modulus [m2] at platen displacements [m] for a modulus fraction.

        Beyond the computed range it goes on along a polynomial through the half next to its end.
        """
        grid, curve = self._grid, self._fine_curve(fraction)
        forward = np.abs(displacement) if self.before in ("odd", "even") else displacement
        force = np.interp(forward, grid, curve)
        if (beyond := forward > grid[-1]).any():
            force[beyond] += self._onwards(-1, curve, forward[beyond] - grid[-1])
        if self.before == "odd":
            force = force * np.sign(displacement)
        if self.before == "smooth" and (before := displacement < 0.0).any():
            force[before] += self._onwards(0, curve, displacement[before])
        return np.asarray(force)

    def force(self, displacement: Array, /, mu: float, fraction: float) -> Array:
        """Force along the displacement [N] for a modulus `mu` [Pa] and a modulus fraction."""
        return mu * self.force_per_mu(fraction, displacement)

    def _shares(self, fraction: float) -> Array:
        """Weights (k,) of the computed curves; a single one is the same for all fractions."""
        away = np.sqrt(1.0 - fraction) - self._nodes
        if len(away) == 1 or not away.all():
            return np.eye(len(away))[int(np.argmin(np.abs(away)))]
        return np.asarray(np.prod(away) / away * self._weights)

    def _fine_curve(self, fraction: float) -> Array:
        known, curve = self._last  # fits ask for the same fraction again and again
        if fraction != known:
            curve = self._shares(fraction) @ self._fine
            self._last = fraction, curve
        return curve

    @cached_property
    def _grid(self) -> Array:
        return refined(self.displacement, self.displacement, FINER)

    @cached_property
    def _fine(self) -> Array:
        return np.stack([refined(self.displacement, curve, FINER) for curve in self._forces])

    def _onwards(self, end: int, curve: Array, beyond: Array) -> Array:
        """What a fine curve changes by beyond one of its ends, 0 or -1."""
        coefficients = self._polynomials[end] @ (curve - curve[end])
        near = np.clip(beyond, -FOLLOWED * self._grid[-1], FOLLOWED * self._grid[-1])
        value, slope = np.zeros_like(near), np.zeros_like(near)
        for coefficient in (*coefficients[::-1], 0.0):  # Horner's scheme, with the slope
            slope = slope * near + value
            value = value * near + coefficient
        return np.asarray(value + slope * (beyond - near))

    @cached_property
    def _polynomials(self) -> tuple[Array, Array]:
        """Coefficients (`ONWARDS`, n) of the polynomials at both ends, per point of a curve."""
        first, last = (_through_half(self._grid - self._grid[end]) for end in (0, -1))
        return first, last


def _through_half(from_end: Array) -> Array:
    """Coefficients (`ONWARDS`, n) of a polynomial through the half of a curve next to its end."""
    longest = np.ptp(from_end)
    powers = np.arange(1, ONWARDS + 1)
    near = np.where(np.abs(from_end) <= 0.5 * longest, from_end, 0.0)
    found = np.linalg.pinv((near[:, None] / longest) ** powers)
    return np.asarray(found / longest ** powers[:, None])


def before_zero(mode: str, channel: str = "force") -> str:
    """What a response is at negative displacements.

    A platen that only presses has left the sample. Shear to the other side is the mirror image,
    exactly for a sample that is symmetric about the plane across the shear.
    """
    if mode in SHEARED_MODES:
        return "odd" if channel == "force" else "even"
    return "none" if mode in PRESSED_MODES else "smooth"


class Curves(Protocol):
    """Modelled curves of one sample and geometry, whatever they come from."""

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and largest modulus fraction mu1 / mu."""

    def force(self, displacement: Array, /, mu: float, fraction: float) -> Array:
        """Force [N] at platen displacements [m], modulus `mu` [Pa]."""


@dataclass(frozen=True)
class Scaled:
    """Curves with every force multiplied by a factor, which may change with the displacement.

    Parameters
    ----------
    factor, displacement : (k,) sequence of float
        Factors, and where they are known [m], ascending: linear between, constant beyond.
    """

    curves: Curves
    factor: Sequence[float] | Array
    displacement: Sequence[float] | Array = (0.0,)

    @property
    def bounds(self) -> tuple[float, float]:
        """Those of the curves."""
        return self.curves.bounds

    def force(self, displacement: Array, /, mu: float, fraction: float) -> Array:
        """Force along the displacement [N]."""
        factor = np.interp(displacement, self.displacement, self.factor)
        return factor * self.curves.force(displacement, mu, fraction)
