"""Numbers of the captions, as substitutions that reStructuredText fills in.

Every name is always defined, so that one set of captions serves studies of any make-up.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from softsample.report.page import fixed
from softsample.report.tables import doubt_of
from softsample.wording import spoken

RECOVERY = (
    "The samples are a virtual cohort whose materials are the paper's moduli for real geometry: "
    "agreement with that column of the paper shows that known values are recovered, it does not "
    "confirm the paper. The idealised column and the bias are results of these synthetic shapes"
)
UNKNOWN = "not known without an image or a surface of all samples of a group"
WHOLE, PART = "", ", where the shapes of all samples of a group are known,"
NONE_HERE = "no such sample in this study"
OWN = "The samples are not those of the paper, whose values are therefore not shown beside them"


@dataclass(frozen=True)
class CaptionedStudy:
    """What captions say of a study before anything is computed.

    Parameters
    ----------
    cohort, shipped
        What the samples are, and whether they are the shipped virtual ones.
    shown, geometries
        Sample of figure 2, and its geometries.
    samples, imaged, surfaces
        Number of samples, and of those with an image and with a surface.
    ideal
        What samples are idealised as: `cuboid`, `cylinder`, or both.
    """

    cohort: str
    shipped: bool
    shown: str
    geometries: Sequence[str]
    samples: int
    imaged: int
    surfaces: int
    ideal: str


def caption_numbers(
    study: CaptionedStudy,
    summary: pd.DataFrame,
    stress: pd.DataFrame,
    fits: Sequence[Mapping[str, Any]],
    meshes: Sequence[Mapping[str, Any]],
) -> dict[str, str]:
    """Texts by name, each a phrase that fits into a sentence.

    Parameters
    ----------
    study
        Where they stand.
    summary
        `softsample.report.tables.summary_table`.
    stress
        `softsample.report.stress.stress_strain_table`.
    fits
        Calibration results of all groups, geometries and models.
    meshes
        Quality reports of the meshes of the sample shown, one for each of its geometries.
    """
    of_meshes = zip(study.geometries, meshes, strict=True)
    elements = {name: str(mesh["elements"]) for name, mesh in of_meshes}
    groups = {fit["group"] for fit in fits}
    real = {fit["group"] for fit in fits if fit["geometry"] == "real"}
    where, missing = WHOLE if real == groups else PART, NONE_HERE if real else UNKNOWN
    return {
        "cohort": study.cohort,
        "materials": RECOVERY if study.shipped else OWN,
        "samples": str(study.samples),
        "shown": study.shown,
        "ideal": study.ideal,
        "modelled": _modelled(study, where) if real else _idealised(study),
        **_seen(study.ideal, where, bool(real)),
        "elements_real": elements.get("real", "no"),
        "elements_ideal": elements["ideal"],
        "bias_two_term": _means(summary, "modulus_two_term", missing),
        "bias_one_term": _means(summary, "modulus_one_term", missing),
        "top_area": _means(summary, "top_area", missing),
        "bottom_area": _means(summary, "bottom_area_absolute", missing),
        "stress_at_end": _stress_at_end(stress),
        "misfit_two_term": _misfit(fits, "ogden2"),
        "misfit_one_term": _misfit(fits, "ogden1"),
        "trust": _trust(fits),
    }


def _modelled(study: CaptionedStudy, where: str) -> str:
    """How shapes were found and modelled, if some are known: the middle of a sentence."""
    if study.imaged == study.samples:
        return f"segmented in their images, meshed as they are{where} and as a {study.ideal}"
    kinds = (f"{study.imaged} with an image", f"{study.surfaces} with a surface")
    there = " and ".join(kind for kind in kinds if kind[0] != "0")
    stated = study.samples - study.imaged - study.surfaces
    return f"meshed as they are ({there}){where} and as a {study.ideal}" + (
        f" ({stated} by the stated dimensions alone)" if stated else ""
    )


def _idealised(study: CaptionedStudy) -> str:
    """The same where no group has a real geometry."""
    known = study.imaged + study.surfaces
    size, of_all = ("", " of all its samples") if known else (" of the stated dimensions", "")
    return (
        f"meshed as a {study.ideal}{size} (no group has an image or a surface{of_all}, so that "
        "the bias by the idealised geometry is not known)"
    )


def _seen(ideal: str, where: str, real: bool) -> dict[str, str]:
    """What figures and tables show of the geometries that there are."""
    strain = "argest principal Hencky strain at the end of the loading ramp on the"
    if not real:
        return {
            "geometries": f"on the idealised {ideal}",
            "lines": f"dashed: model on the idealised {ideal}",
            "bars": f"on the idealised {ideal}, with intervals",
            "strain": f"L{strain} idealised {ideal}",
        }
    return {
        "geometries": f"on the real geometry{where} and on the idealised {ideal}",
        "lines": "solid: model on the real geometry; dashed, thinner and darker: on the idealised "
        f"{ideal}",
        "bars": "real (plain) and idealised (hatched), with intervals; above them its difference, "
        "ideal to real",
        "strain": f"First the surface before the test, then l{strain} real "
        f"geometry{where.rstrip(',')}; last, that on the idealised {ideal}",
    }


def substitutions(numbers: Mapping[str, str]) -> str:
    """Definitions `.. |name| replace:: text`, one a line; an id with `_` at its end is no link."""
    plain = {name: re.sub(r"_(?!\w)", r"\\_", text) for name, text in numbers.items()}
    return "".join(f".. |{name}| replace:: {text}\n" for name, text in plain.items())


def percent(value: float) -> str:
    """`value` with one decimal and a true minus sign."""
    return f"{fixed(value)} %"


def _means(summary: pd.DataFrame, quantity: str, missing: str) -> str:
    """Mean and deviation by mode, the paper's in brackets where there are any."""
    rows = summary[summary["quantity"] == quantity].to_dict("records")
    return "; ".join(_mean(row) for row in rows) or missing


def _mean(row: Mapping[Any, Any]) -> str:
    mode = "all samples" if row["mode"] == "all" else spoken(row["mode"])
    spread = f", SD {percent(row['sd_percent'])}" if np.isfinite(row["sd_percent"]) else ""
    text = f"{percent(row['mean_percent'])} in {mode} (n = {row['count']}{spread}"
    if np.isfinite(row["paper_mean_percent"]):
        mean, sd = (percent(row[f"paper_{name}_percent"]) for name in ("mean", "sd"))
        text += f"; paper {mean}, SD {sd}"
    return f"{text})"


def _stress_at_end(stress: pd.DataFrame) -> str:
    last = stress.groupby("mode", sort=False).last().rename(index=spoken)
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
    """Fits on a bound, which are findings, and fits that did not converge."""
    named = [
        f"{fit['group']} ({fit['model']}, {fit['geometry']} geometry: {doubt})"
        for fit in fits
        if (doubt := doubt_of(fit))
    ]
    if named:
        return f"Of {len(fits)} calibrations, to be read with care: {', '.join(named)}"
    return f"All {len(fits)} calibrations converged, none on a bound"
