"""All numbers of a study in one document, for programs."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from softsample.report.page import with_interval
from softsample.wording import distrusted, significant

VERSION = 2
"""Of the form of the document; it grows when a reader of the last one could be misled."""

SIZES = (
    "diameter_mm", "length_mm", "width_mm", "height_mm", "highest_point_mm", "volume_real_mm3",
    "bottom_area_mm2", "top_area_mm2", "glued_area_mm2",
)  # fmt: skip
"""Of these a sample has what is known of it: without an image or a surface the ideal ones."""

RECORD = ("travel_mm", "ramp_speed_mm_s", "peak_force_N", "force_noise_N")

EFFECT = ("class", "parameters", "evidence", "separating_experiment")

BRIEF = (
    "group", "modulus to quote [Pa]", "calibrated [Pa]", "ideal shape [Pa]", "bias", "verdict",
)  # fmt: skip
"""Titles of what a run says last of each group."""

Report = Mapping[str, Any]


def study_results(
    samples: Mapping[str, Mapping[str, str]],
    found: Sequence[Report],
    cuboids: Sequence[Report],
    fits: Iterable[Report],
    intervals: pd.DataFrame,
    verdicts: Mapping[str, Report],
) -> dict[str, Any]:
    """The document `results.json`, which `workflow/schemas/results.schema.yaml` describes.

    Parameters
    ----------
    samples
        Rows of the table of samples by name.
    found, cuboids
        `inputs/` and `cuboid/{sample}.json`, in the order of `samples`.
    fits
        All calibrations, `calibration/{group}/{geometry}/{model}.json`.
    intervals
        `tables/intervals.csv`.
    verdicts
        `loop/{group}/verdict.json` by group.

    Returns
    -------
    dict
        Lengths [mm], forces [N], moduli [Pa]; None for what is not known.
    """
    groups: dict[str, Any] = {
        name: {"samples": [], "calibration": {}, "bias_percent": {}, "verdict": _verdict(verdict)}
        for name, verdict in verdicts.items()
    }
    for name, row in samples.items():
        groups[row["group"]]["samples"].append(name)
    for fit in fits:
        models = groups[fit["group"]]["calibration"].setdefault(fit["geometry"], {})
        models[fit["model"]] = _calibration(fit, intervals)
    for group in groups.values():
        real = group["calibration"].get("real", {})
        for model, ideal in group["calibration"]["ideal"].items():
            mu = [fit["moduli"]["mu"]["value_pa"] for fit in (real.get(model), ideal) if fit]
            bias = 100.0 * (mu[1] / mu[0] - 1.0) if len(mu) == 2 else None
            group["bias_percent"][model] = bias
    return {
        "version": VERSION,
        "samples": {
            name: {
                "group": row["group"],
                "mode": row["mode"],
                "geometry": {
                    "shape": cuboid.get("shape", "cuboid"),
                    **{key: cuboid[key] for key in SIZES if key in cuboid},
                },
                "record": {key: report["record"].get(key) for key in RECORD},
            }
            for (name, row), report, cuboid in zip(samples.items(), found, cuboids, strict=True)
        },
        "groups": groups,
    }


def _calibration(fit: Report, intervals: pd.DataFrame) -> dict[str, Any]:
    keys = ("group", "geometry", "model")
    chosen = (intervals[list(keys)] == [fit[key] for key in keys]).all(axis="columns")
    return {
        **{key: fit[key] for key in ("samples", "alpha", "poisson_ratio")},
        "moduli": {
            row["modulus"]: {
                key: None if pd.isna(row[key]) else row[key]
                for key in ("value_pa", "low_pa", "high_pa")
            }
            for row in intervals[chosen].to_dict("records")
        },
        "area_error_percent": fit["area_error_percent"],
        "trusted": fit["success"],
        "remark": fit["verdict"],
        "finding": fit.get("finding"),
    }


def _verdict(verdict: Report) -> dict[str, Any]:
    return {
        "verdict": verdict["verdict"],
        **{key: verdict[key] for key in ("overloaded_N", "extrapolated_mm")},
        "modulus_to_quote": {
            f"{key}_pa": verdict["recommended"]["mu"][key] for key in ("value", "low", "high")
        },
        "effects": [{key: effect[key] for key in EFFECT} for effect in verdict["effects"]],
        "error_before_percent": _errors(verdict["error_before"]),
        "error_after_percent": _errors(verdict["error_after"]),
    }


def _errors(errors: Report) -> dict[str, float]:
    """Root mean square of the whole record of each test, noise taken out [% of peak]."""
    return {mode: phases["all"]["rms_percent_structured"] for mode, phases in errors.items()}


Failures = Sequence[tuple[str, str]]
"""Name of each job that failed, with the reason."""


def words_of_success(
    results: str, document: Mapping[str, Any] | None, left_out: Sequence[str], failures: Failures
) -> str:
    """What a run says last: the moduli of `results.json` if it made that, and where to look.

    Samples that were left out and the failures follow.
    """
    report = Path(results, "report.html")
    end = [f"Done. Results are below {results}/ (tables, figures, checks)."]
    if document:
        where = f"All tables and figures: {report}" if report.is_file() else f"Results: {results}"
        end = [in_brief(document), where]
    if left_out:
        end.append(f"Left out: {', '.join(left_out)}")
    return "\n".join([*end, *_told(failures)])


def words_of_failure(failures: Failures) -> str:
    """What a run says last that did not come through."""
    if not failures:
        return "The run stopped before it was complete; run the same command again."
    first = "Some jobs failed; the others were finished where possible:"
    return "\n".join([first, *_told(failures)])


def _told(failures: Failures) -> list[str]:
    return [f"  {job}: {reason}" for job, reason in failures]


def in_brief(document: Mapping[str, Any]) -> str:
    """The moduli and the verdict of every group as a table of text, a line each; then findings.

    The modulus to quote is that of the verdict; the calibrated one that of the best geometry of the
    group: of the ideal shape, if its true shape is not known.
    """
    rows = [BRIEF, *(tuple(row.values()) for row in brief(document))]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]
    return "\n".join([*lines, *_findings(document["groups"])])


def brief(document: Mapping[str, Any]) -> list[dict[str, str]]:
    """What was found in each group, as text by the titles `BRIEF`, see `in_brief`."""
    groups = document["groups"].items()
    return [dict(zip(BRIEF, _line(*group), strict=True)) for group in groups]


def _line(name: str, group: Mapping[str, Any]) -> tuple[str, ...]:
    """A group's row of the table of `in_brief`."""
    moduli = {
        geometry: models["ogden2"]["moduli"]["mu"]
        for geometry, models in group["calibration"].items()
    }
    ideal, bias = moduli["ideal"], group["bias_percent"]["ogden2"]
    best = moduli.get("real", ideal)
    effects = ", ".join("|".join(e["class"]) for e in group["verdict"]["effects"])
    verdict = group["verdict"]["verdict"]
    return (
        name,
        _with_ends(group["verdict"]["modulus_to_quote"]),
        _with_ends(best),
        significant(ideal["value_pa"]),
        "not known" if bias is None else f"{bias:+.1f} %",
        f"{verdict}: {effects}" if effects else verdict,
    )


def _with_ends(modulus: Mapping[str, Any]) -> str:
    """A modulus, and its interval if that is known."""
    return with_interval(modulus["value_pa"], modulus["low_pa"], modulus["high_pa"])


def _findings(groups: Mapping[str, Any]) -> list[str]:
    """A line for each verdict that is not to be trusted, and each fit that has a finding."""
    warned = [
        f"{name}: {title.lower()}, {samples}"
        for name, group in groups.items()
        for title, (samples, _) in distrusted(group["verdict"]).items()
    ]
    return warned + [
        f"{name}, {geometry} geometry, {model}: {fit['finding']}"
        for name, group in groups.items()
        for geometry, models in group["calibration"].items()
        for model, fit in models.items()
        if fit["finding"]
    ]
