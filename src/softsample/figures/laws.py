"""Records and the laws that predict them best."""

from collections.abc import Mapping, Sequence
from string import ascii_lowercase

import pandas as pd
from matplotlib.figure import Figure

from softsample.figures.style import colours, label_panel, page_figure, styled

LINES = ("-", "--", ":")
"""Of the three laws, the recommended one first."""


@styled
def laws_figure(
    curves: Mapping[str, pd.DataFrame], best: Mapping[str, Sequence[str]], titles: Mapping[str, str]
) -> Figure:
    """Force against displacement, and what each law leaves over, one row a group.

    Parameters
    ----------
    curves
        By group: `law`, `sample`, `displacement_mm`, `measured_N`, `model_N`.
    best
        Laws that are drawn, by group.
    titles
        Of the laws, in words.
    """
    figure = page_figure(height_mm=60.0 * len(curves))
    letters = iter(ascii_lowercase)
    panels = figure.subplots(len(curves), 2, squeeze=False)
    for (group, table), (force, left_over) in zip(curves.items(), panels, strict=True):
        samples = list(dict.fromkeys(table["sample"]))
        for colour, sample in zip(colours(len(samples)), samples, strict=True):
            for line, law in zip(LINES, best[group], strict=False):
                own = table[(table["sample"] == sample) & (table["law"] == law)]
                way, measured = own["displacement_mm"], own["measured_N"]
                if law == best[group][0]:
                    force.plot(way, measured, "o", color=colour, ms=2.0, label=sample)
                force.plot(way, own["model_N"], ls=line, color=colour)
                peak = measured.abs().max()
                gap = 100.0 * (measured - own["model_N"]) / peak
                left_over.plot(way, gap, ls=line, color=colour, lw=0.8)
        for line, law in zip(LINES, best[group], strict=False):
            left_over.plot([], [], ls=line, color="0.3", label=titles[law])
        for ax in (force, left_over):
            ax.axhline(0.0, color="0.75", lw=0.5, zorder=0)
            ax.set_xlabel("Displacement [mm]")
            ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.28), ncols=2)
        force.set_ylabel("Force [N]")
        left_over.set_ylabel("Measured less law [% of peak]")
        label_panel(force, next(letters, ""), f"{group}: records and laws")
        label_panel(left_over, next(letters, ""), "What is left over")
    return figure
