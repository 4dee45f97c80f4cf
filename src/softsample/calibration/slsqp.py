"""Calibration as in the study: SLSQP on the absolute area between measured and modelled curve."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from softsample.calibration.curves import CurveFamily, MeasuredCurve
from softsample.errors import CalibrationError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CalibrationSettings:
    """Optimiser and bounds; mirrors config `calibration:`.

    Parameters
    ----------
    mu_pa_min, mu_pa_max : float
        Bounds of the shear modulus [Pa].
    starts_per_parameter : int
        Starting values per parameter; SLSQP runs from every combination.
    relative_tolerance : float
        SLSQP's `ftol` on the relative area.
    """

    mu_pa_min: float = 50.0
    mu_pa_max: float = 20000.0
    starts_per_parameter: int = 3
    relative_tolerance: float = 1e-10


@dataclass(frozen=True)
class Fit:
    """Calibrated moduli of one group.

    Parameters
    ----------
    mu : float
        Shear modulus mu1 + mu2 [Pa].
    mu1_fraction : float
        mu1 / mu, dimensionless.
    area_error : dict of float
        Per sample: area between the curves over the area under the measured one.
    rms : dict of float
        Per sample: root mean square of the force difference [N].
    starts : list of dict
        Every start: where from, where to, objective, iterations, SLSQP's message.
    active_bounds : list of str
        Bounds on which the optimum lies.
    success : bool
        Whether the best start converged away from all bounds.
    """

    mu: float
    mu1_fraction: float
    area_error: dict[str, float]
    rms: dict[str, float]
    starts: list[dict[str, Any]]
    active_bounds: list[str]
    success: bool

    @property
    def mu1(self) -> float:
        """Modulus of the first term [Pa]."""
        return self.mu * self.mu1_fraction

    @property
    def mu2(self) -> float:
        """Modulus of the second term [Pa]."""
        return self.mu * (1.0 - self.mu1_fraction)

    def report(self) -> dict[str, Any]:
        """Everything a reader of the fit wants, units in the names."""
        verdict = "converged" if self.success else "; ".join(["not trusted", *self.active_bounds])
        return {
            "mu1_pa": self.mu1,
            "mu2_pa": self.mu2,
            "mu_pa": self.mu,
            "mu1_fraction": self.mu1_fraction,
            "area_error_percent": {name: 100.0 * e for name, e in self.area_error.items()},
            "rms_N": self.rms,
            "active_bounds": self.active_bounds,
            "success": self.success,
            "verdict": verdict,
            "iterations": sum(start["iterations"] for start in self.starts),
            "starts": self.starts,
        }


class AreaObjective:
    """Absolute area between the curves of all samples of a group, over the measured area.

    Parameters
    ----------
    families : dict of CurveFamily
        Simulated curves by sample.
    measured : dict of MeasuredCurve
        Loading ramps by sample.
    """

    def __init__(
        self, families: Mapping[str, CurveFamily], measured: Mapping[str, MeasuredCurve]
    ) -> None:
        if families.keys() != measured.keys() or not families:
            raise CalibrationError(
                f"curves of {sorted(families)} against records of {sorted(measured)}: "
                "each sample of a group needs both"
            )
        for sample, curve in measured.items():
            if not curve.area > 0.0:
                raise CalibrationError(
                    f"the ramp of {sample} has no finite area under its force; check its record"
                )
        self.families, self.measured = families, measured
        self._scale = sum(curve.area for curve in measured.values())

    def force(self, sample: str, mu: float, fraction: float) -> Array:
        """Modelled force [N] of `sample` at its measured displacements."""
        displacement = self.measured[sample].displacement
        return mu * self.families[sample].force_per_mu(fraction, displacement)

    def __call__(self, mu: float, fraction: float) -> float:
        """Sum of the areas between the curves over the sum of the areas under the measured."""
        areas = (
            curve.area_between(self.force(sample, mu, fraction))
            for sample, curve in self.measured.items()
        )
        return sum(areas) / self._scale


def fit_ogden(
    families: Mapping[str, CurveFamily],
    measured: Mapping[str, MeasuredCurve],
    settings: CalibrationSettings,
) -> Fit:
    """Find the shear modulus and the mixture of a group by multi-start SLSQP.

    The variables are ln(mu) and mu1/mu (the latter only if the families cover a range).

    Raises
    ------
    CalibrationError
        If a record carries no force, the families share no mixture, or no start ends finite.

    References
    ----------
    D. Kraft, A software package for sequential quadratic programming, DFVLR-FB 88-28, 1988.
    """
    objective = AreaObjective(families, measured)
    low = max(family.bounds[0] for family in families.values())
    high = min(family.bounds[1] for family in families.values())
    if low > high:
        raise CalibrationError(
            f"the curves of {sorted(families)} share no range of mu1/mu; simulate them with the "
            "same config family:"
        )
    names = ["mu"] if low == high else ["mu", "mu1_fraction"]
    bounds = [(np.log(settings.mu_pa_min), np.log(settings.mu_pa_max)), (low, high)][: len(names)]

    def unpack(x: Array) -> tuple[float, float]:
        return float(np.exp(x[0])), float(x[1]) if len(x) > 1 else low

    def area(x: Array, *_: Any) -> float:
        return objective(*unpack(x))

    starts, best = [], None
    for start in _starts(objective, bounds, low, settings):
        result = minimize(
            area,
            start,
            method="SLSQP",
            bounds=bounds,
            options={"ftol": settings.relative_tolerance, "maxiter": 200},
        )
        starts.append(_start_report(unpack(start), unpack(result.x), result))
        if np.isfinite(result.fun) and (best is None or result.fun < best.fun):
            best = result
    if best is None:
        raise CalibrationError("no start of SLSQP gave a finite area; check record and curves")
    mu, fraction = unpack(best.x)
    return _fit(objective, mu, fraction, starts, _active(names, best.x, bounds))


def _starts(
    objective: AreaObjective, bounds: list[tuple[float, float]], low: float,
    settings: CalibrationSettings,
) -> list[Array]:  # fmt: skip
    """Inner points of the mixture's range, each with moduli around the one that fits it best."""
    n = settings.starts_per_parameter
    inner = (np.arange(n) + 0.5) / n
    fractions = low + inner * (bounds[1][1] - bounds[1][0]) if len(bounds) > 1 else np.array([low])
    starts = []
    for fraction in fractions:
        unit = sum(np.abs(objective.force(s, 1.0, fraction)).sum() for s in objective.measured)
        seen = sum(np.abs(curve.force).sum() for curve in objective.measured.values())
        for factor in np.exp(np.linspace(-0.5, 0.5, n)):
            mu = np.clip(np.log(factor * seen / unit), *bounds[0])
            starts.append(np.array([mu, fraction][: len(bounds)]))
    return starts


def _start_report(
    start: tuple[float, float], end: tuple[float, float], result: Any
) -> dict[str, Any]:
    return {
        "from_mu_pa": start[0],
        "from_mu1_fraction": start[1],
        "to_mu_pa": end[0],
        "to_mu1_fraction": end[1],
        "area_error_percent": 100.0 * float(result.fun),
        "iterations": int(result.nit),
        "evaluations": int(result.nfev),
        "converged": bool(result.success),
        "message": str(result.message),
    }


def _active(names: list[str], x: Array, bounds: list[tuple[float, float]]) -> list[str]:
    """Names of the bounds that the optimum touches (within 0.1 % of the range)."""
    active = []
    for name, value, (low, high) in zip(names, x, bounds, strict=True):
        margin = 1e-3 * (high - low)
        if value - low < margin:
            active.append(f"{name} at its minimum")
        if high - value < margin:
            active.append(f"{name} at its maximum")
    return active


def _fit(
    objective: AreaObjective, mu: float, fraction: float,
    starts: list[dict[str, Any]], active: list[str],
) -> Fit:  # fmt: skip
    area_error, rms = {}, {}
    for sample, curve in objective.measured.items():
        force = objective.force(sample, mu, fraction)
        area_error[sample] = curve.area_between(force) / curve.area
        rms[sample] = float(np.sqrt(np.mean((force - curve.force) ** 2)))
    best = min(start["area_error_percent"] for start in starts)
    agreeing = [s for s in starts if s["area_error_percent"] < 1.01 * best + 1e-3]
    success = not active and any(s["converged"] for s in agreeing)
    return Fit(mu, fraction, area_error, rms, starts, active, success)
