"""Bias of the modulus by idealisation when sample or cuboid are changed, and its parts."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.slsqp import CalibrationSettings, fit_ogden
from softsample.response.curves import ResponseCurves

Families = Mapping[str, ResponseCurves]

BASE = ("real", "cuboid")
"""Sample and model of the plain bias."""

MODELS = (
    "levelled",
    "tapered",
    "cuboid_with_relief",
    "cuboid_to_highest_point",
    "cuboid_of_top_area",
    "cuboid_of_volume",
)
"""Variants that take the cuboid's place as the model of the real sample."""

GAP = "gap_times_"
"""Start of the names of cuboids that the platen meets late; they are models as well."""


def families(table: pd.DataFrame) -> tuple[dict[str, ResponseCurves], dict[str, ResponseCurves]]:
    """Two-term and one-term families of the variants of a sample.

    Parameters
    ----------
    table
        `softsample.geometry_effects.variants.simulate`; mixtures of 1 are the one-term material.
    """
    two_term: dict[str, ResponseCurves] = {}
    one_term: dict[str, ResponseCurves] = {}
    for name, curves in table.groupby("variant", sort=False):
        grid = curves.pivot_table("force_per_mu", index="mu1_fraction", columns="displacement")
        travel, fractions = grid.columns.to_numpy(float), grid.index.to_numpy(float)
        for found, rows in ((two_term, fractions <= 1.0), (one_term, fractions == 1.0)):
            found[str(name)] = ResponseCurves(fractions[rows], travel, grid.to_numpy()[rows])
    return two_term, one_term


def experiments(variants: Sequence[str]) -> list[tuple[str, str]]:
    """Pairs of sample and model: the plain one, changed models, changed samples."""
    models = [name for name in variants if name in MODELS or name.startswith(GAP)]
    kept = {"real", "cuboid", "tapered", *(name for name in models if name != "levelled")}
    samples = [name for name in variants if name not in kept]
    return [BASE, *((BASE[0], name) for name in models), *((name, BASE[1]) for name in samples)]


def group_bias(
    two_term: Mapping[str, Families],
    one_term: Mapping[str, Families],
    fit: Mapping[str, Any],
    settings: CalibrationSettings,
) -> pd.DataFrame:
    """Bias of every experiment in a group of samples that share their material.

    The sample's curves at the material calibrated on the real geometry are the record; both
    moduli are calibrated on the curves of the model, as in the study. Element type, segmentation
    and noise have no part in it. A test in which a variant does not exist keeps its plain one.

    Parameters
    ----------
    two_term, one_term
        Curves of the variants by sample; one term for compression samples alone.
    fit
        Two-term calibration on the real geometry.
    settings
        Of the calibration.

    Returns
    -------
    DataFrame
        `terms`, `sample_variant`, `model_variant`, `bias_percent`: 100 (model / sample - 1),
        `trusted`: whether the fits converged away from their bounds.
    """
    rows = []
    for terms, curves in ((2, two_term), (1, one_term)):
        names = dict.fromkeys(name for found in curves.values() for name in found)
        for pair in experiments(list(names)) if curves else []:
            measured = {
                sample: _record(two_term[sample].get(pair[0], two_term[sample][BASE[0]]), fit)
                for sample in curves
            }
            sample_fit, model_fit = (
                fit_ogden(
                    {sample: found.get(name, found[plain]) for sample, found in curves.items()},
                    measured,
                    settings,
                )
                for name, plain in zip(pair, BASE, strict=True)
            )
            rows.append(
                {
                    "terms": terms,
                    "sample_variant": pair[0],
                    "model_variant": pair[1],
                    "bias_percent": 100.0 * (model_fit.mu / sample_fit.mu - 1.0),
                    "trusted": sample_fit.success and model_fit.success,
                }
            )
    return pd.DataFrame(rows)


def _record(family: ResponseCurves, fit: Mapping[str, Any]) -> MeasuredCurve:
    force = fit["mu_pa"] * family.force_per_mu(fit["mu1_fraction"], family.displacement)
    return MeasuredCurve(family.displacement, np.asarray(force, dtype=np.float64))
