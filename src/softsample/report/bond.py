"""Bonded area and shear modulus by either rule of the bond, see `softsample.response.bond`."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from softsample.response.bond import CONTACT, WITHIN_DEPTH

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
    others: Mapping[str, Mapping[str, float] | None],
) -> pd.DataFrame:
    """One row for each bonded piece.

    Parameters
    ----------
    reports, cuboids, rows
        `bond/{sample}.json`, `cuboid/{sample}.json` and row of the table by piece.
    fits
        Calibrations of all groups, geometries and models; the two-term ones count.
    others
        By group: moduli if the other rule had bonded its samples; None if that is not known.

    Returns
    -------
    DataFrame
        By rule the bonded area [mm2, and % of the ideal shape's section], the modulus of the group
        on the real geometry [Pa], and the bias [%] of its ideal shape: 100 (ideal / real - 1).
        `force_percent`: by how much more work of loading the force by contact does. What is not
        known is NaN.
    """
    two_term = {(f["group"], f["geometry"]): f for f in fits if f["model"] == "ogden2"}
    table = []
    for piece, report in reports.items():
        group = rows[piece]["group"]
        real, ideal = two_term[group, "real"], two_term[group, "ideal"]
        other = _known((others[group] or {}).get("mu_pa"))
        mu = {rule: real["mu_pa"] if rule == report["rule"] else other for rule in RULES}
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


def _known(value: float | None) -> float:
    return float("nan") if value is None else value
