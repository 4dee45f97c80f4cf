"""Record and model before and after the loop, and what is left over."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from softsample.figures.style import colours, page_figure, spoken, styled
from softsample.loop.diagnose import Diagnosis
from softsample.loop.specimen import Specimen, blocks

Array = NDArray[np.float64]

MOST = 5
"""Tests that a figure shows at most: the worst, in the order of the study."""

LARGE = 1.0
"""Residual [N] from which on it is drawn in N, else in mN."""


@styled
def loop_figure(found: Diagnosis) -> Figure:
    """One column a test: force against travel, residual against time and against travel.

    Of many tests those with the largest error before are shown.
    """
    specimens, labels = found.problem.specimens, found.problem.labels
    errors = [found.origin.before.fitted[label]["all"] for label in labels]
    worst = np.argsort([-np.nan_to_num(error.rms / error.peak) for error in errors], kind="stable")
    shown = sorted(map(int, worst[:MOST]))
    figure = page_figure(140.0)
    axes = figure.subplots(3, len(shown), squeeze=False)
    (first, plain), after = found.origin.first, found.predicting
    models = {
        "before": first.predicted(plain.model, plain.state),
        "after": found.problem.predicted(after.model, after.state),
    }
    largest = max(
        float(np.abs(specimens[k].force - model[k]).max())
        for k in shown
        for model in models.values()
    )
    unit, scale = ("N", 1.0) if largest > LARGE else ("mN", 1e3)
    for column, k in zip(axes.T, shown, strict=True):
        specimen, size = specimens[k], found.problem.whiteners[k].size
        forces = {name: model[k] for name, model in models.items()}
        _forces(column[0], specimen, forces, size)
        left = {name: scale * (specimen.force - model) for name, model in forces.items()}
        band = scale * found.noises[k].block
        clock = "time [s]" if specimen.timed else "sample [–]"
        for row, label in ((1, clock), (2, "travel [mm]")):
            across = specimen.time if row == 1 else 1e3 * specimen.travel
            _residuals(column[row], left, size, across, band)
            column[row].set_xlabel(label)
    if len(shown) < len(specimens):
        figure.suptitle(f"The {len(shown)} of {len(specimens)} tests with the largest error before")
    axes[0, 0].set_ylabel("force [N]")
    for row in (1, 2):
        axes[row, 0].set_ylabel(f"residual [{unit}]")
    entries = {line.get_label(): line for ax in axes[0] for line in ax.get_lines()}
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=len(entries))
    return figure


def _forces(ax: Axes, specimen: Specimen, forces: dict[str, Array], size: int) -> None:
    travel, force = 1e3 * blocks(specimen.travel, size), blocks(specimen.force, size)
    out = blocks(specimen.held_out.astype(float), size) > 0.0
    ax.plot(travel, np.where(out, np.nan, force), color="0.55", lw=2.5, label="measured")
    if out.any():
        ax.plot(travel, np.where(out, force, np.nan), color="0.8", lw=2.5, label="held out")
    for colour, (name, model) in zip(colours(2), forces.items(), strict=True):
        ax.plot(travel, blocks(model, size), color=colour, label=name)
    ax.set(title=f"{specimen.name}\n{spoken(specimen.mode)}", xlabel="travel [mm]")


def _residuals(ax: Axes, left: dict[str, Array], size: int, across: Array, band: float) -> None:
    ax.axhspan(-2.0 * band, 2.0 * band, color="0.88", lw=0)
    for colour, residual in zip(colours(2), left.values(), strict=True):
        ax.plot(blocks(across, size), blocks(residual, size), color=colour, lw=0.8)
