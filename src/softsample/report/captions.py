"""Numbers of the captions, as substitutions that reStructuredText fills in.

Every name is always defined, so that one set of captions serves studies of any make-up.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

MINUS = "−"

RECOVERY = (
    "The samples are a virtual cohort whose materials are the paper's moduli for real geometry: "
    "agreement with that column of the paper shows that known values are recovered, it does not "
    "confirm the paper. The idealised column and the bias are results of these made-up shapes"
)
OWN = "The samples are not those of the paper, whose values are therefore not shown beside them"


def caption_numbers(
    summary: pd.DataFrame,
    stress: pd.DataFrame,
    fits: Iterable[Mapping[str, Any]],
    elements: Sequence[int],
    cohort: str,
    shipped: bool,
    shown: str,
    samples: int,
) -> dict[str, str]:
    """Texts by name, each a phrase that fits into a sentence.

    Parameters
    ----------
    summary
        `softsample.report.tables.summary_table`.
    stress
        `softsample.report.stress.stress_strain_table`.
    fits
        Calibration results of all groups, geometries and models.
    elements
        Numbers of elements of the real and the idealised mesh of the sample `shown`.
    cohort, shipped
        What the samples are, and whether they are the shipped virtual ones.
    shown
        Sample of figure 2.
    samples
        Number of samples.
    """
    fits = list(fits)
    return {
        "cohort": cohort,
        "materials": RECOVERY if shipped else OWN,
        "samples": str(samples),
        "shown": shown,
        "elements_real": str(elements[0]),
        "elements_ideal": str(elements[1]),
        "bias_two_term": _means(summary, "modulus_two_term"),
        "bias_one_term": _means(summary, "modulus_one_term"),
        "top_area": _means(summary, "top_area"),
        "bottom_area": _means(summary, "bottom_area_absolute"),
        "stress_at_end": _stress_at_end(stress),
        "misfit_two_term": _misfit(fits, "ogden2"),
        "misfit_one_term": _misfit(fits, "ogden1"),
        "trust": _trust(fits),
    }


def substitutions(numbers: Mapping[str, str]) -> str:
    """Definitions `.. |name| replace:: text`, one a line; an id with `_` at its end is no link."""
    plain = {name: re.sub(r"_(?!\w)", r"\\_", text) for name, text in numbers.items()}
    return "".join(f".. |{name}| replace:: {text}\n" for name, text in plain.items())


def percent(value: float) -> str:
    """`value` with one decimal and a true minus sign."""
    return f"{value:.1f} %".replace("-", MINUS)


def _means(summary: pd.DataFrame, quantity: str) -> str:
    """Mean and deviation by mode, the paper's in brackets where there are any."""
    rows = summary[summary["quantity"] == quantity].to_dict("records")
    return "; ".join(_mean(row) for row in rows) or "no such sample in this study"


def _mean(row: Mapping[Any, Any]) -> str:
    mode = "all samples" if row["mode"] == "all" else row["mode"].replace("+", " with ")
    spread = f", SD {percent(row['sd_percent'])}" if np.isfinite(row["sd_percent"]) else ""
    text = f"{percent(row['mean_percent'])} in {mode} (n = {row['count']}{spread}"
    if np.isfinite(row["paper_mean_percent"]):
        mean, sd = (percent(row[f"paper_{name}_percent"]) for name in ("mean", "sd"))
        text += f"; paper {mean}, SD {sd}"
    return f"{text})"


def _stress_at_end(stress: pd.DataFrame) -> str:
    last = stress.groupby("mode", sort=False).last()
    return ", ".join(
        f"{1e-3 * row['mean_stress_pa']:.2f} kPa at strain {row['strain']:.2f} in {mode}"
        for mode, row in last.iterrows()
    )


def _misfit(fits: Sequence[Mapping[str, Any]], model: str) -> str:
    """Median and largest area between measured and modelled curves on both geometries."""
    phrases = []
    for geometry, name in (("real", "real"), ("ideal", "idealised")):
        errors = {
            sample: error
            for fit in fits
            if (fit["model"], fit["geometry"]) == (model, geometry)
            for sample, error in fit["area_error_percent"].items()
        }
        if errors:
            worst = max(errors, key=errors.__getitem__)
            median = percent(float(np.median(list(errors.values()))))
            phrases.append(
                f"{median} of the measured area on {name} geometry "
                f"(at most {percent(errors[worst])}, {worst})"
            )
    return " and ".join(phrases) or "no such fit in this study"


def _trust(fits: Sequence[Mapping[str, Any]]) -> str:
    doubtful = [
        f"{fit['group']} ({fit['model']}, {fit['geometry']} geometry: {fit['verdict']})"
        for fit in fits
        if not fit["success"]
    ]
    if doubtful:
        return f"Not to be trusted: {', '.join(doubtful)}"
    return f"All {len(fits)} calibrations converged, none on a bound"
