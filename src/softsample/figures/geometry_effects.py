"""What features of the shape do to the bias, and prescribed displacements against contact."""

from collections.abc import Mapping
from string import ascii_lowercase

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from softsample.figures.style import MODE_COLOURS, colours, label_panel, page_figure, styled
from softsample.report.geometry_effects import PLAIN, by_loading, spoken

PANELS = {2: "two-term model", 1: "one-term model"}
GEOMETRY_NAMES = {"real": "Real geometry", "ideal": "Idealised cuboid"}


@styled
def effects_figure(effects: pd.DataFrame, needed: pd.DataFrame) -> Figure:
    """Bias of every experiment, mean and standard deviation over groups, a panel a loading.

    Parameters
    ----------
    effects, needed
        `softsample.report.geometry_effects.effects_table` and `needed_table`; the latter has the
        paper's means, if there are any.
    """
    panels = by_loading(effects)
    pairs = list(
        dict.fromkeys(zip(effects["sample_variant"], effects["model_variant"], strict=True))
    )
    figure = page_figure(height_mm=22.0 + 6.5 * len(pairs))
    axes = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
    paper = {(row["terms"], row["mode"]): row["paper_percent"] for row in needed.to_dict("records")}
    for ax, letter, (terms, mode, part) in zip(
        axes, ascii_lowercase[: len(panels)], panels, strict=True
    ):
        label_panel(ax, letter, f"{_loading(mode)}\n{PANELS[terms]}")
        _draw_biases(ax, part, pairs, MODE_COLOURS[mode.split("+")[-1]])
        if (terms, mode) in paper:
            ax.axvline(paper[terms, mode], color="black", lw=0.9, ls=":")
    axes[0].set_yticks(range(len(pairs)), [spoken(*pair) for pair in pairs])
    axes[0].invert_yaxis()
    handles = [Line2D([], [], color="0.3", lw=0.9, ls="--", label="as in the study")]
    if paper:
        handles.append(Line2D([], [], color="black", lw=0.9, ls=":", label="mean of the paper"))
    figure.legend(handles=handles, loc="outside lower right", ncols=2)
    return figure


def _loading(mode: str) -> str:
    """Loading in lines that fit above a panel."""
    return mode.replace("+", ",\n").capitalize()


def _draw_biases(ax: Axes, part: pd.DataFrame, pairs: list[tuple[str, str]], colour: str) -> None:
    for row in part.to_dict("records"):
        pair = row["sample_variant"], row["model_variant"]
        ax.errorbar(
            row["bias_percent"], pairs.index(pair), xerr=np.nan_to_num(row["bias_sd_percent"]),
            fmt="s" if pair == PLAIN else "o", color=colour, markersize=4.0, lw=1.0, capsize=2.0,
        )  # fmt: skip
        if pair == PLAIN:
            ax.axvline(row["bias_percent"], color="0.3", lw=0.9, ls="--")
    ax.axvline(0.0, color="0.6", lw=0.6)
    ax.set_xlabel("Bias of the modulus [%]")


@styled
def prescribed_figure(
    curves: Mapping[tuple[str, str], pd.DataFrame], table: pd.DataFrame
) -> Figure:
    """Force by contact and by prescribed displacements against nominal strain, a panel a geometry.

    Parameters
    ----------
    curves
        By sample and geometry: `strain`, `contact_N`, `prescribed_N`.
    table
        `softsample.report.prescribed.prescribed_table`; circles mark where curves part by 5 %.
    """
    figure = page_figure(height_mm=85.0)
    geometries = list(dict.fromkeys(geometry for _, geometry in curves))
    samples = list(dict.fromkeys(sample for sample, _ in curves))
    axes = figure.subplots(1, len(geometries), squeeze=False)[0]
    palette = dict(zip(samples, colours(len(samples)), strict=True))
    parting = table.set_index(["sample", "geometry"])["agrees_5_percent_strain"]
    for ax, letter, geometry in zip(axes, "ab", geometries, strict=True):
        label_panel(ax, letter, GEOMETRY_NAMES[geometry])
        for sample in samples:
            curve, colour = curves[sample, geometry], palette[sample]
            ax.plot(curve["strain"], curve["contact_N"], color=colour)
            ax.plot(curve["strain"], curve["prescribed_N"], color=colour, ls=(0, (3.5, 1.8)))
            at = parting[sample, geometry]
            if at < curve["strain"].iloc[-1]:
                height = np.interp(at, curve["strain"], curve["contact_N"])
                ax.plot(at, height, "o", ms=4, mfc="white", mec=colour, clip_on=False, zorder=4)
        ax.set(xlabel="Nominal strain [–]", ylabel="Force, absolute [N]")
        ax.set_xlim(left=0.0)
        ax.set_ylim(bottom=0.0)
    handles = [Line2D([], [], color=colour, label=name) for name, colour in palette.items()]
    handles += [
        Line2D([], [], color="0.3", label="contact"),
        Line2D([], [], color="0.3", ls=(0, (3.5, 1.8)), label="prescribed"),
        Line2D([], [], ls="", marker="o", mfc="white", mec="0.3", ms=4, label="apart by 5 %"),
    ]
    axes[0].legend(handles=handles, loc="upper left", ncols=2)
    return figure
