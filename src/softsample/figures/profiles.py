"""Profile likelihood of calibrated parameters."""

from collections.abc import Mapping

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, StrMethodFormatter

from softsample.figures.style import colours, label_panel, page_figure, styled

AXES = {"mu1": "μ₁ [Pa]", "mu2": "μ₂ [Pa]", "alpha1": "α₁ [–]", "alpha2": "α₂ [–]"}


@styled
def profile_figure(profiles: pd.DataFrame, level: float, study: Mapping[str, float]) -> Figure:
    """A panel for each parameter, a line for each group.

    Parameters
    ----------
    profiles
        Columns `group`, `parameter`, `value`, `deviance`.
    level
        Deviance at the ends of an interval, drawn as a line; panels end at four times of it.
    study
        Values of parameters in the study, drawn as lines.
    """
    figure = page_figure(height_mm=130.0)
    panels = figure.subplots(2, 2, sharey=True)
    groups = list(dict.fromkeys(profiles["group"]))
    for letter, ax, (name, label) in zip("abcd", panels.flat, AXES.items(), strict=True):
        for group, colour in zip(groups, colours(len(groups)), strict=True):
            chosen = (profiles["group"] == group) & (profiles["parameter"] == name)
            curve = profiles[chosen].sort_values("value")
            near = curve["deviance"] <= 8.0 * level
            ax.plot(curve["value"][near], curve["deviance"][near], color=colour, label=group)
        ax.axhline(level, color="0.4", lw=0.6, ls="--")
        if name in study:
            ax.axvline(study[name], color="0.4", lw=0.6, ls=":")
        if name in ("mu1", "mu2"):
            _logarithmic(ax)
        ax.set(xlabel=label, ylim=(0.0, 4.0 * level))
        label_panel(ax, letter)
    for ax in panels[:, 0]:
        ax.set_ylabel("Deviance, 2 n ln(A / A$_{min}$) [–]")
    figure.legend(*panels.flat[0].get_legend_handles_labels(), loc="outside right center")
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
