"""Tables of what the geometry does to the bias, and of the cohort that would have the paper's."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy.interpolate import PchipInterpolator

from softsample.protocol import loading

QUANTITIES = {2: "modulus_two_term", 1: "modulus_one_term"}
"""Name in the table of means by the number of terms of the model."""

NEEDED = (
    "terms",
    "mode",
    "bias_percent",
    "paper_percent",
    "relief_factor",
    "summit_mm",
    "summit_needed_mm",
    "bond_depth_needed_mm",
    "gap_needed_mm",
)
"""Columns of the table of the cohort needed, which is empty without the paper's means."""

PLAIN = ("real", "cuboid")
RELIEF, BOND, GAP = "relief_times_", "bond_depth_", "gap_times_"
KEY = ["terms", "mode"]


def biases_of_groups(
    tables: Sequence[pd.DataFrame], groups: Mapping[str, Sequence[str]]
) -> pd.DataFrame:
    """Rows of `group_bias` of all groups, with `group` and `mode`; `groups` has their modes."""
    named = [table.assign(group=group) for group, table in zip(groups, tables, strict=True)]
    biases = pd.concat(named, ignore_index=True)
    whole = biases["group"].map({group: loading(modes) for group, modes in groups.items()})
    return biases.assign(mode=whole.where(biases["terms"] == 2, "compression"))


def summits_of_modes(
    modes: Sequence[str], cuboids: Sequence[Mapping[str, Any]], names: Iterable[str]
) -> dict[str, list[float]]:
    """Height of the highest point above the cuboid's top [mm] of each sample, by loading.

    `modes` and `cuboids` are those of the samples; a loading of two modes is named after both.
    """
    summits: dict[str, list[float]] = {}
    for mode, cuboid in zip(modes, cuboids, strict=True):
        for name in {name for name in names if mode in name}:
            summits.setdefault(name, []).append(cuboid["highest_point_mm"] - cuboid["height_mm"])
    return summits


def effects_table(biases: pd.DataFrame) -> pd.DataFrame:
    """Mean bias of every experiment and how far it is from the plain one.

    Parameters
    ----------
    biases
        `biases_of_groups`.

    Returns
    -------
    DataFrame
        `terms`, `mode`, `sample_variant`, `model_variant`, `count`, `bias_percent`,
        `bias_sd_percent` and, against the plain pair, `change_percent_of_mu` (percent of the
        modulus on the real geometry; positive brings the cuboid's modulus up) with its standard
        deviation over groups.
    """
    plain = biases[_is(biases, *PLAIN)].set_index(["group", "terms"])["bias_percent"]
    base = plain.reindex(pd.MultiIndex.from_frame(biases[["group", "terms"]])).to_numpy()
    rows = biases.assign(change=biases["bias_percent"] - base)
    keys = [*KEY, "sample_variant", "model_variant"]
    return (
        rows.groupby(keys, sort=False)
        .agg(
            count=("bias_percent", "size"),
            bias_percent=("bias_percent", "mean"),
            bias_sd_percent=("bias_percent", "std"),
            change_percent_of_mu=("change", "mean"),
            change_sd_percent_of_mu=("change", "std"),
        )
        .reset_index()
    )


def shares_table(biases: pd.DataFrame) -> pd.DataFrame:
    """The bias of every group in parts: features switched off one after the other.

    Parameters
    ----------
    biases
        As of `effects_table`.

    Returns
    -------
    DataFrame
        `group`, `mode`, `terms`, `bias_percent`, and the points of it that are due to
        `late_contact` (partial glue in tension and shear), `outline` and `areas`; they add up.
        `late_contact_on_cuboid`: the points that the cuboid loses by the relief of the real top.
    """
    wide = biases[biases["sample_variant"] == PLAIN[0]].pivot_table(
        "bias_percent", index=["group", "mode", "terms"], columns="model_variant", sort=False
    )
    parts = {
        "bias_percent": wide["cuboid"],
        "late_contact": wide["levelled"],
        "outline": wide["tapered"] - wide["levelled"],
        "areas": wide["cuboid"] - wide["tapered"],
        "late_contact_on_cuboid": wide["cuboid"] - wide["cuboid_with_relief"],
    }
    return pd.DataFrame(parts).reset_index()


def needed_table(
    effects: pd.DataFrame,
    preload_mm: float,
    summits_mm: Mapping[str, Sequence[float]],
    paper: pd.DataFrame,
) -> pd.DataFrame:
    """What samples would have to look like for the mean bias of the paper.

    Parameters
    ----------
    effects
        `effects_table`.
    preload_mm
        Depth of the glue in the study [mm].
    summits_mm
        Height of the highest point above the cuboid's top by loading, one a sample [mm].
    paper
        Means of the paper (`resources/paper/summary.csv`).

    Returns
    -------
    DataFrame
        `terms`, `mode`, `bias_percent`, `paper_percent`; `relief_factor`: factor on the relief
        that gives the paper's mean (monotone cubic between those tried; empty out of their
        reach); `summit_mm`, `summit_needed_mm`: mean height of the highest point above the mean
        top, and that times the factor; `bond_depth_needed_mm`; `gap_needed_mm`: how far above the
        cuboid the platen would have to start.
    """
    rows = []
    for terms, mode, part in by_loading(effects):
        found = paper[(paper["quantity"] == QUANTITIES[terms]) & (paper["mode"] == mode)]
        if found.empty:
            continue
        target, plain = float(found["mean_percent"].iloc[0]), _bias(part, PLAIN[0])
        relief = {0.0: _bias(part, "levelled"), 1.0: plain, **_steps(part, RELIEF)}
        bond = {preload_mm: plain, **_steps(part, BOND)}
        gap = {0.0: plain, **_steps(part, GAP)}
        factor, summit = crossing(relief, target), float(np.mean(summits_mm[mode]))
        depth, far = crossing(bond, target), crossing(gap, target) * summit
        rows.append((terms, mode, plain, target, factor, summit, factor * summit, depth, far))
    return pd.DataFrame(rows, columns=list(NEEDED))


def by_loading(effects: pd.DataFrame) -> list[tuple[int, str, pd.DataFrame]]:
    """Number of terms, mode, and the rows of `effects_table` that belong to them."""
    pairs = dict.fromkeys(zip(effects["terms"], effects["mode"], strict=True))
    return [
        (int(terms), str(mode), effects[(effects["terms"] == terms) & (effects["mode"] == mode)])
        for terms, mode in pairs
    ]


def crossing(steps: Mapping[float, float], target: float) -> float:
    """Where values known at some places reach `target`, by monotone cubics; NaN if nowhere."""
    places = sorted(steps)
    if len(places) < 3:
        return float("nan")
    curve = PchipInterpolator(places, [steps[place] - target for place in places])
    roots = curve.roots(extrapolate=False)
    return float(roots[0]) if len(roots) else float("nan")


def _is(table: pd.DataFrame, sample: str, model: str) -> pd.Series:
    return (table["sample_variant"] == sample) & (table["model_variant"] == model)


def _bias(part: pd.DataFrame, sample: str) -> float:
    return float(part.loc[_is(part, sample, PLAIN[1]), "bias_percent"].iloc[0])


def _steps(part: pd.DataFrame, prefix: str) -> dict[float, float]:
    """Bias by the number that follows `prefix` in the name of the sample or of the model."""
    return {
        float(name.removeprefix(prefix).removesuffix("_mm")): float(bias)
        for side in ("sample_variant", "model_variant")
        for name, bias in zip(part[side], part["bias_percent"], strict=True)
        if name.startswith(prefix)
    }


NAMES = {
    ("real", "cuboid"): "as in the study",
    ("real", "levelled"): "model: sample, top levelled",
    ("real", "tapered"): "model: cuboid with the sample's section areas",
    ("real", "cuboid_with_relief"): "model: cuboid with the sample's relief",
    ("real", "cuboid_to_highest_point"): "model: cuboid as high as the highest point",
    ("real", "cuboid_of_top_area"): "model: cuboid of the sample's top area",
    ("real", "cuboid_of_volume"): "model: cuboid of the sample's volume",
    ("levelled", "cuboid"): "sample: top levelled",
    ("tilt_alone", "cuboid"): "sample: top smooth, tilt kept",
    ("without_tilt", "cuboid"): "sample: bumps kept, no tilt",
    ("bond_by_contact", "cuboid"): "sample: bonded where a simulated pre-load touches",
}
"""What each experiment changes, by sample and model."""


def spoken(sample: str, model: str) -> str:
    """An experiment in words."""
    if sample.startswith(RELIEF):
        return f"sample: relief times {sample.removeprefix(RELIEF)}"
    if model.startswith(GAP):
        return f"model: cuboid met late, gap times {model.removeprefix(GAP)}"
    if sample.startswith(BOND):
        depth = sample.removeprefix(BOND).removesuffix("_mm")
        return f"sample: bonded to a depth of {depth} mm"
    return NAMES[sample, model]
