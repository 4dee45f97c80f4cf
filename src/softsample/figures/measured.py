"""Errors on the held-out parts of others' records."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from softsample.figures.style import colours, page_figure, styled


@styled
def held_out_figure(summary: pd.DataFrame) -> Figure:
    """Held-out error before and after, one row a group; columns as of the summary."""
    figure = page_figure(height_mm=30.0 + 4.5 * len(summary), width_mm=150.0)
    ax = figure.add_subplot()
    rows = np.arange(len(summary))[::-1]
    before, after = (summary[f"held_out_{when}_percent"] for when in ("before", "after"))
    ax.hlines(rows, before, after, color="0.6")
    for colour, marker, name, values in zip(
        colours(2), "os", ("before", "after"), (before, after), strict=True
    ):
        ax.plot(values, rows, marker, color=colour, label=name, ms=4.0 if name == "before" else 3.0)
    labels = [f"{row.record_group}: {row.verdict}" for row in summary.itertuples()]
    ax.set_yticks(rows, labels)
    ax.set(xlabel="Error on the held-out part, RMS [% of peak]", xlim=(0.0, None))
    ax.legend(loc="lower right")
    return figure
