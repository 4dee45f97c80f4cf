"""Tables of the two-term Ogden law with free exponents."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from softsample.laws.shared import shared_value
from softsample.protocol import loading

EXPONENTS = ("alpha1", "alpha2")

COLUMNS = (
    "group", "mode", "mu1_pa", "mu2_pa", "mu_pa", "mu_low_pa", "mu_high_pa", "alpha1", "alpha1_low",
    "alpha1_high", "alpha2", "alpha2_low", "alpha2_high", "error_percent", "study_rejected",
    "active_bounds", "open", "mesh_curve_percent",
)  # fmt: skip
"""Of the table of exponents."""

SIGNIFICANCE = 0.05
"""Exponents count as different below this probability."""


def exponent_table(
    law: str, reports: Mapping[str, Mapping[str, Any]], runs: Mapping[str, pd.DataFrame]
) -> pd.DataFrame:
    """Modulus and exponents of each group.

    Parameters
    ----------
    law : str
        Name of the candidate; the other law of the reports has the study's exponents.
    reports
        Of `softsample.laws.group.group_report`, by group.
    runs
        Of `softsample.laws.setup.SamplesOfGroup.confirmed`, by group.

    Returns
    -------
    DataFrame
        One row a group: moduli [Pa] and exponents with their intervals (an end is empty where it
        is open), error [% of peak], whether the records reject the study's exponents, parameters
        at a bound or open, and the largest difference of a run on the study's mesh [% of peak].
        Of a group whose law could not be simulated all is empty but the reason, in `open`.
    """
    rows = []
    for group, report in reports.items():
        laws = report["laws"]
        if law not in laws:
            rows.append({"group": group, "mode": loading(report["modes"]),
                         "open": report["skipped"][law]})  # fmt: skip
            continue
        (study,) = laws.keys() - {law}
        fit, share = laws[law], laws[law]["shape"]["mu1_fraction"]
        row: dict[str, Any] = {"group": group, "mode": loading(report["modes"])}
        row |= {"mu1_pa": share * fit["mu_pa"], "mu2_pa": (1.0 - share) * fit["mu_pa"]}
        for name, unit in (("mu", "_pa"), *((name, "") for name in EXPONENTS)):
            found = fit["intervals"][name]
            row[f"{name}{unit}"] = found["value"]
            for end in ("low", "high"):
                row[f"{name}_{end}{unit}"] = np.nan if found[end] is None else found[end]
        rows.append({
            **row,
            "error_percent": fit["error_fitted_percent"],
            "study_rejected": study not in fit["simpler"],
            "active_bounds": "; ".join(fit["at_bound"]),
            "open": "; ".join(fit["open"]),
            "mesh_curve_percent": runs[group]["difference_percent"].max(),
        })  # fmt: skip
    return pd.DataFrame(rows, columns=list(COLUMNS))


def common_table(law: str, reports: Mapping[str, Mapping[str, Any]]) -> pd.DataFrame:
    """Exponents that groups share, and whether they do: all of them, and those of each loading.

    Groups without a fit, or whose records leave an end of an interval open, have no part.

    Parameters
    ----------
    law, reports
        As of `exponent_table`.
    """
    kinds: dict[str, list[str]] = {"all": []}
    for group, report in reports.items():
        fit = report["laws"].get(law)
        ends = [fit["intervals"][name] for name in EXPONENTS] if fit else []
        if fit and not any(None in (end["low"], end["high"]) for end in ends):
            for kind in ("all", loading(report["modes"])):
                kinds.setdefault(kind, []).append(group)
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
