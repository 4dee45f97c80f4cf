"""Results of a virtual cohort against the sealed truth it was made with.

Only the target `score` comes here; no stage of the study reads a truth file.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import pandas as pd

from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.slsqp import CalibrationSettings, fit_ogden
from softsample.record_noise import white_noise
from softsample.records import Record
from softsample.response.curves import ResponseCurves
from softsample.response.sensitivity import COARSE

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
    recommended: Mapping[str, Mapping[str, float]],
) -> pd.DataFrame:
    """One row a sample: geometry and moduli against the truth.

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
    recommended
        By group, `value`, `low` and `high` [Pa] of the modulus to quote on the real geometry.
    """
    ends = _interval_ends(intervals)
    rows = []
    for group, samples in groups.items():
        real, ideal, quoted = fits[group, "real"], fits[group, "ideal"], recommended[group]
        for sample in samples:
            material = truths[sample]["material"]
            mu = material["mu1_Pa"] + material["mu2_Pa"]
            rows.append(
                {
                    "sample": sample,
                    "group": group,
                    **_shape_errors(truths[sample]["shape"]["statistics"], cuboids[sample]),
                    "mu_true_pa": mu,
                    "mu1_true_pa": material["mu1_Pa"],
                    "mu_real_pa": real["mu_pa"],
                    "mu1_real_pa": real["mu1_pa"],
                    "mu_ideal_pa": ideal["mu_pa"],
                    "mu_real_error_percent": percent(real["mu_pa"], mu),
                    **{
                        f"inside{which}": low <= mu <= high
                        for which, (low, high) in ends[group].items()
                    },
                    "mu_recommended_pa": quoted["value"],
                    "mu_recommended_error_percent": percent(quoted["value"], mu),
                    "recommended_low_pa": quoted["low"],
                    "recommended_high_pa": quoted["high"],
                    "inside_recommended": quoted["low"] <= mu <= quoted["high"],
                    "bias_percent": percent(ideal["mu_pa"], real["mu_pa"]),
                }
            )
    return pd.DataFrame(rows)


def _shape_errors(true: Truth, measured: Mapping[str, Any]) -> dict[str, float]:
    return {
        "volume_error_percent": percent(measured["volume_real_mm3"], true["volume_mm3"]),
        "length_error_mm": measured["length_mm"] - true["L_mm"],
        "width_error_mm": measured["width_mm"] - true["W_mm"],
        "height_error_mm": measured["height_mm"] - true["H_mm"],
        **{
            f"{face}_area_error_percent": percent(
                measured[f"{face}_area_mm2"], true[f"{face}_area_mm2"]
            )
            for face in ("bottom", "top")
        },
    }


def _interval_ends(intervals: pd.DataFrame) -> dict[str, dict[str, tuple[float, float]]]:
    """By group, limits [Pa] of mu on the real geometry: all terms (key ""), and without some."""
    chosen = {"geometry": "real", "model": "ogden2", "modulus": "mu"}
    rows = intervals[(intervals[list(chosen)] == list(chosen.values())).all(axis=1)]
    return {
        row["group"]: {
            which: (row[f"low{which}_pa"], row[f"high{which}_pa"])
            for which in ("", "_without_floor", "_without_bond")
        }
        for row in rows.to_dict("records")
    }


def score_summary(table: pd.DataFrame) -> dict[str, Any]:
    """Medians and worst cases of a score table."""
    groups = table.drop_duplicates("group").set_index("group")
    error = groups["mu_real_error_percent"].abs()
    quoted = groups["mu_recommended_error_percent"].abs()
    return {
        "samples": len(table),
        "groups": len(groups),
        "volume_error_percent_worst": float(table["volume_error_percent"].abs().max()),
        "mu_error_percent_median": float(np.median(error)),
        "mu_error_percent_worst": float(error.max()),
        "worst_group": str(error.idxmax()),
        "groups_inside_interval": int(groups["inside"].sum()),
        "groups_inside_interval_without_floor": int(groups["inside_without_floor"].sum()),
        "groups_inside_interval_without_bond": int(groups["inside_without_bond"].sum()),
        "recommended_error_percent_median": float(np.median(quoted)),
        "recommended_error_percent_worst": float(quoted.max()),
        "groups_inside_recommended": int(groups["inside_recommended"].sum()),
        "groups_biased_low": int((groups["bias_percent"] < 0).sum()),
    }


def contact_zero_error(truth: Truth, cuboid: Mapping[str, Any]) -> float:
    """How far above the true start of the platen ours is in compression [m].

    The platen of the truth started at the highest node of its own mesh.
    """
    return 1e-3 * float(cuboid["highest_point_mm"] - truth["mesh"]["highest_point_mm"])


def against_truth_mesh(truth: Truth, cuboid: Mapping[str, Any]) -> dict[str, float]:
    """Our volume and glued area over those of the mesh that the record was made with [%].

    Elements of 1 mm cut ridges and edges, and that mesh is glued by whole faces only; ours are the
    volume and the area of the surface.
    """
    mesh = truth["mesh"]
    glued = truth["mode"] != "compression"
    return {
        "mesh_volume_percent": percent(cuboid["volume_real_mm3"], mesh["volume_mm3"]),
        "mesh_glued_percent": percent(
            cuboid["glued_area_mm2"], mesh["glued_top_area_projected_mm2"]
        )
        if glued
        else float("nan"),
    }


def contact_zero_part(
    families: Mapping[str, ResponseCurves],
    measured: Mapping[str, MeasuredCurve],
    errors: Mapping[str, float],
    mu: float,
    settings: CalibrationSettings,
) -> float:
    """Part of a group's modulus that is due to misplaced starts of the platen [%].

    Parameters
    ----------
    families, measured
        Curves on the real geometry and records by sample.
    errors
        `contact_zero_error` [m] of the compression samples.
    mu
        The modulus as it was calibrated [Pa].
    settings
        Of the calibration, which is run again with the platen at its true start.
    """
    started = {
        sample: MeasuredCurve(curve.displacement + errors.get(sample, 0.0), curve.force)
        for sample, curve in measured.items()
    }
    return percent(mu, fit_ogden(families, started, settings).mu)


def noise_part(curve: MeasuredCurve) -> float:
    """Standard deviation of a modulus by the white noise of the force [%].

    A factor on the force is known to the noise over the norm of the force.
    """
    sigma, _ = white_noise(np.arange(len(curve.force), dtype=float), curve.force)
    return 100.0 * float(sigma / np.linalg.norm(curve.force))


@dataclass(frozen=True, eq=False)
class CohortSample:
    """A sample of a virtual cohort.

    Parameters
    ----------
    name, mode : str
    truth, cuboid : mapping
        What its record was made with, and `cuboid/{sample}.json`.
    family : ResponseCurves
        On the real geometry.
    measured : MeasuredCurve
    """

    name: str
    mode: str
    truth: Truth
    cuboid: Mapping[str, Any]
    family: ResponseCurves
    measured: MeasuredCurve

    @classmethod
    def of(
        cls,
        name: str,
        mode: str,
        truth: Truth,
        cuboid: Mapping[str, Any],
        curves: pd.DataFrame,
        record: Record,
    ) -> Self:
        """From what the files of a sample hold."""
        family = ResponseCurves.of_table(curves, mode)
        return cls(name, mode, truth, cuboid, family, MeasuredCurve.of_record(record, mode))


def recovery(
    samples: Sequence[CohortSample],
    groups: Mapping[str, Sequence[str]],
    moduli: Mapping[str, float],
    settings: CalibrationSettings,
    score: pd.DataFrame,
    sensitivity: pd.DataFrame,
    band: pd.DataFrame,
) -> pd.DataFrame:
    """`recovery_table` of a cohort.

    Parameters
    ----------
    samples : sequence of CohortSample
    groups, moduli : mapping
        Samples, and modulus on the real geometry [Pa], by group.
    settings : CalibrationSettings
    score, sensitivity, band
        As of `recovery_table`.
    """
    pressed = [s for s in samples if s.mode == "compression"]
    starts = {s.name: contact_zero_error(s.truth, s.cuboid) for s in pressed}
    own = {s.name: s for s in samples}
    parts = {
        group: contact_zero_part(
            {name: own[name].family for name in members},
            {name: own[name].measured for name in members},
            starts,
            moduli[group],
            settings,
        )
        for group, members in groups.items()
    }
    return recovery_table(
        score,
        parts,
        {name: 1e3 * start for name, start in starts.items()},
        {s.name: noise_part(s.measured) for s in samples},
        {s.name: against_truth_mesh(s.truth, s.cuboid) for s in samples},
        sensitivity,
        band,
    )


def recovery_table(
    score: pd.DataFrame,
    contact_zero: Mapping[str, float],
    starts_mm: Mapping[str, float],
    noise: Mapping[str, float],
    meshes: Mapping[str, Mapping[str, float]],
    sensitivity: pd.DataFrame,
    band: pd.DataFrame,
) -> pd.DataFrame:
    """Error of the modulus on the real geometry beside what can cause it, one row a sample.

    Parameters
    ----------
    score
        `score_table`.
    contact_zero, starts_mm, noise, meshes
        `contact_zero_part` by group; `contact_zero_error` [mm], `noise_part` and
        `against_truth_mesh` by sample.
    sensitivity, band
        Tables of the study (`tables/sensitivity.csv`, `tables/band.csv`).

    Returns
    -------
    DataFrame
        `sample`, `group`, `mu_true_pa`, `mu_real_pa`, `error_percent`; `contact_zero_mm`,
        `contact_zero_percent`; `twice_the_size_percent`: force at the end with elements of twice
        the size; `band_low_percent`, `band_high_percent`: modulus on the boundary's one-sigma band;
        `volume_error_percent`; `mesh_volume_percent` and `mesh_glued_percent`, of
        `against_truth_mesh`; `noise_percent`; `rest_percent`: error without the contact zero.
    """
    mesh = sensitivity[sensitivity["change"] == COARSE]
    coarse = mesh.set_index("sample")["end_force_percent"]
    bounds = band.set_index("sample")
    table = pd.DataFrame(
        {
            "sample": score["sample"],
            "group": score["group"],
            "mu_true_pa": score["mu_true_pa"],
            "mu_real_pa": score["mu_real_pa"],
            "error_percent": score["mu_real_error_percent"],
            "contact_zero_mm": score["sample"].map(starts_mm),
            "contact_zero_percent": score["group"].map(contact_zero),
            "twice_the_size_percent": score["sample"].map(coarse),
            "band_low_percent": score["sample"].map(bounds["low_percent"]),
            "band_high_percent": score["sample"].map(bounds["high_percent"]),
            "volume_error_percent": score["volume_error_percent"],
            "noise_percent": score["sample"].map(noise),
        }
    ).merge(pd.DataFrame(meshes).T, left_on="sample", right_index=True)
    factor = (1.0 + table["error_percent"] / 100.0) / (1.0 + table["contact_zero_percent"] / 100.0)
    return table.assign(rest_percent=100.0 * (factor - 1.0))


def verdict_score(
    verdicts: Mapping[str, Mapping[str, Any]], truths: Mapping[str, Truth]
) -> pd.DataFrame:
    """Verdicts on records with undeclared effects against the sealed truth, one row a group.

    Parameters
    ----------
    verdicts : mapping
        `loop/{group}/verdict.json` by group.
    truths : mapping
        `truth/{group}.json` by group: under `effects`, each with `right`, the names that count.

    Returns
    -------
    DataFrame
        `group`, `truth`, `verdict`, `named` (classes); `right`: a class names each true effect, or
        `none` where there is none; `one_right`: a class names one at least; `wrong`: classes that
        name no true effect; `held_out_removed_percent`: of the structured held-out error;
        `mu_error_before_percent`, `mu_error_after_percent` against the true modulus.
    """
    rows = []
    for group, verdict in verdicts.items():
        rights = [set(effect["right"]) for effect in truths[group]["effects"]]
        classes = [set(effect["class"]) for effect in verdict["effects"]]
        hits = [any(right & named for named in classes) for right in rights]
        mu = truths[group]["material"]["mu1_Pa"] + truths[group]["material"]["mu2_Pa"]
        rows.append(
            {
                "group": group,
                "truth": "; ".join(effect["name"] for effect in truths[group]["effects"]),
                "verdict": verdict["verdict"],
                "named": "; ".join("|".join(effect["class"]) for effect in verdict["effects"]),
                "right": all(hits) if rights else verdict["verdict"] == "none",
                "one_right": any(hits) if rights else verdict["verdict"] == "none",
                "wrong": sum(not any(right & named for right in rights) for named in classes),
                "held_out_removed_percent": _held_out_removed(verdict),
                **{
                    f"mu_error_{when}_percent": percent(verdict[f"theta_{when}"]["mu"]["value"], mu)
                    for when in ("before", "after")
                },
            }
        )
    return pd.DataFrame(rows)


def _held_out_removed(verdict: Mapping[str, Any]) -> float:
    """Part of the structured held-out error that the found effects take away, median [%]."""
    parts = [
        100.0 * (1.0 - after["rms_N_structured"] / before["rms_N_structured"])
        for fold, tests in verdict["held_out_before"].items()
        for before, after in zip(
            tests.values(), verdict["held_out_after"][fold].values(), strict=True
        )
        if before["rms_N_structured"] > 0.0
    ]
    return float(np.median(parts)) if parts else float("nan")
