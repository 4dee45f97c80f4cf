"""Figures 5 and 6: measured and modelled curves, what they differ by, and the moduli."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import count
from string import ascii_lowercase
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from softsample.figures.style import (
    axis_labels,
    colours,
    darkened,
    label_panel,
    lightened,
    page_figure,
    styled,
)
from softsample.report.page import MISSING, signed
from softsample.wording import spoken

EVERY = 50
"""Each how manieth measured point is drawn, at most."""

FEWEST = 10
"""Measured points of a curve that are drawn, if it has so many."""

LINES = {"real": "-", "ideal": (0, (3.5, 1.8))}
WIDTHS = {"real": 1.5, "ideal": 0.9}
BAR = 0.38

BINS = 50
"""Points of a residual that are drawn, each the mean of its part of the record."""

HEADROOM = 1.15
"""Top of an axis of moduli over the tallest bar, so that the difference fits above it."""


@dataclass(frozen=True)
class GroupCurves:
    """Curves of one group, or of one sample, on the geometries that it has.

    Parameters
    ----------
    label : str
        Name in the table of moduli.
    mode : str
        Loading in the table of moduli (`shear`, `tension+compression`...).
    curves : dict of DataFrame
        By geometry: `sample`, `displacement_mm`, `measured_N`, `model_N`.
    trusted : bool
        Whether all fits converged away from their bounds.
    limits : dict
        By geometry, ends [Pa] of the interval of mu; none by default.
    """

    label: str
    mode: str
    curves: dict[str, pd.DataFrame]
    trusted: bool = True
    limits: dict[str, tuple[float, float]] = field(default_factory=dict)


def limits_of(intervals: pd.DataFrame, group: str, model: str) -> dict[str, tuple[float, float]]:
    """By geometry, ends [Pa] of the interval of mu of a group, from `tables/intervals.csv`."""
    chosen = {"group": group, "model": model, "modulus": "mu"}
    rows = intervals[(intervals[list(chosen)] == list(chosen.values())).all(axis=1)]
    ends = zip(rows["low_pa"].tolist(), rows["high_pa"].tolist(), strict=True)
    return dict(zip(rows["geometry"].tolist(), ends, strict=True))


def geometry_names(ideal: str, there: Iterable[str] = tuple(LINES)) -> dict[str, str]:
    """Names of the geometries in a legend: of those that are `there`, by what is ideal."""
    names = {"real": "real geometry", "ideal": f"idealised {ideal}"}
    return {geometry: name for geometry, name in names.items() if geometry in there}


@styled
def moduli_figure(
    groups: Sequence[GroupCurves], moduli: pd.DataFrame, ideal: str = "cuboid"
) -> Figure:
    """Force-displacement curves above their residuals, beside moduli; a row a kind of loading.

    Parameters
    ----------
    groups
        Curves of the groups, in the order of drawing.
    moduli
        `softsample.report.tables.moduli_table`; with `mu1_real_pa` and so on the bars are
        stacked, without them they show mu alone. The paper's moduli are marked if there are any.
    ideal
        What samples are idealised as.
    """
    loadings = list(dict.fromkeys(group.mode for group in groups))
    figure = page_figure(height_mm=14.0 + 88.0 * len(loadings))
    ratios = {"width_ratios": [1.12, 1.0], "height_ratios": [2.6, 1.0] * len(loadings)}
    grid = figure.add_gridspec(2 * len(loadings), 2, **ratios)
    letters = count()
    for row, loading in zip(count(step=2), loadings, strict=False):
        left = figure.add_subplot(grid[row, 0])
        below = figure.add_subplot(grid[row + 1, 0], sharex=left)
        right = figure.add_subplot(grid[row : row + 2, 1])
        members = [group for group in groups if group.mode == loading]
        palette = dict(zip([g.label for g in members], colours(len(members)), strict=True))
        label_panel(left, ascii_lowercase[next(letters)], f"{spoken(loading).capitalize()}: force")
        draw_curves(left, members, palette)
        travel, force = axis_labels(loading)
        left.set(ylabel=force)
        left.tick_params(labelbottom=False)
        draw_residuals(below, members, palette)
        below.set(xlabel=travel, ylabel="Model − exp.\n[% of peak]")
        label_panel(
            right, ascii_lowercase[next(letters)], f"{spoken(loading).capitalize()}: modulus"
        )
        draw_moduli(right, moduli[moduli["group"].isin(list(palette))], palette, members)
    names = geometry_names(ideal, {name for group in groups for name in group.curves})
    intervals = any(group.limits for group in groups)
    handles = [*_keys_of_curves(names), *_keys_of_moduli(moduli, names, intervals)]
    if not all(group.trusted for group in groups):
        label = "* see the caption"
        handles.append(Line2D([], [], ls="", label=label))
    figure.legend(handles=handles, loc="outside lower center", ncols=3, handlelength=2.4)
    return figure


def draw_curves(ax: Axes, groups: Sequence[GroupCurves], palette: dict[str, str]) -> None:
    """Measured points and modelled lines of several groups, each in its colour.

    The idealised model is drawn thinner, darker and on top, or the two would hide each other.
    """
    for number, colour, curve, line in _lines(groups, palette):
        if number == 0:
            _draw_measured(ax, curve, colour)
        ax.plot(curve["displacement_mm"], curve["model_N"], zorder=3, **line)
    ax.axhline(0.0, color="0.75", lw=0.5, zorder=0)
    ax.axvline(0.0, color="0.75", lw=0.5, zorder=0)
    handles = [Line2D([], [], color=colour, lw=3, label=label) for label, colour in palette.items()]
    ax.legend(handles=handles, loc="best", handlelength=1.0)


def draw_residuals(ax: Axes, groups: Sequence[GroupCurves], palette: dict[str, str]) -> None:
    """Model less measurement of each record in percent of its peak, lines as of `draw_curves`."""
    for _, _, curve, line in _lines(groups, palette):
        left = (curve["model_N"] - curve["measured_N"]) / curve["measured_N"].abs().max()
        parts = np.array_split(np.arange(len(curve)), min(BINS, len(curve)))
        x, y = (
            [float(np.mean(of.to_numpy()[part])) for part in parts]
            for of in (curve["displacement_mm"], 100.0 * left)
        )
        ax.plot(x, y, **line)
    ax.axhline(0.0, color="0.75", lw=0.5, zorder=0)


def _lines(
    groups: Sequence[GroupCurves], palette: dict[str, str]
) -> Iterator[tuple[int, str, pd.DataFrame, dict[str, Any]]]:
    """Number of the geometry, colour, curve from zero on and line of each test on each geometry."""
    for group in groups:
        colour = palette[group.label]
        for number, (geometry, table) in enumerate(group.curves.items()):
            for _, curve in table.groupby("sample", sort=False):
                from_zero = curve.sort_values("displacement_mm", key=abs, kind="stable")
                yield number, colour, from_zero, model_line(geometry, colour)


def model_line(geometry: str, colour: str) -> dict[str, Any]:
    """How the curve of a model is drawn: that of the idealised geometry dashed and darker."""
    shade = darkened(colour) if geometry == "ideal" else colour
    return {"color": shade, "ls": LINES[geometry], "lw": WIDTHS[geometry]}


def _draw_measured(ax: Axes, curve: pd.DataFrame, colour: str) -> None:
    shown = curve.iloc[:: max(1, min(EVERY, len(curve) // FEWEST))]
    ax.plot(
        shown["displacement_mm"], shown["measured_N"], "o", ms=3.8, mfc="none", mec=colour,
        mew=0.6, zorder=4,
    )  # fmt: skip


def draw_moduli(
    ax: Axes, moduli: pd.DataFrame, palette: dict[str, str], groups: Sequence[GroupCurves]
) -> None:
    """Bars of mu1 (dark) and mu2 (light), real beside ideal, with the difference above.

    Lines are intervals of mu. The difference of a group that is not trusted has an asterisk; one
    that is not known is a dash.
    """
    of_label = {group.label: group for group in groups}
    two_terms = "mu1_real_pa" in moduli
    sides = {"real": -0.5, "ideal": 0.5} if moduli["mu_real_pa"].notna().any() else {"ideal": 0.0}
    marks = [f"{whose}mu_{geometry}_pa" for whose in ("", "paper_") for geometry in LINES]
    highest = [
        max((high for _, high in of_label[label].limits.values()), default=0.0)
        for label in moduli["group"]
    ]
    tops = 1e-3 * moduli[marks].max(axis=1).clip(lower=pd.Series(highest, moduli.index))
    for at, row in enumerate(moduli.to_dict("records")):
        colour = palette[row["group"]]
        for geometry, side in sides.items():
            bar: dict[str, Any] = {"width": BAR, "edgecolor": "white", "linewidth": 0.4}
            bar |= {"hatch": "////"} if geometry == "ideal" else {}
            x, mu = at + side * (BAR + 0.03), 1e-3 * row[f"mu_{geometry}_pa"]
            first = 1e-3 * row[f"mu1_{geometry}_pa"] if two_terms else mu
            ax.bar(x, first, color=colour, **bar)
            if two_terms:
                ax.bar(x, mu - first, bottom=first, color=lightened(colour), **bar)
            if geometry in (limits := of_label[row["group"]].limits):
                ends = [[abs(1e-3 * end - mu)] for end in limits[geometry]]
                ax.errorbar(x, mu, yerr=ends, color="black", lw=0.8, capsize=2.0, zorder=3)
            paper = 1e-3 * row[f"paper_mu_{geometry}_pa"]
            if np.isfinite(paper):
                ax.plot(x, paper, "D", ms=3.4, mfc="white", mec="black", mew=0.8, zorder=4)
        known = np.isfinite(row["difference_percent"])
        text = f"{signed(row['difference_percent'])} %" if known else MISSING
        text += "" if of_label[row["group"]].trusted else " *"
        ax.annotate(
            text,
            (at, tops.iloc[at]),
            xytext=(0, 4),
            textcoords="offset points",
            ha="center",
            size=7,
        )
    ax.set_xticks(range(len(moduli)), moduli["group"])
    ax.set_xlim(-0.7, len(moduli) - 0.3)
    ax.set(ylabel="Shear modulus [kPa]", xlabel="Group" if two_terms else "Sample")
    if tops.max() > 0.0:
        ax.set_ylim(0.0, HEADROOM * tops.max())


def _keys_of_curves(names: dict[str, str]) -> list[Line2D]:
    """Legend entries of the left column."""
    return [
        Line2D([], [], ls="", marker="o", ms=3.2, mfc="none", mec="0.3", mew=0.6,
               label="experiment"),
        *(Line2D([], [], color="0.3", ls=LINES[g], label=f"model, {name}", lw=WIDTHS[g])
          for g, name in names.items()),
    ]  # fmt: skip


def _keys_of_moduli(
    moduli: pd.DataFrame, names: dict[str, str], intervals: bool
) -> list[Patch | Line2D]:
    """Legend entries of the right column."""
    grey = "#737373"
    edge: dict[str, Any] = {"edgecolor": "white", "linewidth": 0.4}
    keys: list[Patch | Line2D] = []
    if "mu1_real_pa" in moduli:
        keys += [
            Patch(facecolor=grey, label=r"bar: $\mu_1$ (dark)", **edge),
            Patch(facecolor=lightened(grey), label=r"bar: $\mu_2$ (light)", **edge),
        ]
    hatches = {"real": None, "ideal": "////"}
    keys += [
        Patch(facecolor=grey, hatch=hatches[geometry], label=f"bar: {name}", **edge)
        for geometry, name in names.items()
    ]
    if intervals:
        keys.append(Line2D([], [], color="black", lw=0.8, label=r"interval of $\mu$"))
    if moduli["paper_mu_real_pa"].notna().any():
        marker = Line2D([], [], ls="", marker="D", ms=3.4, mfc="white", mec="black", mew=0.8)
        marker.set_label(r"$\mu$ in the paper")
        keys.append(marker)
    return keys
