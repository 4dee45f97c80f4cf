"""Intervals of the calibrated moduli, and the terms that they are made of.

Every term is a standard deviation. `statistics` is the scatter of the record; the others say how
wrong the modelled force may be, sample by sample, and reach the modulus through what the
calibration makes of a percent more force. Limits that a value surely keeps, without one being
likelier than another, count as a rectangular distribution, half-width / sqrt(3)
(Guide to the Expression of Uncertainty in Measurement, JCGM 100:2008, 4.3.7).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import ndtri

MEASURED = ("statistics", "geometry", "contact_zero", "time")
"""Terms of record, image and loading time."""

FLOOR = ("mesh", "hourglass", "element")
"""Terms that the choice of mesh and element leaves open: it is wrong in the same sense in all
samples, so that their forces keep the sign."""

COARSE = "elements of twice the size"
HOURGLASS = ("half the hourglass stiffness", "twice the hourglass stiffness")


@dataclass(frozen=True)
class FloorSettings:
    """What mesh and element type leave open; mirrors config `floor:`.

    Parameters
    ----------
    mesh_order : float
        Order with which the error of the mesh is taken to fall with the element size.
    element_size_mm : sequence of float
        Element sizes [mm], ascending, at which `element_percent` was measured.
    element_percent : mapping
        By mode, difference of one-point and three-field hexahedra [% of force] at these sizes.
    """

    mesh_order: float
    element_size_mm: Sequence[float]
    element_percent: Mapping[str, Sequence[float]]


def rectangular(half_width: float) -> float:
    """Standard deviation of a value that lies anywhere within limits; keeps the limit's sign."""
    return half_width / float(np.sqrt(3.0))


def force_terms(
    mode: str,
    band: Mapping[str, Any],
    changes: Mapping[str, Mapping[str, float]],
    error_bound_percent: float,
    element_size_mm: float,
    settings: FloorSettings,
) -> dict[str, float]:
    """Standard deviations of a sample's modelled force [%], by term; signed, those of the floor.

    Parameters
    ----------
    mode : str
        Loading mode.
    band : mapping
        `band/{sample}.json`: the surface one standard deviation further in and out.
    changes : mapping
        `sensitivity/{sample}/real.json`, `changes`: `modulus_percent` by numerical choice.
    error_bound_percent : float
        Of the curve, from two loading times.
    element_size_mm : float
        Of the study; the sensitivity has elements of twice this size.
    settings : FloorSettings
        Floor of mesh and element.
    """
    softer, stiffer = (changes[name]["modulus_percent"] for name in HOURGLASS)
    richardson = changes[COARSE]["modulus_percent"] / (2.0**settings.mesh_order - 1.0)
    element = np.interp(
        np.log(element_size_mm),
        np.log(settings.element_size_mm),
        settings.element_percent[mode],
    )
    return {
        "geometry": 0.5 * (band["high_percent"] - band["low_percent"]),
        "time": rectangular(error_bound_percent),
        "mesh": rectangular(richardson),
        "hourglass": rectangular(max(-softer, stiffer, key=abs)),
        "element": rectangular(float(element)),
    }


def interval_rows(
    fit: Mapping[str, Any], forces: Mapping[str, Mapping[str, float]]
) -> list[dict[str, Any]]:
    """One row for each modulus of a fit.

    Parameters
    ----------
    fit : mapping
        `calibration/{group}/{geometry}/{model}.json`.
    forces : mapping
        `force_terms` by sample. What the floor's do to the modulus adds up over the samples, other
        errors of different samples are independent.

    Returns
    -------
    list of dict
        Value [Pa], standard deviation of every term [% of it], limits [Pa] of the interval with
        (`low_pa`, `high_pa`) and without the floor.
    """
    given, rows = fit["uncertainty"], []
    z = float(ndtri(0.5 + 0.5 * given["confidence"]))
    for name in ("mu",) if fit["model"] == "ogden1" else ("mu", "mu1", "mu2"):
        key = f"{name}_pa"
        per_percent = {s: change[key] for s, change in given["per_percent_of_force"].items()}
        shifts = [change[key] for change in given["contact_zero"].values()]
        terms = {
            "statistics": given["bootstrap"][key]["sd"],
            "contact_zero": float(np.linalg.norm(shifts)),
        }
        for term in ("geometry", "time", *FLOOR):
            parts = [change * forces[s][term] for s, change in per_percent.items()]
            terms[term] = abs(sum(parts)) if term in FLOOR else float(np.linalg.norm(parts))
        without = z * float(np.linalg.norm([terms[term] for term in MEASURED]))
        half = float(np.hypot(without, z * np.linalg.norm([terms[term] for term in FLOOR])))
        value = fit[key]
        rows.append(
            {
                **{column: fit[column] for column in ("group", "geometry", "model")},
                "modulus": name,
                "value_pa": value,
                "low_pa": value - half,
                "high_pa": value + half,
                "low_without_floor_pa": value - without,
                "high_without_floor_pa": value + without,
                **{f"{term}_percent": 100.0 * terms[term] / value for term in MEASURED + FLOOR},
            }
        )
    return rows


def interval_table(
    fits: Sequence[Mapping[str, Any]],
    forces: Mapping[tuple[str, str, str], Mapping[str, float]],
) -> pd.DataFrame:
    """Intervals of all moduli of all fits; `forces` by sample, geometry and model."""
    rows = [
        row
        for fit in fits
        for row in interval_rows(
            fit, {s: forces[s, fit["geometry"], fit["model"]] for s in fit["samples"]}
        )
    ]
    return pd.DataFrame(rows)
