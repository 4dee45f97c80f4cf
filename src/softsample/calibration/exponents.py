"""Calibration with free exponents: curves between computed ones; whether groups share them."""

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from itertools import product
from typing import Any, Self

import numpy as np
import pandas as pd
from scipy.optimize import minimize
from scipy.special import gammaincc

from softsample.arrays import Array
from softsample.calibration.likelihood import AreaLikelihood, Profile
from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.slsqp import CalibrationSettings, fit_ogden
from softsample.calibration.uncertainty import Uncertainty, UncertaintySettings
from softsample.errors import CalibrationError
from softsample.protocol import travel_sign
from softsample.response.closed_form import ClosedForm, two_terms
from softsample.response.curves import ResponseCurves
from softsample.response.law_response import REFERRED


def cardinal(nodes: Array, x: float) -> Array:
    """Lagrange's polynomials (k,) of `nodes` (k,) at `x`."""
    ratio = (x - nodes) / (nodes[:, None] - nodes + np.eye(len(nodes)))
    np.fill_diagonal(ratio, 1.0)
    return ratio.prod(axis=1)


class ExponentFamily:
    """Force per modulus of one sample and geometry between mixtures and exponents.

    Forces change by orders of magnitude with the exponents, but little against the stress of a
    homogeneous test of the same material and nominal strain: that ratio is interpolated.

    Parameters
    ----------
    grid : dict of (k,) float64
        Ascending nodes of `mu1_fraction`, `alpha1`, `alpha2`.
    displacement : (n,) float64
        Travel of the platen along its direction [m], from zero, ascending.
    force_per_mu : (k1, k2, k3, n) float64
        Force along the travel per shear modulus [m2].
    stress : callable
        Stress per modulus (n,) of the homogeneous test at a mixture and two exponents.

    Raises
    ------
    CalibrationError
        If the forces are not finite or do not fill the grid.
    """

    def __init__(
        self,
        grid: Mapping[str, Array],
        displacement: Array,
        force_per_mu: Array,
        stress: Callable[[float, float, float], Array],
    ) -> None:
        shape = (*(len(nodes) for nodes in grid.values()), len(displacement))
        if force_per_mu.shape != shape or not np.all(np.isfinite(force_per_mu)):
            raise CalibrationError(
                f"the simulated forces {force_per_mu.shape} do not fill the grid {shape} of "
                "modulus fractions, exponents and displacements; simulate the sample again"
            )
        self.grid, self.displacement, self._stress = dict(grid), displacement, stress
        homogeneous = [stress(*place) for place in product(*grid.values())]
        self._area = np.empty(shape)
        self._area[..., 1:] = force_per_mu[..., 1:] / np.reshape(homogeneous, shape)[..., 1:]
        self._area[..., 0] = self._area[..., 1]
        self.bounds = {name: (float(n.min()), float(n.max())) for name, n in grid.items()}

    @classmethod
    def of_table(cls, table: pd.DataFrame, mode: str, height: float, poisson_ratio: float) -> Self:
        """Family of a file of curves (`mu1_fraction`, ...) of a sample of some height [m]."""
        names = ["mu1_fraction", "alpha1", "alpha2"]
        table = table.assign(travel=1e-3 * table["displacement_mm"].abs())
        table = table.sort_values([*names, "travel"])
        grid = {name: np.unique(table[name].to_numpy()) for name in names}
        displacement = np.unique(table["travel"].to_numpy())
        force = 1e-6 * travel_sign(mode) * table["force_per_mu_mm2"].to_numpy()
        runs = [len(nodes) for nodes in grid.values()]
        like = REFERRED.get(mode, mode)
        closed = ClosedForm(1.0, like, displacement / height, False, poisson_ratio)
        return cls(
            grid,
            displacement,
            force.reshape(*runs, force.size // int(np.prod(runs))),
            lambda fraction, *alpha: closed.ogden(two_terms(fraction, alpha)),
        )

    @classmethod
    def of_tables(
        cls,
        table: pd.DataFrame,
        fine: pd.DataFrame,
        mode: str,
        height: float,
        material: Mapping[str, Any],
    ) -> Self:
        """`of_table`, at the level of the curves `fine` of the study's mesh and `material`."""
        family = cls.of_table(table, mode, height, material["poisson_ratio"])
        return family.anchored(ResponseCurves.of_table(fine, mode), material["alpha"])

    def force_per_mu(self, fraction: float, alpha1: float, alpha2: float) -> Array:
        """Force per modulus [m2] (n,) at the family's displacements."""
        area = self._area
        axes = (np.sqrt(1.0 - self.grid["mu1_fraction"]), self.grid["alpha1"], self.grid["alpha2"])
        for nodes, x in zip(axes, (np.sqrt(1.0 - fraction), alpha1, alpha2), strict=True):
            area = np.tensordot(cardinal(nodes, x), area, axes=1)
        return area * self._stress(fraction, alpha1, alpha2)

    def force(
        self, displacement: Array, /, mu: float, fraction: float, alpha1: float, alpha2: float
    ) -> Array:
        """Force along the travel [N] at travels `displacement` [m] for a modulus `mu` [Pa]."""
        curve = self.force_per_mu(fraction, alpha1, alpha2)
        return mu * np.interp(displacement, self.displacement, curve)

    def anchored(self, fine: ResponseCurves, alpha: Sequence[float]) -> Self:
        """The same with the level of a finer mesh, whose family is known at the exponents `alpha`.

        Each mixture's forces are multiplied by the ratio of fine to coarse at `alpha`, so that the
        coarse mesh tells the effect of the exponents alone.
        """
        anchored = copy(self)
        anchored._area = self._area.copy()
        for k, fraction in enumerate(self.grid["mu1_fraction"]):
            coarse = self.force_per_mu(fraction, *alpha)
            there = coarse > 0.01 * coarse.max()
            ratio = fine.force_per_mu(fraction, self.displacement)[there] / coarse[there]
            anchored._area[k] *= np.interp(self.displacement, self.displacement[there], ratio)
        return anchored


def exponent_report(
    likelihood: AreaLikelihood, profiles: Mapping[str, Profile], alpha: Sequence[float]
) -> dict[str, Any]:
    """What a fit with free exponents found, with profile intervals.

    Parameters
    ----------
    likelihood : AreaLikelihood
        Of the fit.
    profiles : dict of Profile
        By parameter.
    alpha : sequence of two float
        Exponents of the study, whose deviance from the free ones is given.
    """
    study = dict(zip(("alpha1", "alpha2"), alpha, strict=True))
    deviance = likelihood.at(study)
    return {
        **likelihood.fit.report(),
        "effective_points": likelihood.points,
        "interval": {name: profile.ends() for name, profile in profiles.items()},
        "deviance_of_study": deviance,
        "area_of_study_over_free": float(np.exp(0.5 * deviance / likelihood.points)),
    }


def confirmation(measured: MeasuredCurve, direct: Array, modelled: Array) -> dict[str, float]:
    """What a run at an optimum says of the fit.

    Parameters
    ----------
    measured : MeasuredCurve
    direct, modelled : (n,) float64
        Force of the run, and what the fit took for it [N].

    Returns
    -------
    dict
        `area_error_percent` of the run; `against_calibrated_curve_percent`: largest difference, of
        the peak; `modulus_percent`: by which the modulus differs.
    """
    difference = np.abs(direct - modelled).max() / np.abs(modelled).max()
    return {
        "area_error_percent": 100.0 * measured.area_between(direct) / measured.area,
        "against_calibrated_curve_percent": 100.0 * float(difference),
        "modulus_percent": 100.0 * (measured.scale_of(direct) / measured.scale_of(modelled) - 1.0),
    }


def profile_table(group: str, profiles: Mapping[str, Profile]) -> pd.DataFrame:
    """Columns `group`, `parameter`, `value`, `deviance` of profiles by parameter."""
    return pd.concat(
        pd.DataFrame(
            {
                "group": group,
                "parameter": name,
                "value": profile.points,
                "deviance": profile.deviance,
            }
        )
        for name, profile in profiles.items()
    )


def common_exponents(groups: Sequence[AreaLikelihood]) -> dict[str, Any]:
    """Likelihood ratio test of exponents that all groups share.

    Each group keeps its moduli. The deviance of the best common pair, less that of each group's
    own, has chi-squared's distribution with 2 (groups - 1) degrees of freedom if exponents are
    constant and only the scatter of the records parts them.

    Raises
    ------
    CalibrationError
        With fewer than two groups.
    """
    if len(groups) < 2:
        raise CalibrationError("exponents of one group alone cannot be compared")
    names = ("alpha1", "alpha2")
    own = np.array([[group.fit.shape[name] for name in names] for group in groups])
    bounds = [groups[0].search.bounds[name] for name in names]

    def deviance(alpha: Array) -> float:
        return sum(group.at(dict(zip(names, alpha, strict=True))) for group in groups)

    found = minimize(deviance, np.median(own, axis=0), method="Nelder-Mead", bounds=bounds)
    freedom = 2 * (len(groups) - 1)
    return {
        "groups": len(groups),
        "alpha1": float(found.x[0]),
        "alpha2": float(found.x[1]),
        "deviance": float(found.fun),
        "degrees_of_freedom": freedom,
        "p_value": float(gammaincc(0.5 * freedom, 0.5 * found.fun)),
    }


def exponents_of_groups(
    groups: Mapping[str, Sequence[str]],
    families: Mapping[str, ExponentFamily],
    measured: Mapping[str, MeasuredCurve],
    alpha: Sequence[float],
    settings: CalibrationSettings,
    uncertainty: UncertaintySettings,
    loadings: Mapping[str, str],
    progress: Callable[[str, float], None],
) -> tuple[dict[str, Any], pd.DataFrame]:
    """Free exponents of each group, and whether groups share them.

    Parameters
    ----------
    groups : mapping
        Samples by group.
    families, measured : mapping
        Curves and loading by sample.
    alpha : sequence of two float
        Exponents of the study.
    settings, uncertainty
        Of the fits, and of their intervals.
    loadings : mapping of str
        Loading of each group in one word; groups of one loading are compared.
    progress : callable
        Told the group and the finished part.

    Returns
    -------
    report : dict
        `groups`: `exponent_report` and `loading` of each; `common`: `common_exponents` of all and
        of each loading with two groups or more.
    profiles : DataFrame
        `profile_table` of all.
    """
    likelihoods, reports, tables = {}, {}, []
    for done, (group, samples) in enumerate(groups.items()):
        progress(group, done / len(groups))
        own: dict[str, Any] = {s: families[s] for s in samples}
        loads = {s: measured[s] for s in samples}
        fit = fit_ogden(own, loads, settings)
        likelihoods[group] = Uncertainty(own, loads, fit, settings, uncertainty).likelihood()
        profiles = likelihoods[group].profiles(uncertainty.confidence)
        tables.append(profile_table(group, profiles))
        reports[group] = {
            "loading": loadings[group],
            **exponent_report(likelihoods[group], profiles, alpha),
        }
    kinds: dict[str, list[str]] = {"all": list(groups)}
    for group in groups:
        kinds.setdefault(loadings[group], []).append(group)
    common = {
        kind: common_exponents([likelihoods[group] for group in names])
        for kind, names in kinds.items()
        if len(names) > 1
    }
    return {"groups": reports, "common": common}, pd.concat(tables)
