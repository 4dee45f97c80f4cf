"""Held-out errors of the public measured sets."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from softsample.figures.style import colours, page_figure, styled

BAND = 0.7
"""Part of a study's row that its groups are spread over."""


@styled
def held_out_figure(summary: pd.DataFrame) -> Figure:
    """Held-out error of every group before and after, a row a study.

    Parameters
    ----------
    summary
        Columns `set`, `held_out_before_percent`, `held_out_after_percent`.
    """
    studies = list(dict.fromkeys(summary["set"]))
    figure = page_figure(height_mm=25.0 + 9.0 * len(studies), width_mm=150.0)
    ax = figure.add_subplot()
    place = summary.groupby("set").cumcount() + 0.5
    place = place / summary.groupby("set")["set"].transform("size") - 0.5
    rows = summary["set"].map(studies.index) + BAND * place
    before, after = (summary[f"held_out_{when}_percent"] for when in ("before", "after"))
    ax.hlines(rows, before, after, color="0.6", linewidth=0.7)
    for colour, marker, name, values in zip(
        colours(2), "os", ("before", "after"), (before, after), strict=True
    ):
        ax.plot(values, rows, marker, color=colour, label=name, ms=2.5)
    ax.set_yticks(np.arange(len(studies)), studies)
    # no axis can be logarithmic if every run failed
    ax.set_xscale("log" if (before > 0.0).any() else "linear")
    ax.set(xlabel="Error on what was held out, RMS [% of peak]")
    ax.invert_yaxis()
    ax.legend(loc="best")
    return figure
