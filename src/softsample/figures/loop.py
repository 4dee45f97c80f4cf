"""Record and model before and after the loop, and what is left over."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from softsample.figures.style import colours, page_figure, spoken, styled
from softsample.loop.diagnose import Diagnosis
from softsample.loop.specimen import Specimen, blocks

Array = NDArray[np.float64]

MOST = 6
"""Tests that a figure shows at most: the worst, in the order of the study."""


@styled
def loop_figure(found: Diagnosis) -> Figure:
    """One column a test: force against travel, residual against time and against travel.

    Of many tests those with the largest error before are shown.
    """
    specimens, labels = found.problem.specimens, found.problem.labels
    errors = [found.before.fitted[label]["all"] for label in labels]
    worst = np.argsort([-np.nan_to_num(error.rms / error.peak) for error in errors], kind="stable")
    shown = sorted(map(int, worst[:MOST]))
    figure = page_figure(140.0)
    axes = figure.subplots(3, len(shown), squeeze=False)
    (first, plain), after = found.first, found.predicting
    models = {
        "before": first.predicted(plain.model, plain.state),
        "after": found.problem.predicted(after.model, after.state),
    }
    for column, k in zip(axes.T, shown, strict=True):
        specimen, size = specimens[k], found.problem.whiteners[k].size
        forces = {name: model[k] for name, model in models.items()}
        _forces(column[0], specimen, forces, size)
        band = 1e3 * found.noises[k].block
        clock = "time [s]" if specimen.timed else "sample [–]"
        for row, label in ((1, clock), (2, "travel [mm]")):
            across = specimen.time if row == 1 else 1e3 * specimen.travel
            _residuals(column[row], specimen, forces, size, across, band)
            column[row].set_xlabel(label)
    if len(shown) < len(specimens):
        figure.suptitle(f"The {len(shown)} of {len(specimens)} tests with the largest error before")
    axes[0, 0].set_ylabel("force [N]")
    axes[0, 0].legend()
    for row in (1, 2):
        axes[row, 0].set_ylabel("residual [mN]")
    return figure


def _forces(ax: Axes, specimen: Specimen, forces: dict[str, Array], size: int) -> None:
    travel = 1e3 * blocks(specimen.travel, size)
    ax.plot(travel, blocks(specimen.force, size), color="0.6", lw=2.5, label="measured")
    for colour, (name, model) in zip(colours(2), forces.items(), strict=True):
        ax.plot(travel, blocks(model, size), color=colour, label=name)
    ax.set(title=f"{specimen.name}, {spoken(specimen.mode)}", xlabel="travel [mm]")


def _residuals(
    ax: Axes,
    specimen: Specimen,
    forces: dict[str, Array],
    size: int,
    across: Array,
    band: float,
) -> None:
    ax.axhspan(-2.0 * band, 2.0 * band, color="0.88", lw=0)
    for colour, model in zip(colours(2), forces.values(), strict=True):
        left = 1e3 * blocks(specimen.force - model, size)
        ax.plot(blocks(across, size), left, color=colour, lw=0.8)
