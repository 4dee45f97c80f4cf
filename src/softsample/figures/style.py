"""One look for all figures: page width, fonts, colours that the colour-blind can tell apart."""

import logging
import os
from collections.abc import Callable
from functools import wraps
from typing import Any, BinaryIO, ParamSpec

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure

from softsample.files import written_aside

P = ParamSpec("P")

PAGE_WIDTH_MM = 180.0
DOTS_PER_INCH = 300
IMAGE_DOTS_PER_INCH = 450
"""Resolution of rendered surfaces, finer than the page so that mesh edges stay crisp."""

MM_PER_INCH = 25.4

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito's colours without yellow, which is too pale for a line."""

MODE_COLOURS = {
    "shear": "#009E73",
    "tension": "#0072B2",
    "compression": "#D55E00",
    "pure_shear": "#CC79A7",
    "confined_compression": "#E69F00",
    "indentation": "#56B4E9",
    "torsion": "#000000",
}
"""Colour of each loading mode, in the order in which figures show them."""

TISSUE = "#D9B8A0"
STRAIN_MAP = "viridis"

STYLE: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8.0,
    "axes.titlesize": 8.5,
    "axes.labelsize": 8.0,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "lines.linewidth": 1.1,
    "hatch.linewidth": 0.6,
    "figure.titlesize": 9.0,
    "pdf.fonttype": 42,
    "svg.hashsalt": "softsample",
}


def styled(function: Callable[P, Figure]) -> Callable[P, Figure]:
    """Draw with the project's style, whatever the caller's settings are."""

    @wraps(function)
    def draw(*args: P.args, **kwargs: P.kwargs) -> Figure:
        settings: dict[Any, Any] = {**mpl.rcParamsDefault, **STYLE, "backend": "agg"}
        with mpl.rc_context(settings):
            return function(*args, **kwargs)

    return draw


def page_figure(height_mm: float, width_mm: float = PAGE_WIDTH_MM) -> Figure:
    """Empty figure of the page's width with constrained layout, outside of pyplot."""
    size = (width_mm / MM_PER_INCH, height_mm / MM_PER_INCH)
    figure = Figure(figsize=size, dpi=DOTS_PER_INCH, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


@styled
def save(
    figure: Figure, path: str | os.PathLike[str] | BinaryIO, dots_per_inch: int = DOTS_PER_INCH
) -> Figure:
    """Write a figure in the format of the path's suffix, into a buffer as PNG, always the same."""
    logging.getLogger("fontTools").setLevel(logging.WARNING)  # else each glyph is in the log
    is_pdf = isinstance(path, str | os.PathLike) and os.fspath(path).endswith(".pdf")
    metadata = {"CreationDate": None} if is_pdf else {"Software": None}
    figure.savefig(path, dpi=dots_per_inch, metadata=metadata)
    return figure


def write(figure: Figure, *paths: str) -> None:
    """Write a figure to files, each whole or not at all."""
    for path in paths:
        with written_aside(path) as aside:
            save(figure, aside)


def colours(count: int) -> list[str]:
    """One colour for each of `count` groups: the palette, beyond it evenly from a map."""
    if count <= len(PALETTE):
        return list(PALETTE[:count])
    return [to_hex(c) for c in mpl.colormaps["cividis"](np.linspace(0.0, 0.95, count))]


def map_colours() -> list[str]:
    """The map of strains in 32 steps, for pictures that are drawn elsewhere."""
    return [to_hex(c) for c in mpl.colormaps[STRAIN_MAP](np.linspace(0.0, 1.0, 32))]


def axis_labels(loading: str) -> tuple[str, str]:
    """Names of displacement and force of a loading, with units."""
    if loading == "torsion":
        return "Displacement of the rim [mm]", "Torque over radius [N]"
    part = "indenter" if loading == "indentation" else "platen"
    return f"Displacement of the {part} [mm]", "Force [N]"


def lightened(colour: str) -> str:
    """`colour` mixed with 60 % of white."""
    red, green, blue = ((1.0 - 0.6) * part + 0.6 for part in to_rgb(colour))
    return to_hex((red, green, blue))


def darkened(colour: str) -> str:
    """`colour` mixed with 45 % of black."""
    red, green, blue = ((1.0 - 0.45) * part for part in to_rgb(colour))
    return to_hex((red, green, blue))


def label_panel(ax: Axes, letter: str, title: str = "") -> None:
    """Bold panel letter and title, left-aligned above the axes."""
    ax.set_title(rf"$\mathbf{{{letter}}}$  {title}".strip(), loc="left")
