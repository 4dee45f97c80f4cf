"""Record and model before and after the loop, and what is left over."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from softsample.arrays import root_mean_square
from softsample.figures.style import colours, page_figure, styled
from softsample.loop.diagnose import Diagnosis
from softsample.loop.specimen import FORCE, Array, blocks
from softsample.report.residual import Predicted, predicted
from softsample.wording import spoken

MOST = 5
"""Tests that a figure shows at most: the worst, in the order of the study."""

ENTRIES = ("measured", "held out", "before", "after")
"""Of the legend."""

LARGE = 1.0
"""Residual [N] from which on it is drawn in N, else in mN."""

ROOM = 1.0
"""How far beyond the measured range models are drawn, as a part of it."""


@styled
def loop_figure(found: Diagnosis) -> Figure:
    """One column a test: force against travel, residual against time and against travel.

    Of many tests those with the largest error before are shown, held out or not.
    """
    tests = predicted(found)
    errors = [root_mean_square(t.test.force - t.before) / t.test.peak for t in tests]
    worst = np.argsort([-error for error in errors], kind="stable")
    shown = [tests[k] for k in sorted(worst[:MOST])]
    figure = page_figure(140.0)
    axes = figure.subplots(3, len(shown), squeeze=False)
    largest = max(
        float(np.abs(one.test.force - model).max())
        for one in shown
        for model in (one.before, one.after)
    )
    unit, scale = ("N", 1.0) if largest > LARGE else ("mN", 1e3)
    for column, one in zip(axes.T, shown, strict=True):
        _forces(column[0], one)
        clock = "time [s]" if one.test.timed else "sample [–]"
        _residuals(column[1], one, scale, one.test.time, clock)
        _residuals(column[2], one, scale, 1e3 * one.test.travel, "displacement [mm]")
    if len(shown) < len(tests):
        figure.suptitle(f"The {len(shown)} of {len(tests)} tests with the largest error before")
    axes[0, 0].set_ylabel("force [N]")
    for row in (1, 2):
        axes[row, 0].set_ylabel(f"residual [{unit}]")
    entries = {line.get_label(): line for ax in axes[0] for line in ax.get_lines()}
    names = [name for name in ENTRIES if name in entries]
    handles = [entries[name] for name in names]
    figure.legend(handles, names, loc="outside lower center", ncols=len(names))
    return figure


def _forces(ax: Axes, one: Predicted) -> None:
    test, size = one.test, one.size
    travel, force = 1e3 * blocks(test.travel, size), blocks(test.force, size)
    out = test.out(size)
    parts = zip(ENTRIES, (~out, out), ("0.55", "0.8"), strict=False)
    for name, part, grey in parts:
        if part.any():
            ax.plot(travel, np.where(part, force, np.nan), color=grey, lw=2.5, label=name)
    for colour, name, model in zip(colours(2), ENTRIES[2:], (one.before, one.after), strict=True):
        ax.plot(travel, blocks(model, size), color=colour, label=name)
    _keep_near(ax, float(force.min()), float(force.max()), ROOM * float(np.ptp(force)))
    channel = "" if test.channel == FORCE else ", normal force"
    ax.set(title=f"{test.name}\n{spoken(test.mode)}{channel}", xlabel="displacement [mm]")


def _residuals(ax: Axes, one: Predicted, scale: float, across: Array, label: str) -> None:
    band = 2.0 * scale * one.noise
    if np.isfinite(band):
        ax.axhspan(-band, band, color="0.88", lw=0)
    for colour, model in zip(colours(2), (one.before, one.after), strict=True):
        left = scale * blocks(one.test.force - model, one.size)
        ax.plot(blocks(across, one.size), left, color=colour, lw=0.8)
    _keep_near(ax, 0.0, 0.0, ROOM * scale * float(np.ptp(one.test.force)))
    ax.set_xlabel(label)


def _keep_near(ax: Axes, low: float, high: float, room: float) -> None:
    """An axis that ends where a model leaves the measured range far behind."""
    bottom, top = ax.get_ylim()
    ax.set_ylim(max(bottom, low - room), min(top, high + room))
