"""Profile likelihood of calibrated parameters."""

from collections.abc import Mapping
from itertools import product
from string import ascii_lowercase

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, StrMethodFormatter

from softsample.figures.style import PALETTE, label_panel, page_figure, styled

TOGETHER = 5
"""Groups in one panel, at most: each has a colour and a dash, which grey print keeps apart."""

DASHES = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)), (0, (5, 1.5, 1.2, 1.5)), (0, (9, 2)))

AXES = {"mu1": "μ₁ [Pa]", "mu2": "μ₂ [Pa]", "alpha1": "α₁ [–]", "alpha2": "α₂ [–]"}


@styled
def profile_figure(profiles: pd.DataFrame, level: float, study: Mapping[str, float]) -> Figure:
    """A row for each parameter, a column for each `TOGETHER` groups, a line for each group.

    Parameters
    ----------
    profiles
        Columns `group`, `parameter`, `value`, `deviance`.
    level
        Deviance at the ends of an interval, drawn as a line; panels end at four times of it.
    study
        Values of parameters in the study, drawn as lines.
    """
    groups = list(dict.fromkeys(profiles["group"]))
    columns = [groups[k : k + TOGETHER] for k in range(0, len(groups), TOGETHER)]
    figure = page_figure(height_mm=190.0)
    panels = figure.subplots(len(AXES), len(columns), sharey=True, squeeze=False)
    cells = product(zip(AXES.items(), panels, strict=True), range(len(columns)))
    for letter, (((name, label), row), k) in zip(ascii_lowercase, cells, strict=False):
        ax = row[k]
        for group, colour, dash in zip(columns[k], PALETTE, DASHES, strict=False):
            chosen = (profiles["group"] == group) & (profiles["parameter"] == name)
            curve = profiles[chosen].sort_values("value")
            near = curve["deviance"] <= 8.0 * level
            ax.plot(
                curve["value"][near], curve["deviance"][near], color=colour, ls=dash, label=group
            )
        ax.axhline(level, color="0.4", lw=0.6, ls="--")
        if name in study:
            ax.axvline(study[name], color="0.4", lw=0.6, ls=":")
        if name in ("mu1", "mu2"):
            _logarithmic(ax)
        ax.set(xlabel=label, ylim=(0.0, 4.0 * level))
        label_panel(ax, letter)
    figure.supylabel("Deviance, 2 n ln(A / A$_{min}$) [–]", size=8.0)
    for ax in panels[0]:
        ax.legend(
            loc="lower center", bbox_to_anchor=(0.5, 1.12), ncols=TOGETHER, handlelength=2.1,
            handletextpad=0.4, columnspacing=0.9,
        )  # fmt: skip
    return figure


def _logarithmic(ax: Axes) -> None:
    """Logarithmic scale whose ticks are plain numbers that do not run into each other."""
    ax.set_xscale("log")
    low, high = ax.get_xlim()
    if high < 10.0 * low:
        ax.xaxis.set_major_locator(MaxNLocator(4))
    else:
        ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0) if high < 300.0 * low else (1.0,)))
    ax.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())
