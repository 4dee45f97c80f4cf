"""Results of a virtual cohort against the sealed truth it was made with.

Only the target `score` comes here; no stage of the study reads a truth file.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

Truth = Mapping[str, Any]


def percent(value: float, truth: float) -> float:
    """Signed difference of a value from the truth [%]."""
    return 100.0 * (value / truth - 1.0)


def score_table(
    truths: Mapping[str, Truth],
    cuboids: Mapping[str, Mapping[str, Any]],
    groups: Mapping[str, Sequence[str]],
    fits: Mapping[tuple[str, str], Mapping[str, Any]],
    intervals: pd.DataFrame,
) -> pd.DataFrame:
    """One row a sample: geometry and modulus against the truth.

    Parameters
    ----------
    truths, cuboids
        Truth and measured geometry by sample.
    groups
        Samples of each group.
    fits
        Two-term calibration by group and geometry.
    intervals
        `softsample.report.intervals.interval_table`; the ones of mu on the real geometry count.
    """
    ends = _interval_ends(intervals)
    rows = []
    for group, samples in groups.items():
        for sample in samples:
            shape = truths[sample]["shape"]["statistics"]
            material, measured = truths[sample]["material"], cuboids[sample]
            mu = material["mu1_Pa"] + material["mu2_Pa"]
            rows.append(
                {
                    "sample": sample,
                    "group": group,
                    "volume_error_percent": percent(
                        measured["volume_real_mm3"], shape["volume_mm3"]
                    ),
                    "length_error_mm": measured["length_mm"] - shape["L_mm"],
                    "width_error_mm": measured["width_mm"] - shape["W_mm"],
                    "height_error_mm": measured["height_mm"] - shape["H_mm"],
                    "bottom_area_error_percent": percent(
                        measured["bottom_area_mm2"], shape["bottom_area_mm2"]
                    ),
                    "top_area_error_percent": percent(
                        measured["top_area_mm2"], shape["top_area_mm2"]
                    ),
                    "mu_true_pa": mu,
                    "mu1_true_pa": material["mu1_Pa"],
                    "mu_real_pa": fits[group, "real"]["mu_pa"],
                    "mu1_real_pa": fits[group, "real"]["mu1_pa"],
                    "mu_ideal_pa": fits[group, "ideal"]["mu_pa"],
                    "mu_real_error_percent": percent(fits[group, "real"]["mu_pa"], mu),
                    **{
                        f"inside{which}": low <= mu <= high
                        for which, (low, high) in ends[group].items()
                    },
                    "bias_percent": percent(
                        fits[group, "ideal"]["mu_pa"], fits[group, "real"]["mu_pa"]
                    ),
                }
            )
    return pd.DataFrame(rows)


def _interval_ends(intervals: pd.DataFrame) -> dict[str, dict[str, tuple[float, float]]]:
    """By group, limits [Pa] of mu on the real geometry with (key "") and without the floor."""
    chosen = {"geometry": "real", "model": "ogden2", "modulus": "mu"}
    rows = intervals[(intervals[list(chosen)] == list(chosen.values())).all(axis=1)]
    return {
        row["group"]: {
            which: (row[f"low{which}_pa"], row[f"high{which}_pa"])
            for which in ("", "_without_floor")
        }
        for row in rows.to_dict("records")
    }


def score_summary(table: pd.DataFrame) -> dict[str, Any]:
    """Medians and worst cases of a score table."""
    groups = table.drop_duplicates("group").set_index("group")
    error = groups["mu_real_error_percent"].abs()
    return {
        "samples": len(table),
        "groups": len(groups),
        "volume_error_percent_worst": float(table["volume_error_percent"].abs().max()),
        "mu_error_percent_median": float(np.median(error)),
        "mu_error_percent_worst": float(error.max()),
        "worst_group": str(error.idxmax()),
        "groups_inside_interval": int(groups["inside"].sum()),
        "groups_inside_interval_without_floor": int(groups["inside_without_floor"].sum()),
        "groups_biased_low": int((groups["bias_percent"] < 0).sum()),
    }
