"""Tables 1 and 2, sizes and areas, and their means beside the paper's.

References
----------
S. Arzemanzadeh, K. Miller, A. Wittek, On the validity of using idealised sample geometries for
interpreting mechanical tests of very soft tissues: tables 1 and 2, section 3.1.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from softsample.errors import InputError
from softsample.protocol import GEOMETRIES, ONE_TERM, TWO_TERM, loading
from softsample.report.intervals import FLOOR, MEASURED
from softsample.report.page import with_interval
from softsample.wording import significant, structured, true_minus

PAPER_TABLE = {TWO_TERM: 1, ONE_TERM: 2}
"""Number of the paper's table of each material model."""

TERMS = {TWO_TERM: ("mu1", "mu2", "mu"), ONE_TERM: ("mu",)}
"""Moduli that a table prints for each material model."""

MOST = 3
"""Samples whose names a row of the one-term table joins."""

NO_REAL = "not all samples have an image or a surface: moduli of the ideal shape, bias not known"
"""Note of a group whose samples' true shape is not known."""

LEAST_CHANGE = 0.01
"""Changes [%] below this are told as smaller."""

LEVEL = 0.90
"""Level of the intervals of means."""


def moduli_table(
    fits: Iterable[Mapping[str, Any]],
    model: str,
    paper: pd.DataFrame | None = None,
    shapes: Mapping[str, Mapping[str, Any]] | None = None,
) -> tuple[pd.DataFrame, list[str]]:
    """Moduli on both geometries, one row a group (Table 1 or 2 of the paper).

    Parameters
    ----------
    fits
        Calibration results (`calibration/{group}/{geometry}/{model}.json`) in the order of the
        rows; of each are read `group`, `geometry`, `samples`, `modes`, `mu1_pa`, `mu2_pa`,
        `mu_pa`, `success`, `verdict` and, if it is there, `finding`.
    model
        `ogden2` or `ogden1`. The one-term table names its rows by the sample (C1), since it
        is fitted to the compression sample of a group (TC1) alone; by the group if there are many.
    paper
        Values of the paper (`resources/paper/moduli.csv`); None leaves its columns empty.
    shapes
        Of samples, what they are idealised as and look like (`cuboid/{sample}.json`).

    Returns
    -------
    table : DataFrame
        Moduli [Pa]; `difference_percent` = 100 (ideal - real) / real, negative when the cuboid
        gives the lower modulus. The paper's values have the same names after `paper_`;
        `mu_real_against_paper_percent` and `mu_ideal_against_paper_percent` are ours over them,
        `difference_against_paper_points` is ours minus theirs. `note`: findings, fits not to be
        trusted, geometries that are not known, whose moduli are empty, and round samples that
        are idealised as cuboids.
    notes : list of str
        What a reader has to know of single rows: groups left out, findings, fits that are not
        trusted, round samples.

    Raises
    ------
    InputError
        If a group has two results for one geometry.
    """
    by_group = _paired(fits)
    rows, notes = [], []
    for group, pair in by_group.items():
        if "ideal" not in pair:
            notes.append(f"{group} is left out: no calibration on the ideal geometry")
            continue
        doubts = [
            f"{name} geometry: {doubt}"
            for name in GEOMETRIES
            if name in pair and (doubt := doubt_of(pair[name]))
        ]
        doubts += _round_samples(pair["ideal"]["samples"], shapes or {})
        notes += [f"{group}, {doubt}" for doubt in doubts]
        unknown = [] if "real" in pair else [NO_REAL]
        rows.append({**_moduli_row(pair, model), "note": "; ".join(unknown + doubts)})
    moduli = [f"{term}_{name}_pa" for name in GEOMETRIES for term in TERMS[model]]
    columns = ["group", "mode", *moduli, "difference_percent", "note"]
    return _beside_paper(pd.DataFrame(rows, columns=columns), model, paper), notes


def _round_samples(samples: Iterable[str], shapes: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """What to say of samples that look round and are idealised as cuboids."""
    return [
        f"{name} looks round (circularity {seen['circularity']:.2f}): if it is, write cylinder "
        "into column shape"
        for name in samples
        if (seen := shapes.get(name, {})).get("proposed_shape") == "cylinder"
        and seen["shape"] == "cuboid"
    ]


def doubt_of(fit: Mapping[str, Any]) -> str:
    """What a reader has to know of a fit: its finding, or why it is not to be trusted."""
    return fit.get("finding") or ("" if fit["success"] else fit["verdict"])


def _paired(fits: Iterable[Mapping[str, Any]]) -> dict[str, dict[str, Mapping[str, Any]]]:
    """Results by group and geometry, groups in the order of their first appearance."""
    by_group: dict[str, dict[str, Mapping[str, Any]]] = {}
    for fit in fits:
        pair = by_group.setdefault(fit["group"], {})
        if fit["geometry"] in pair:
            raise InputError(
                f"group {fit['group']} has two calibrations on the {fit['geometry']} geometry; "
                "give each file once"
            )
        pair[fit["geometry"]] = fit
    return by_group


def _moduli_row(pair: Mapping[str, Mapping[str, Any]], model: str) -> dict[str, str | float]:
    ideal = pair["ideal"]
    moduli = {
        f"{term}_{name}_pa": float(pair[name][f"{term}_pa"]) if name in pair else np.nan
        for name in GEOMETRIES
        for term in TERMS[model]
    }
    real, samples = moduli["mu_real_pa"], ideal["samples"]
    return {
        "group": "+".join(samples)
        if model == ONE_TERM and len(samples) <= MOST
        else ideal["group"],
        "mode": loading(ideal["modes"]),
        **moduli,
        "difference_percent": 100.0 * (ideal["mu_pa"] - real) / real,
    }


def table_shown(
    name: str,
    table: pd.DataFrame,
    intervals: pd.DataFrame,
    groups: Mapping[str, str],
    confidence: float,
) -> pd.DataFrame:
    """What the report shows of a table: of moduli and intervals what a reader quotes, else all.

    Parameters
    ----------
    name
        `table1`, `table2` or another.
    table
        As saved.
    intervals
        `intervals.csv`: intervals by group, geometry, model and modulus.
    groups
        Group of each sample, by which a row may be named.
    confidence
        Of the intervals.

    Returns
    -------
    DataFrame
        Of `table1` and `table2`: group, modulus of the best known geometry with its interval, what
        to know of it, mode, modulus of the ideal shape, difference, and the paper's. Of
        `intervals` see `intervals_shown`. Errors that the noise explains say so, and changes below
        `LEAST_CHANGE` are given as that.
    """
    model = {f"table{number}": model for model, number in PAPER_TABLE.items()}.get(name)
    if name == "intervals":
        return intervals_shown(table, confidence)
    if name in WORDED:
        columns, worded = WORDED[name]
        told = table.filter(regex=columns).map(worded, na_action="ignore")
        return table.assign(**{str(column): told[column] for column in told})
    if model is None:
        return table
    of = intervals.query("model == @model and modulus == 'mu'").set_index(["group", "geometry"])
    real = bool(table["mu_real_pa"].notna().any())
    best = []
    for row in table.to_dict("records"):
        geometry = "real" if pd.notna(row["mu_real_pa"]) else "ideal"
        key = groups.get(row["group"], row["group"]), geometry
        ends = of.loc[key, ["low_pa", "high_pa"]] if key in of.index else (None, None)
        best.append(with_interval(row[f"mu_{geometry}_pa"], *ends))
    shown = pd.DataFrame(
        {
            "group": table["group"],
            f"mu_with_{100.0 * confidence:g}_%_interval_pa": best,
            "trusted": table["note"].fillna("").replace("", "yes"),
            "mode": table["mode"],
        }
    )
    more = ["mu_ideal_pa", "difference_percent", "paper_difference_percent"] if real else []
    return shown.join(table[more])


def intervals_shown(table: pd.DataFrame, confidence: float) -> pd.DataFrame:
    """Of `intervals.csv`, mu with its interval and the two largest of its terms, a row a fit."""
    terms = {f"{term}_percent": term.replace("_", " ") for term in MEASURED + FLOOR}
    mu = table[table["modulus"] == "mu"].reset_index(drop=True)
    largest = [
        ", ".join(
            f"{terms[str(key)]} {significant(part)} %"
            for key, part in sorted(row.items(), key=lambda term: -term[1])[:2]
        )
        for row in mu[list(terms)].fillna(0.0).to_dict("records")
    ]
    ends = zip(mu["value_pa"], mu["low_pa"], mu["high_pa"], strict=True)
    return mu[["group", "geometry", "model"]].assign(
        **{f"mu_with_{100.0 * confidence:g}_%_interval_pa": [with_interval(*one) for one in ends]},
        largest_terms=largest,
    )


def _change(percent: float) -> str:
    """A change in percent, for people."""
    if abs(percent) < LEAST_CHANGE:
        return f"< {LEAST_CHANGE:g}"
    return true_minus(significant(percent))


WORDED: Mapping[str, tuple[str, Callable[[float], str]]] = {
    "sensitivity": ("_percent", _change),
    "loop": ("^(error|held_out)_", structured),
}
"""Columns of tables, as a pattern, whose smallest values the report gives in words."""


def _beside_paper(table: pd.DataFrame, model: str, paper: pd.DataFrame | None) -> pd.DataFrame:
    """`table` with the paper's columns, empty where the paper has no such group."""
    rows = None if paper is None else paper[paper["table"] == PAPER_TABLE[model]]
    table = _joined(table, rows, ["group"], table.columns.drop(["group", "mode", "note"]))
    for geometry in GEOMETRIES:
        ratio = table[f"mu_{geometry}_pa"] / table[f"paper_mu_{geometry}_pa"]
        table[f"mu_{geometry}_against_paper_percent"] = 100.0 * (ratio - 1.0)
    bias = table["difference_percent"] - table["paper_difference_percent"]
    table = table.assign(difference_against_paper_points=bias)
    return table[[*table.columns.drop("note"), "note"]]


def _joined(
    table: pd.DataFrame, paper: pd.DataFrame | None, on: list[str], columns: Iterable[str]
) -> pd.DataFrame:
    """`table` with `columns` of the paper, with `paper_` before their names."""
    names = {column: f"paper_{column}" for column in columns}
    if paper is None:
        return table.assign(**dict.fromkeys(names.values(), np.nan))
    return table.merge(paper[[*on, *names]].rename(columns=names), on=on, how="left")


def geometry_table(
    cuboids: Mapping[str, Mapping[str, float]], modes: Mapping[str, str]
) -> pd.DataFrame:
    """Sizes, volume and areas, one row a sample (section 3.1 of the paper).

    Parameters
    ----------
    cuboids
        Idealised shape by sample (`cuboid/{sample}.json`), in the order of the rows.
    modes
        Loading mode by sample.

    Returns
    -------
    DataFrame
        Lengths [mm], volume [mm3], areas [mm2]. Differences are 100 (real / ideal - 1) in
        percent: negative when the real face is smaller than the ideal one. A cylinder has
        `diameter_mm` in place of length and width; what is not known without an image or a
        surface is empty.
    """
    round_ = any("diameter_mm" in cuboid for cuboid in cuboids.values())
    edges = (*(("diameter_mm",) if round_ else ()), "length_mm", "width_mm", "height_mm")
    rows = []
    for sample, cuboid in cuboids.items():
        row: dict[str, str | float] = {"sample": sample, "mode": modes[sample]}
        across = ("length_mm", "width_mm") if "diameter_mm" in cuboid else ()
        row |= {edge: np.nan if edge in across else cuboid.get(edge, np.nan) for edge in edges}
        row["volume_real_mm3"] = cuboid.get("volume_real_mm3", np.nan)
        ideal = cuboid["ideal_area_mm2"]
        for face in ("bottom", "top"):
            real = cuboid.get(f"{face}_area_mm2", np.nan)
            row[f"{face}_area_real_mm2"] = real
            row[f"{face}_area_ideal_mm2"] = ideal
            row[f"{face}_difference_percent"] = 100.0 * (real / ideal - 1.0)
        rows.append(row)
    return pd.DataFrame(rows)


def summary_table(
    moduli: Mapping[str, pd.DataFrame], geometry: pd.DataFrame, paper: pd.DataFrame | None = None
) -> pd.DataFrame:
    """Means and standard deviations over samples or groups, beside the paper's.

    Parameters
    ----------
    moduli
        Tables of `moduli_table` by material model.
    geometry
        Table of `geometry_table`.
    paper
        Values of the paper (`resources/paper/summary.csv`); None leaves its columns empty.

    Returns
    -------
    DataFrame
        `quantity`, `mode`, `count`, `mean_percent`, `sd_percent` (n - 1 in the denominator, as
        the paper's; empty for a single one), `low_percent` and `high_percent` (90 % interval of
        the mean, Student's t), `paper_mean_percent`, `paper_sd_percent`, and ours minus theirs,
        `against_paper_points`.
        Signs as in the tables. The paper prints the difference of the bottom area without its
        sign, so that row has the mean of absolute differences. What is known of no sample has no
        row.
    """
    bottom = geometry["bottom_difference_percent"]
    rows = _statistics("bottom_area_absolute", "all", bottom.abs())
    for face in ("bottom", "top"):
        rows += _by_mode(f"{face}_area", geometry, f"{face}_difference_percent")
    for model, name in ((TWO_TERM, "modulus_two_term"), (ONE_TERM, "modulus_one_term")):
        if model in moduli:
            rows += _by_mode(name, moduli[model], "difference_percent")
    table = pd.DataFrame(rows, columns=STATISTICS)
    table = _joined(table, paper, ["quantity", "mode"], ["mean_percent", "sd_percent"])
    points = table["mean_percent"] - table["paper_mean_percent"]
    return table.assign(against_paper_points=points)


def _by_mode(quantity: str, table: pd.DataFrame, column: str) -> list[dict[str, Any]]:
    modes = dict.fromkeys(table["mode"])
    found = (_statistics(quantity, m, table.loc[table["mode"] == m, column]) for m in modes)
    return [row for rows in found for row in rows]


STATISTICS = (
    "quantity", "mode", "count", "mean_percent", "sd_percent", "low_percent", "high_percent"
)  # fmt: skip


def _statistics(quantity: str, mode: str, values: pd.Series) -> list[dict[str, Any]]:
    """A row of `STATISTICS` over the known values, none if there are none."""
    values = values.dropna()
    mean, sd, count = values.mean(), values.std(ddof=1), len(values)
    if count == 0:
        return []
    half = stdtrit(count - 1, 0.5 * (1.0 + LEVEL)) * sd / np.sqrt(count)
    row = (quantity, mode, count, mean, sd, mean - half, mean + half)
    return [dict(zip(STATISTICS, row, strict=True))]


def direct_table(
    pairs: Iterable[tuple[Mapping[str, Any], Mapping[str, Any]]],
    curves: Iterable[Mapping[str, Any]],
) -> pd.DataFrame:
    """Calibration with a simulation per evaluation against that with response curves.

    Parameters
    ----------
    pairs
        For each group its direct calibration and that with response curves.
    curves
        Report of the response curves of every sample (`curves/{sample}/{geometry}/{model}.json`),
        groups in the same order.

    Returns
    -------
    DataFrame
        Two rows a group: moduli [Pa], `area_error_percent` (mean of the samples), evaluations of
        the objective, simulations, their CPU time [s]; `difference_percent` from the family's mu.
        Pilot runs that find the loading time count as time of the family.
    """
    rows, reports = [], iter(curves)
    for direct, family in pairs:
        members = [next(reports) for _ in family["samples"]]
        once = sum(len(m["runs"]) for m in members), sum(m["cpu_s"] for m in members)
        each = direct["simulations"], direct["simulations_cpu_s"]
        for method, fit, (runs, cpu_s) in (("direct", direct, each), ("family", family, once)):
            rows.append(
                {
                    "group": fit["group"],
                    "method": method,
                    **{f"{name}_pa": fit[f"{name}_pa"] for name in TERMS[TWO_TERM]},
                    "difference_percent": 100.0 * (fit["mu_pa"] / family["mu_pa"] - 1.0),
                    "area_error_percent": np.mean(list(fit["area_error_percent"].values())),
                    "evaluations": sum(start["evaluations"] for start in fit["starts"]),
                    "simulations": runs,
                    "simulations_cpu_s": cpu_s,
                }
            )
    return pd.DataFrame(rows)
