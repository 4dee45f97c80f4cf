"""Calibration as in the study: SLSQP on the absolute area between measured and modelled curve."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import OptimizeResult, minimize

from softsample.arrays import Array, root_mean_square
from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.profile import end_met
from softsample.errors import CalibrationError
from softsample.response.curves import Curves

STARTS_PER_PARAMETER = {"family": 3, "direct": 1}
"""Starting values of each parameter by method; SLSQP runs from every combination. Simulations at
every evaluation allow no more than one."""

TOLERANCE = {"family": 1e-10, "direct": 1e-6}
"""SLSQP's `ftol` on the relative area, by method: simulated forces are in single precision."""

DIFFERENCE_STEP = {"family": 1.5e-8, "direct": 3e-4}
"""Step in ln(mu) and mu1/mu of its forward differences, by method: the square root of rounding; of
simulated forces larger steps bend the gradient, and smaller ones drown in their rounding."""

MISSED = 0.25
"""Part of the area under a record from which on the model does not suit it: the real geometry of
the shipped samples leaves at most 0.03, cuboids of them up to 0.29."""


@dataclass(frozen=True)
class CalibrationSettings:
    """Method and bounds; mirrors config `calibration:`.

    Parameters
    ----------
    mu_pa_min, mu_pa_max : float
        Bounds of the shear modulus [Pa].
    method : str
        `family`: forces come from response curves; `direct`: a simulation per evaluation.
    """

    mu_pa_min: float = 1.0
    mu_pa_max: float = 1.0e6
    method: str = "family"


@dataclass(frozen=True)
class Fit:
    """Calibrated parameters of one group.

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
    """

    mu: float
    mu1_fraction: float
    area_error: dict[str, float]
    rms: dict[str, float]
    starts: list[dict[str, Any]]
    active_bounds: list[str]

    @property
    def converged(self) -> bool:
        """Whether a start that reached the least area, within 1 %, converged."""
        best = min(start["area_error_percent"] for start in self.starts)
        near = [s for s in self.starts if s["area_error_percent"] < 1.01 * best + 1e-3]
        return any(start["converged"] for start in near)

    @property
    def finding(self) -> str | None:
        """What an optimum on a bound, or far off the records, says of data and model; else None."""
        single = "these data do not support a second term (mu1/mu = {})"
        ends = {
            "mu1_fraction at its maximum": single.format(1),
            "mu1_fraction at its minimum": single.format(0),
            "mu at its maximum": "these data drive mu at its maximum, calibration: mu_pa_max",
            "mu at its minimum": "these data drive mu at its minimum, calibration: mu_pa_min",
        }
        parts = [ends.get(bound, f"these data drive {bound}") for bound in self.active_bounds]
        worst, error = max(self.area_error.items(), key=lambda item: item[1])
        if error > MISSED:
            missed = f"{100.0 * error:.0f} % of its area is missed"
            parts.append(f"the model does not suit {worst}: {missed}")
        return "; ".join(parts) or None

    @property
    def success(self) -> bool:
        """Whether it converged away from all bounds."""
        return self.converged and not self.active_bounds

    def report(self) -> dict[str, Any]:
        """Everything a reader of the fit wants, units in the names."""
        verdict = self.finding or "converged" if self.converged else "not converged"
        return {
            "mu1_pa": self.mu * self.mu1_fraction,
            "mu2_pa": self.mu * (1.0 - self.mu1_fraction),
            "mu_pa": self.mu,
            "mu1_fraction": self.mu1_fraction,
            "area_error_percent": {name: 100.0 * e for name, e in self.area_error.items()},
            "rms_N": self.rms,
            "active_bounds": self.active_bounds,
            "finding": self.finding,
            "converged": self.converged,
            "success": self.success,
            "verdict": verdict,
            "iterations": sum(start["iterations"] for start in self.starts),
            "starts": self.starts,
        }


class AreaObjective:
    """Absolute area between the curves of all samples of a group, over the measured area.

    Parameters
    ----------
    families : dict of Curves
        Modelled curves by sample.
    measured : dict of MeasuredCurve
        Loading ramps by sample.

    Raises
    ------
    CalibrationError
        If a sample lacks its partner, a record carries no force, or the curves share no fraction.
    """

    def __init__(
        self, families: Mapping[str, Curves], measured: Mapping[str, MeasuredCurve]
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
        self.bounds = _common_bounds(families)
        self._scale = sum(curve.area for curve in measured.values())

    def force(self, sample: str, mu: float, fraction: float) -> Array:
        """Modelled force [N] of `sample` at its measured displacements."""
        return self.families[sample].force(self.measured[sample].displacement, mu, fraction)

    def __call__(self, mu: float, fraction: float) -> float:
        """Sum of the areas between the curves over the sum of the areas under the measured."""
        areas = (
            curve.area_between(self.force(sample, mu, fraction))
            for sample, curve in self.measured.items()
        )
        return sum(areas) / self._scale


def _common_bounds(families: Mapping[str, Curves]) -> tuple[float, float]:
    """Range of mu1 / mu that all samples share."""
    ranges = [family.bounds for family in families.values()]
    low, high = max(low for low, _ in ranges), min(high for _, high in ranges)
    if low > high:
        raise CalibrationError(
            f"the curves of {sorted(families)} share no range of mu1_fraction; simulate them with "
            "the same settings"
        )
    return low, high


class Search:
    """The calibration as SLSQP sees it: variables ln(mu) and, if it has a range, mu1 / mu.

    Parameters
    ----------
    objective : AreaObjective
        What is made small.
    settings : CalibrationSettings
        Bounds of the modulus, and the method.
    """

    def __init__(self, objective: AreaObjective, settings: CalibrationSettings) -> None:
        self.objective, self.settings = objective, settings
        low, high = objective.bounds
        modulus = np.log(settings.mu_pa_min), np.log(settings.mu_pa_max)
        self.bounds = {"mu": (float(modulus[0]), float(modulus[1]))}
        self.bounds |= {"mu1_fraction": (low, high)} if low < high else {}

    def pack(self, mu: float, fraction: float) -> Array:
        """Variables of a modulus [Pa] and a fraction."""
        return np.array([np.log(mu), fraction][: len(self.bounds)])

    def unpack(self, x: Array) -> tuple[float, float]:
        """Modulus [Pa] and fraction of variables."""
        return float(np.exp(x[0])), float(x[1]) if len(x) > 1 else self.objective.bounds[0]

    def __call__(self, x: Array) -> float:
        """Relative area at variables `x`."""
        return self.objective(*self.unpack(x))

    def descend(self, start: Array) -> OptimizeResult:
        """SLSQP from variables `start`."""
        return minimize(
            self,
            start,
            method="SLSQP",
            bounds=list(self.bounds.values()),
            options={
                "ftol": TOLERANCE[self.settings.method],
                "eps": DIFFERENCE_STEP[self.settings.method],
                "maxiter": 200,
            },
        )

    def starts(self) -> list[Array]:
        """Inner points of the range of mu1 / mu, each with moduli around the one that fits it best.

        And the ends of the range, where that costs no simulation: where one term is a thousand
        times as stiff as the other at the end of the stroke, no inner point leads to the softer.
        """
        n = STARTS_PER_PARAMETER[self.settings.method]
        inner = (np.arange(n) + 0.5) / n
        low, high = self.objective.bounds
        measured = self.objective.measured
        seen = sum(np.abs(curve.force).sum() for curve in measured.values())
        starts = []
        around = np.exp(np.linspace(-0.5, 0.5, n))
        points = [(part, around) for part in (low + inner * (high - low) if high > low else [low])]
        if n > 1 and len(self.bounds) > 1:
            points += [(end, np.ones(1)) for end in (low, high)]
        for fraction, factors in points:
            unit = sum(np.abs(self.objective.force(s, 1.0, fraction)).sum() for s in measured)
            for factor in factors:
                x = self.pack(factor * seen / unit, fraction)
                x[0] = np.clip(x[0], *self.bounds["mu"])
                starts.append(x)
        return starts


def fit_ogden(
    families: Mapping[str, Curves],
    measured: Mapping[str, MeasuredCurve],
    settings: CalibrationSettings,
) -> Fit:
    """Find mu and mu1 / mu of a group's curves by multi-start SLSQP.

    The variables are ln(mu), and mu1/mu as far as the families cover a range.

    Raises
    ------
    CalibrationError
        If a record carries no force, the families share no fraction, or no start ends finite.

    References
    ----------
    D. Kraft, A software package for sequential quadratic programming, DFVLR-FB 88-28, 1988.
    """
    search = Search(AreaObjective(families, measured), settings)
    starts = search.starts()
    results = [search.descend(start) for start in starts]
    finite = [result for result in results if np.isfinite(result.fun)]
    if not finite:
        raise CalibrationError("no start of SLSQP gave a finite area; check record and curves")
    reports = [_start_report(search, *pair) for pair in zip(starts, results, strict=True)]
    return _fit(search, min(finite, key=lambda result: float(result.fun)).x, reports)


def _start_report(search: Search, start: Array, result: OptimizeResult) -> dict[str, Any]:
    names = ("mu_pa", "mu1_fraction")
    points = {"from": search.unpack(start), "to": search.unpack(result.x)}
    return {
        **{f"{w}_{n}": v for w, point in points.items() for n, v in zip(names, point, strict=True)},
        "area_error_percent": 100.0 * float(result.fun),
        "iterations": int(result.nit),
        "evaluations": int(result.nfev),
        "converged": bool(result.success),
        "message": str(result.message),
    }


def _active(x: Array, bounds: Mapping[str, tuple[float, float]]) -> list[str]:
    """Names of the bounds that the optimum touches."""
    parts = [(v - low) / (high - low) for v, (low, high) in zip(x, bounds.values(), strict=True)]
    ends = zip(bounds, map(end_met, parts), strict=True)
    return [f"{name} at its {end}" for name, end in ends if end]


def _fit(search: Search, x: Array, starts: list[dict[str, Any]]) -> Fit:
    objective, active = search.objective, _active(x, search.bounds)
    mu, fraction = search.unpack(x)
    area_error, rms = {}, {}
    for sample, curve in objective.measured.items():
        force = objective.force(sample, mu, fraction)
        area_error[sample] = curve.area_between(force) / curve.area
        rms[sample] = root_mean_square(force - curve.force)
    return Fit(mu, fraction, area_error, rms, starts, active)
