"""Moduli of a group if the other rule had bonded its samples."""

from collections.abc import Mapping
from typing import Any

from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.slsqp import CalibrationSettings, fit_ogden
from softsample.response.bond import of_other_rule
from softsample.response.curves import ResponseCurves


def other_bond(
    responses: Mapping[str, ResponseCurves],
    measured: Mapping[str, MeasuredCurve],
    bonds: Mapping[str, Mapping[str, Any]],
    settings: CalibrationSettings,
) -> dict[str, float] | None:
    """The calibration of a group, with the forces of the other rule of the bond.

    Parameters
    ----------
    responses, measured : mapping
        Response of the real geometry and loading by sample.
    bonds : mapping
        `bond/{sample}.json` of the samples that are bonded by a rule; those that are not calibrated
        do not count.

    Returns
    -------
    dict or None
        `mu_pa` and `mu1_fraction`; None if a sample's force with the other rule is not known.
    """
    if any(report["force_ratio"] is None for name, report in bonds.items() if name in measured):
        return None
    curves = {
        name: of_other_rule(curve, bonds[name]) if name in bonds else curve
        for name, curve in responses.items()
    }
    fit = fit_ogden(curves, measured, settings)
    return {"mu_pa": fit.mu, "mu1_fraction": fit.mu1_fraction}
