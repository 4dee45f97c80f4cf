"""One sample's record against the calibrated model on both geometries."""

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure

from softsample.figures.moduli import geometry_names, model_line
from softsample.figures.style import MODE_COLOURS, axis_labels, label_panel, page_figure, styled


@styled
def response_figure(curves: Mapping[str, pd.DataFrame], mode: str, ideal: str = "cuboid") -> Figure:
    """Force against displacement, and what each model leaves over.

    Parameters
    ----------
    curves
        By geometry, `ideal` or both: `displacement_mm`, `measured_N`, `model_N`; empty for a
        sample that is held out.
    mode
        Loading, which gives the colour.
    ideal
        What the sample is idealised as.
    """
    figure = page_figure(height_mm=68.0)
    force, left_over = figure.subplots(1, 2)
    colour = MODE_COLOURS[mode]
    names = geometry_names(ideal, curves)
    for at, (geometry, table) in enumerate(curves.items()):
        curve = table.sort_values("displacement_mm", key=abs, kind="stable")
        travel = curve["displacement_mm"]
        if at == 0:
            force.plot(travel, curve["measured_N"], color="0.72", lw=3.0, label="measured")
        line = model_line(geometry, colour)
        force.plot(travel, curve["model_N"], label=f"model, {names[geometry]}", **line)
        misfit = 1e3 * (curve["measured_N"] - curve["model_N"])
        left_over.plot(travel, misfit, **{**line, "lw": 0.7})
    if all(table.empty for table in curves.values()):
        held_out = "held out: nothing of this record was calibrated"
        force.text(0.5, 0.6, held_out, ha="center", transform=force.transAxes)
    for ax in (force, left_over):
        ax.axhline(0.0, color="0.75", lw=0.5, zorder=0)
        ax.set_xlabel(axis_labels(mode)[0])
    force.set_ylabel(axis_labels(mode)[1])
    left_over.set_ylabel("Measured less model [mN]")
    force.legend(loc="best")
    label_panel(force, "a", "Record and calibrated model")
    label_panel(left_over, "b", "What is left over")
    return figure
