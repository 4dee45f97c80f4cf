"""Tables of the two-term Ogden law with free exponents."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from softsample.laws.shared import shared_value
from softsample.protocol import loading

EXPONENTS = ("alpha1", "alpha2")

SIGNIFICANCE = 0.05
"""Exponents count as different below this probability."""


def exponent_table(
    law: str,
    reports: Mapping[str, Mapping[str, Any]],
    curves: Mapping[str, pd.DataFrame],
    runs: Mapping[str, pd.DataFrame],
) -> pd.DataFrame:
    """Modulus and exponents of each group.

    Parameters
    ----------
    law : str
        Name of the candidate; the other law of the reports has the study's exponents.
    reports, curves
        Of `softsample.laws.group.group_report`, by group.
    runs
        Of `softsample.laws.setup.SamplesOfGroup.confirmed`, by group.

    Returns
    -------
    DataFrame
        One row a group: moduli [Pa] and exponents with their intervals (an end is empty where it
        is open), mean area between the curves [% of the measured], by how much the study's
        exponents make it larger, whether the records reject these, parameters at a bound or open,
        and the largest difference of a run on the study's mesh [% of peak].
    """
    rows = []
    for group, report in reports.items():
        laws = report["laws"]
        (study,) = laws.keys() - {law}
        fit, share = laws[law], laws[law]["shape"]["mu1_fraction"]
        areas = {name: _area_percent(part) for name, part in curves[group].groupby("law")}
        row: dict[str, Any] = {"group": group, "mode": loading(report["modes"])}
        row |= {"mu1_pa": share * fit["mu_pa"], "mu2_pa": (1.0 - share) * fit["mu_pa"]}
        for name, unit in (("mu", "_pa"), *((name, "") for name in EXPONENTS)):
            found = fit["intervals"][name]
            row[f"{name}{unit}"] = found["value"]
            for end in ("low", "high"):
                row[f"{name}_{end}{unit}"] = np.nan if found[end] is None else found[end]
        rows.append({
            **row,
            "area_error_percent": areas[law],
            "area_of_study_percent": 100.0 * (areas[study] / areas[law] - 1.0),
            "study_rejected": study not in fit["simpler"],
            "active_bounds": "; ".join(fit["at_bound"]),
            "open": "; ".join(fit["open"]),
            "mesh_curve_percent": runs[group]["difference_percent"].max(),
        })  # fmt: skip
    return pd.DataFrame(rows)


def _area_percent(curves: pd.DataFrame) -> float:
    """Area between record and law over that under the record [%], the mean over samples."""
    parts = []
    for _, own in curves.groupby("sample"):
        gap, way = (own["measured_N"] - own["model_N"]).abs(), own["displacement_mm"]
        parts.append(np.trapezoid(gap, way) / np.trapezoid(own["measured_N"].abs(), way))
    return float(100.0 * np.mean(parts))


def common_table(law: str, reports: Mapping[str, Mapping[str, Any]]) -> pd.DataFrame:
    """Exponents that groups share, and whether they do: all of them, and those of each loading.

    Parameters
    ----------
    law, reports
        As of `exponent_table`.
    """
    kinds: dict[str, list[str]] = {"all": list(reports)}
    for group, report in reports.items():
        kinds.setdefault(loading(report["modes"]), []).append(group)
    rows = []
    for kind, groups in kinds.items():
        if len(groups) < 2:
            continue
        fits = [reports[group]["laws"][law] for group in groups]
        places = [list(fits[0]["shape"]).index(name) for name in EXPONENTS]
        found = shared_value(
            [np.array([fit["shape"][name] for name in EXPONENTS]) for fit in fits],
            [np.array(fit["covariance_of_shape"])[np.ix_(places, places)] for fit in fits],
        )
        constant = found["p_value"] >= SIGNIFICANCE
        rows.append({
            "mode": kind,
            **dict(zip(EXPONENTS, found.pop("value"), strict=True)),
            **found,
            "verdict": "constant" if constant else "not constant",
        })  # fmt: skip
    return pd.DataFrame(rows)
