"""Contact area in compression: real sample and cuboid."""

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from softsample.figures.moduli import LINES, geometry_names
from softsample.figures.style import colours, page_figure, styled


@styled
def contact_figure(shares: Mapping[tuple[str, str], pd.DataFrame], ideal: str = "cuboid") -> Figure:
    """Contact area against nominal strain, one colour a sample.

    Parameters
    ----------
    shares
        `softsample.report.contact.contact_share` by sample and geometry.
    ideal
        What samples are idealised as.
    """
    figure = page_figure(height_mm=90.0, width_mm=130.0)
    ax = figure.add_subplot()
    samples = list(dict.fromkeys(sample for sample, _ in shares))
    palette = dict(zip(samples, colours(len(samples)), strict=True))
    for (sample, geometry), curve in shares.items():
        ax.plot(curve["strain"], curve["share_percent"], color=palette[sample], ls=LINES[geometry])
    ax.set(xlabel="Nominal strain, absolute [–]", ylabel="Contact area / ideal area [%]")
    ax.set_xlim(left=0.0)
    ax.set_ylim(bottom=0.0)
    handles = [Line2D([], [], color=colour, label=name) for name, colour in palette.items()]
    handles += [
        Line2D([], [], color="0.3", ls=LINES[name], label=label)
        for name, label in geometry_names(ideal, {geometry for _, geometry in shares}).items()
    ]
    ax.legend(handles=handles, loc="lower right", ncols=2)
    return figure
