"""What `softsample check` saw of a sample: sections, outline with the ideal shape, record."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from softsample.arrays import Array, Mask
from softsample.figures.geometry import CONTOUR, Scan, draw_slices
from softsample.figures.style import (
    MODE_COLOURS,
    PAGE_WIDTH_MM,
    axis_labels,
    label_panel,
    page_figure,
    styled,
)
from softsample.figures.surface import FRONT, Surface, silhouette
from softsample.shapes import IdealShape
from softsample.units import MM

ROW_MM, ALONE_MM = 58.0, 110.0
"""Height of a row of panels, and width of a record alone."""

MOST_POINTS = 2000
"""Readings of a record that are drawn, about."""


@styled
def inspected_figure(
    mode: str,
    record: tuple[Array, Array, Mask] | None,
    shape: IdealShape | None = None,
    surface: Surface | None = None,
    image: Scan | None = None,
) -> Figure:
    """One sample before the run, as far as it is known.

    Parameters
    ----------
    mode
        Loading, which gives the colour.
    record
        Displacement [mm], force [N] and what of them is calibrated.
    shape
        What the sample is idealised as.
    surface
        Of the sample, in the sample frame.
    image
        At low resolution, with its segmentation if there is one.
    """
    alone = image is None and surface is None
    rows = 1 if image is None else 2
    figure = page_figure(ROW_MM * rows, ALONE_MM if alone else PAGE_WIDTH_MM)
    parts: Any = figure.subfigures(rows, 1, squeeze=False)[:, 0]
    letters = iter("ab" if image is None else "de")
    if image is not None:
        draw_slices(parts[0], image)
    *outline, curve = np.atleast_1d(parts[-1].subplots(1, 1 if surface is None else 2))
    if surface is not None:
        _draw_outline(outline[0], surface, shape)
        label_panel(outline[0], next(letters), "From the front; dashed: ideal shape")
    if record is None:
        curve.set_axis_off()
    else:
        _draw_record(curve, mode, *record)
        label_panel(curve, next(letters), "Record; in colour: what is calibrated")
    return figure


def _draw_outline(ax: Axes, surface: Surface, shape: IdealShape | None) -> None:
    """Outline of a surface from the front, and of the ideal shape about its middle."""
    outline = silhouette(surface, FRONT)
    ax.plot(outline[:, 0], outline[:, 1], color=CONTOUR)
    if shape is not None:
        middle = 0.5 * (outline[:, 0].min() + outline[:, 0].max())
        length, height = shape.length / MM, shape.height / MM
        ideal = Rectangle((middle - 0.5 * length, 0.0), length, height, fill=False, ls="--", lw=0.8)
        ax.add_patch(ideal)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel="x [mm]", ylabel="z [mm]")


def _draw_record(ax: Axes, mode: str, displacement: Array, force: Array, calibrated: Mask) -> None:
    every = max(1, len(force) // MOST_POINTS)
    ax.plot(displacement[::every], force[::every], color="0.7", lw=0.8)
    fitted = np.where(calibrated, force, np.nan)
    ax.plot(displacement[::every], fitted[::every], color=MODE_COLOURS[mode], lw=1.6)
    ax.axhline(0.0, color="0.75", lw=0.5, zorder=0)
    ax.axvline(0.0, color="0.75", lw=0.5, zorder=0)
    travel, label = axis_labels(mode)
    ax.set(xlabel=travel, ylabel=label)
