"""Tables of the calibration with free exponents."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

SIGNIFICANCE = 0.05
"""Exponents count as different below this probability."""


def exponent_table(
    fits: Mapping[str, Mapping[str, Any]], runs: Mapping[str, Mapping[str, float]]
) -> pd.DataFrame:
    """Moduli and exponents of each group.

    Parameters
    ----------
    fits
        `softsample.calibration.exponents.exponent_report` by group, with its `loading`.
    runs
        Run at the optimum on the study's mesh by sample: `area_error_percent`,
        `against_calibrated_curve_percent`, `modulus_percent`.

    Returns
    -------
    DataFrame
        One row a group: moduli [Pa], exponents with their profile intervals (empty where open),
        mean area between the curves [% of the measured], by how much the study's exponents make it
        larger, deviance of the study's exponents (chi-squared with two degrees of freedom if
        they hold), bounds touched, and what the study's mesh changes: `mesh_modulus_percent`
        and `mesh_curve_percent` are the largest of the group's samples.
    """
    rows = []
    for group, fit in fits.items():
        samples = list(fit["area_error_percent"])
        row = {"group": group, "mode": fit["loading"]}
        row |= {f"{name}_pa": fit[f"{name}_pa"] for name in ("mu1", "mu2", "mu")}
        for name in ("alpha1", "alpha2"):
            ends = {end: np.nan if v is None else v for end, v in fit["interval"][name].items()}
            row |= {name: fit[name], f"{name}_low": ends["low"], f"{name}_high": ends["high"]}
        row |= {
            "area_error_percent": np.mean(list(fit["area_error_percent"].values())),
            "area_of_study_percent": 100.0 * (fit["area_of_study_over_free"] - 1.0),
            "deviance_of_study": fit["deviance_of_study"],
            "active_bounds": "; ".join(fit["active_bounds"]),
            "mesh_area_error_percent": np.mean([runs[s]["area_error_percent"] for s in samples]),
            "mesh_modulus_percent": _largest(runs[s]["modulus_percent"] for s in samples),
            "mesh_curve_percent": max(runs[s]["against_calibrated_curve_percent"] for s in samples),
        }
        rows.append(row)
    return pd.DataFrame(rows)


def _largest(values: Any) -> float:
    return float(max(values, key=abs))


def common_table(common: Mapping[str, Mapping[str, float]]) -> pd.DataFrame:
    """Best exponents that groups share, and whether they do, by loading.

    Parameters
    ----------
    common
        `softsample.calibration.exponents.common_exponents` by loading (`all` is every group).
    """
    rows = [
        {
            "mode": mode,
            **found,
            "verdict": "constant" if found["p_value"] >= SIGNIFICANCE else "not constant",
        }
        for mode, found in common.items()
    ]
    return pd.DataFrame(rows)
