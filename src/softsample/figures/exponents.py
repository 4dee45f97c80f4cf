"""Exponents of all groups with their intervals."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from softsample.figures.style import label_panel, page_figure, styled

LABELS = {"alpha1": "α₁ [–]", "alpha2": "α₂ [–]"}


@styled
def exponents_figure(
    table: pd.DataFrame, ranges: Sequence[tuple[float, float]], study: Sequence[float]
) -> Figure:
    """A panel for each exponent, a line for each group; an arrow is an open end.

    Parameters
    ----------
    table
        Of `softsample.laws.exponents.exponent_table`.
    ranges
        Of the exponents, the limits of the panels.
    study
        Exponents of the study, drawn as lines.
    """
    figure = page_figure(height_mm=20.0 + 6.0 * len(table))
    panels = figure.subplots(1, 2, sharey=True)
    rows = np.arange(len(table))[::-1]
    for letter, ax, (name, label), limits, own in zip(
        "ab", panels, LABELS.items(), ranges, study, strict=True
    ):
        ax.axvline(own, color="0.5", lw=0.8, ls=":")
        for row, low, high in zip(rows, table[f"{name}_low"], table[f"{name}_high"], strict=True):
            ends = [limits[0] if np.isnan(low) else low, limits[1] if np.isnan(high) else high]
            ax.plot(ends, [row, row], color="0.3", lw=1.2)
            for end, open_, arrow in zip(ends, np.isnan([low, high]), "<>", strict=True):
                ax.plot(end, row, arrow if open_ else "|", color="0.3", ms=4.0, clip_on=False)
        ax.plot(table[name], rows, "o", color="0.0", ms=3.5)
        ax.set(xlabel=label, xlim=limits, yticks=rows, yticklabels=table["group"])
        label_panel(ax, letter)
    return figure
