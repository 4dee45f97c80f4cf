"""Intervals of the calibrated moduli, and the terms that they are made of.

Every term is a standard deviation. `statistics` is the scatter of the record; the others say how
wrong the modelled force may be, sample by sample, and reach the modulus through what the
calibration makes of a percent more force. Limits that a value surely keeps, without one being
likelier than another, count as a rectangular distribution, half-width / sqrt(3)
(Guide to the Expression of Uncertainty in Measurement, JCGM 100:2008, 4.3.7).
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import ndtri

from softsample.response.bond import log_force
from softsample.response.floor import FloorSettings, rectangular
from softsample.response.sensitivity import COARSE, STIFFER
from softsample.response.unit import CLOSED_FORM

MEASURED = ("statistics", "geometry", "contact_zero", "time", "bond")
"""Terms of record, image, loading time and bonded area."""

FLOOR = ("mesh", "hourglass", "element")
"""Terms that the choice of mesh and element leaves open."""

ADD_UP = (*FLOOR, "bond")
"""Terms that are wrong in the same sense in all samples, so that their forces keep the sign."""

LARGEST = "mu at its maximum"
"""Bound on which a calibration ends whose modulus may be larger."""


def force_terms(
    mode: str,
    band: Mapping[str, Any] | None,
    bond: Mapping[str, Any] | None,
    changes: Mapping[str, Mapping[str, float]],
    curves: Mapping[str, Any],
    element_size_mm: float,
    settings: FloorSettings,
) -> dict[str, float]:
    """Standard deviations of a piece's modelled force [%], by term; signed, those of `ADD_UP`.

    Parameters
    ----------
    band : mapping or None
        `band/{sample}.json`: the surface one standard deviation further in and out; None where no
        image says how well it is known: the term is NaN.
    bond : mapping or None
        `bond/{sample}.json` of a bonded real geometry, else None: the term is zero. The modulus
        may be as far off as with the other rule of the bond, either way.
    changes : mapping
        `changes` of `sensitivity/{sample}/{geometry}.json`, on the best geometry there is:
        `modulus_percent` by numerical choice.
    curves : mapping
        `curves/{sample}/{geometry}/{model}.json`: `error_bound_percent`, from two loading times.
        A closed form has no error of loading time, mesh or element.
    element_size_mm : float
        Of the piece's mesh; the sensitivity has elements of twice this size.
    """
    geometry = np.nan if band is None else 0.5 * (band["high_percent"] - band["low_percent"])
    if curves.get("method") == CLOSED_FORM:
        return {"geometry": geometry, **dict.fromkeys(("time", "bond", *FLOOR), 0.0)}
    richardson = changes[COARSE]["modulus_percent"] / (2.0**settings.mesh_order - 1.0)
    return {
        "geometry": geometry,
        "time": rectangular(curves["error_bound_percent"]),
        "bond": rectangular(100.0 * log_force(bond)) if bond else 0.0,
        "mesh": rectangular(richardson),
        "hourglass": rectangular(changes[STIFFER]["modulus_percent"]),
        "element": rectangular(settings.element(mode, element_size_mm)),
    }


def interval_rows(
    fit: Mapping[str, Any], forces: Mapping[str, Mapping[str, float]], piece_of: Mapping[str, str]
) -> list[dict[str, Any]]:
    """One row for each modulus of a fit.

    Parameters
    ----------
    fit : mapping
        `calibration/{group}/{geometry}/{model}.json`.
    forces : mapping
        `force_terms` by piece. What those of `ADD_UP` do to the modulus adds up over the pieces,
        other errors of different pieces are independent.
    piece_of : mapping
        Piece by sample; its records share the errors of its model.

    Returns
    -------
    list of dict
        Value [Pa], standard deviation of every term [% of it], limits [Pa] of the interval of all
        terms (`low_pa`, `high_pa`), without the floor, and without the bond. A term that is known
        of no piece is NaN, and not in the interval; so are upper limits where the calibration
        ended at the largest modulus that it may have.
    """
    given, rows = fit["uncertainty"], []
    open_above = LARGEST in fit["active_bounds"]
    z = float(ndtri(0.5 + 0.5 * given["confidence"]))
    for name in ("mu",) if fit["model"] == "ogden1" else ("mu", "mu1", "mu2"):
        key = f"{name}_pa"
        per_percent = dict.fromkeys(map(piece_of.__getitem__, given["per_percent_of_force"]), 0.0)
        for sample, change in given["per_percent_of_force"].items():
            per_percent[piece_of[sample]] += change[key]
        shifts = [change[key] for change in given["contact_zero"].values()]
        terms = {
            "statistics": given["bootstrap"][key]["sd"],
            "contact_zero": float(np.linalg.norm(shifts)),
        }
        for term in ("geometry", "time", "bond", *FLOOR):
            parts = [change * forces[piece][term] for piece, change in per_percent.items()]
            terms[term] = abs(sum(parts)) if term in ADD_UP else _norm(parts)
        value = fit[key]
        half = {
            f"without_{name}_": z * _norm([sd for term, sd in terms.items() if term not in left])
            for name, left in (("floor", FLOOR), ("bond", ("bond",)))
        }
        half[""] = z * _norm([*terms.values()])
        rows.append(
            {
                **{column: fit[column] for column in ("group", "geometry", "model")},
                "modulus": name,
                "value_pa": value,
                **{f"low_{which}pa": max(value - part, 0.0) for which, part in half.items()},
                **{
                    f"high_{which}pa": np.nan if open_above else value + part
                    for which, part in half.items()
                },
                **{f"{term}_percent": _percent(terms[term], value) for term in MEASURED + FLOOR},
            }
        )
    return rows


def _percent(part: float, value: float) -> float:
    """Part in percent of a modulus; NaN of a modulus at its bound 0, which has no percent."""
    return 100.0 * part / value if value > 0.0 else float("nan")


def _norm(parts: Sequence[float]) -> float:
    """Root of the sum of squares of the parts that are known; NaN if none is."""
    known = [part for part in parts if not np.isnan(part)]
    return float(np.linalg.norm(known)) if known else float("nan")


def interval_table(
    fits: Sequence[Mapping[str, Any]],
    forces: Mapping[tuple[str, str, str], Mapping[str, float]],
    piece_of: Mapping[str, str],
) -> pd.DataFrame:
    """Intervals of all moduli of all fits; `forces` by piece, geometry and model."""
    rows = []
    for fit in fits:
        pieces = {piece_of[sample] for sample in fit["samples"]}
        of_fit = {piece: forces[piece, fit["geometry"], fit["model"]] for piece in pieces}
        rows += interval_rows(fit, of_fit, piece_of)
    return pd.DataFrame(rows)
