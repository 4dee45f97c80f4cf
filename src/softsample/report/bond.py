"""Bonded area and shear modulus by either rule of the bond, see `softsample.response.bond`."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from softsample.response.bond import CONTACT, WITHIN_DEPTH, log_force

RULES = (WITHIN_DEPTH, CONTACT)

COLUMNS = (
    "sample", "group", "mode",
    *(f"{rule}_{what}" for rule in RULES for what in ("mm2", "percent", "mu_pa", "bias_percent")),
    "force_percent",
)  # fmt: skip


def bond_table(
    reports: Mapping[str, Mapping[str, Any]],
    cuboids: Mapping[str, Mapping[str, float]],
    rows: Mapping[str, Mapping[str, str]],
    fits: Sequence[Mapping[str, Any]],
    piece_of: Mapping[str, str],
) -> pd.DataFrame:
    """One row for each bonded piece.

    Parameters
    ----------
    reports, cuboids, rows
        `bond/{sample}.json`, `cuboid/{sample}.json` and row of the table by piece.
    fits
        Calibrations of all groups, geometries and models; the two-term ones count.
    piece_of
        Piece by sample.

    Returns
    -------
    DataFrame
        By rule the bonded area [mm2, and % of the ideal shape's section], the modulus of the group
        on the real geometry [Pa], and the bias [%] of its ideal shape: 100 (ideal / real - 1).
        `force_percent`: force by contact over that within the depth. What is not known is NaN.
    """
    two_term = {(f["group"], f["geometry"]): f for f in fits if f["model"] == "ogden2"}
    table = []
    for piece, report in reports.items():
        group = rows[piece]["group"]
        real, ideal = two_term[group, "real"], two_term[group, "ideal"]
        factor = modulus_factor(real, reports, piece_of)
        mu = {rule: real["mu_pa"] * (factor if rule != report["rule"] else 1.0) for rule in RULES}
        area = {rule: _known(report[f"{rule}_mm2"]) for rule in RULES}
        row: dict[str, Any] = {"sample": piece, "group": group, "mode": rows[piece]["mode"]}
        for rule in RULES:
            row |= {
                f"{rule}_mm2": area[rule],
                f"{rule}_percent": 100.0 * area[rule] / cuboids[piece]["ideal_area_mm2"],
                f"{rule}_mu_pa": mu[rule],
                f"{rule}_bias_percent": 100.0 * (ideal["mu_pa"] / mu[rule] - 1.0),
            }
        table.append(row | {"force_percent": _known(report["force_percent"])})
    return pd.DataFrame(table, columns=list(COLUMNS))


def modulus_factor(
    fit: Mapping[str, Any],
    reports: Mapping[str, Mapping[str, Any]],
    piece_of: Mapping[str, str],
) -> float:
    """Modulus of a group with its samples bonded by the other rule, over its calibrated modulus.

    The calibration's change by a percent of force is taken to go on in the logarithms.
    """
    bonded = {
        sample: change["mu_pa"]
        for sample, change in fit["uncertainty"]["per_percent_of_force"].items()
        if piece_of[sample] in reports
    }
    logs = [100.0 * mu * log_force(reports[piece_of[sample]]) for sample, mu in bonded.items()]
    return float(np.exp(sum(logs) / fit["mu_pa"]))


def _known(value: float | None) -> float:
    return float("nan") if value is None else value
