"""Curves of a sample as a smooth function of the mixture r = mu1 / mu."""

from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from softsample.errors import CalibrationError
from softsample.protocol import travel_sign

Array = NDArray[np.float64]


def refined(displacement: Array, curve: Array, times: int) -> Array:
    """Curve (n,) on a grid `times` as fine, ((n - 1) times + 1,), by a shape-preserving spline."""
    steps = np.arange(len(curve))
    fine = np.linspace(0.0, steps[-1], times * steps[-1] + 1)
    if curve is displacement:
        return np.interp(fine, steps, displacement)
    where = np.interp(fine, steps, displacement)
    return np.asarray(PchipInterpolator(displacement, curve)(where))


SMOOTH = 12
"""Degree of polynomials that follow all of a curve but its roughness."""


class CurveFamily:
    """Force per modulus of one sample and geometry, interpolated between computed mixtures.

    Parameters
    ----------
    fractions : (k,) float64
        Computed values of r = mu1 / mu; a single one gives a family of one mixture.
    displacement : (n,) float64
        Travel of the platen along its direction [m], from zero, ascending.
    force_per_mu : (k, n) float64
        Force along the travel per shear modulus [m2].

    Raises
    ------
    CalibrationError
        If the curves are not finite or do not belong together.
    """

    def __init__(self, fractions: Array, displacement: Array, force_per_mu: Array) -> None:
        if force_per_mu.shape != (len(fractions), len(displacement)):
            raise CalibrationError(
                f"{force_per_mu.shape} forces for {len(fractions)} mixtures at "
                f"{len(displacement)} displacements; simulate the sample again"
            )
        if not np.all(np.isfinite(force_per_mu)):
            raise CalibrationError("a simulated force is not finite; simulate the sample again")
        self.fractions, self.displacement = fractions, displacement
        self.bounds = {"mu1_fraction": (float(fractions.min()), float(fractions.max()))}
        self._nodes = np.sqrt(1.0 - fractions)
        apart = np.subtract.outer(self._nodes, self._nodes) + np.eye(len(fractions))
        self._weighted = force_per_mu / np.prod(apart, axis=1)[:, None]
        self._forces = force_per_mu
        self._last: tuple[float, Array] = (np.nan, force_per_mu[0])

    @classmethod
    def of_table(cls, table: pd.DataFrame, mode: str) -> Self:
        """Family of a file of unit-modulus curves, `mu1_fraction`, `displacement_mm`, ..."""
        forces = table.pivot_table(
            "force_per_mu_mm2", index="mu1_fraction", columns="displacement_mm", observed=True
        ).sort_index(axis=1, key=np.abs)
        sign = travel_sign(mode)
        return cls(
            forces.index.to_numpy(),
            np.asarray(1e-3 * abs(forces.columns.to_numpy()), dtype=np.float64),
            np.asarray(1e-6 * sign * forces.to_numpy(), dtype=np.float64),
        )

    @property
    def grain(self) -> Array:
        """Error that each point of a curve has of its own (k,) [m2], from fourth differences.

        Their variance is 70 times its.
        """
        if len(self.displacement) < 5:
            return np.zeros(len(self._forces))
        return np.sqrt(np.mean(np.diff(self._forces, 4, axis=1) ** 2, axis=1) / 70.0)

    def smoothed(self) -> Self:
        """The same family without its roughness: polynomials of degree `SMOOTH`, from zero on.

        A rough top meets the platen node by node, so that its curve has steps that no tissue has.
        """
        points = len(self.displacement)
        if points < 2 * SMOOTH:
            return self
        place = np.linspace(-1.0, 1.0, points)
        basis = np.polynomial.chebyshev.chebvander(place, SMOOTH)
        basis, _ = np.linalg.qr((basis - basis[0])[:, 1:])  # no force at no travel
        return type(self)(self.fractions, self.displacement, self._forces @ basis @ basis.T)

    def refined(self, times: int) -> Self:
        """The same family on a grid `times` as fine, by cubic splines along the travel."""
        fine = np.stack([refined(self.displacement, curve, times) for curve in self._forces])
        travel = refined(self.displacement, self.displacement, times)
        return type(self)(1.0 - self._nodes**2, travel, fine)

    def less(self, other: Self) -> Self:
        """What its forces have more than those of another family, at the mixtures of that one."""
        curves = [
            self.force_per_mu(r, other.displacement) - other.curve(r) for r in other.fractions
        ]
        return type(self)(other.fractions, other.displacement, np.stack(curves))

    def force_per_mu(self, fraction: float, displacement: Array) -> Array:
        """Force per modulus [m2] at travels `displacement` [m] for the mixture `fraction`.

        Beyond the simulated range the end values hold, so that noise of the displacement
        reading does not extrapolate.
        """
        return np.interp(displacement, self.displacement, self.curve(fraction))

    def curve(self, fraction: float) -> Array:
        """Force per modulus (n,) [m2] at the family's displacements: Lagrange's polynomial.

        A family of one mixture has the same curve for all.
        """
        known, curve = self._last  # fits ask for the same mixture again and again
        if fraction != known:
            curve = self._curve(fraction)
            self._last = fraction, curve
        return curve

    def _curve(self, fraction: float) -> Array:
        away = np.sqrt(1.0 - fraction) - self._nodes
        if len(away) == 1 or not away.all():
            return self._forces[int(np.argmin(np.abs(away)))]
        return np.asarray((np.prod(away) / away) @ self._weighted)

    def force(self, displacement: Array, /, mu: float, *shape: float) -> Array:
        """Force along the travel [N] for a shear modulus `mu` [Pa]; `shape` is the fraction."""
        (fraction,) = shape
        return mu * self.force_per_mu(fraction, displacement)


class Curves(Protocol):
    """Modelled curves of one sample and geometry, whatever they come from."""

    @property
    def bounds(self) -> dict[str, tuple[float, float]]:
        """Range of each parameter beside the modulus, in the order in which `force` takes them."""

    def force(self, displacement: Array, /, mu: float, *shape: float) -> Array:
        """Force along the travel [N] at travels `displacement` [m], modulus `mu` [Pa]."""


@dataclass(frozen=True)
class Scaled:
    """Curves with every force multiplied by `factor`."""

    curves: Curves
    factor: float

    @property
    def bounds(self) -> dict[str, tuple[float, float]]:
        """Those of the curves."""
        return self.curves.bounds

    def force(self, displacement: Array, /, mu: float, *shape: float) -> Array:
        """Force along the travel [N]."""
        return self.factor * self.curves.force(displacement, mu, *shape)
