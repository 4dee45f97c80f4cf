"""What the loop answered, by ground truth, as shares of the experiments."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from softsample.figures.style import page_figure, styled

KEYS = ["design", "floor_percent", "planted"]


@styled
def confusion_figure(table: pd.DataFrame) -> Figure:
    """A matrix in percent for each floor of design B; rows are the ground truth; 100 is no number.

    Parameters
    ----------
    table : DataFrame
        As of `softsample.blindlab.score.confusion`.
    """
    of_design = table[table["design"] == "B"]
    floors = list(of_design.groupby("floor_percent"))
    figure = page_figure(150.0)
    axes = figure.subplots(1, len(floors), squeeze=False, sharey=True)[0]
    for ax, (floor, part) in zip(axes, floors, strict=True):
        _matrix(ax, part.set_index("planted").drop(columns=KEYS[:2]))
        ax.set_title(f"model discrepancy {floor:g} % of peak")
    axes[0].set_ylabel("ground truth")
    figure.supxlabel("answer", size=8.0)
    return figure


def _matrix(ax: Axes, shares: pd.DataFrame) -> None:
    known = [name for name in shares.columns if name in shares.index]
    shares = shares.loc[[*known, *shares.index.difference(known)]]
    ax.imshow(shares.to_numpy(), cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    for i, row in enumerate(shares.to_numpy()):
        for j, value in enumerate(row):
            if 0.0 < value < 1.0:
                ink = "white" if value > 0.6 else "black"
                ax.text(j, i, f"{100 * value:.0f}", ha="center", va="center", color=ink, size=4.5)
    ax.set_yticks(range(len(shares)), [str(name).replace("_", " ") for name in shares.index])
    labels = [str(name).replace("_", " ") for name in shares.columns]
    ax.set_xticks(range(len(labels)), labels, rotation=90)
    ax.tick_params(labelsize=6.0, length=0.0)
    ax.set_xticks(np.arange(len(labels) + 1) - 0.5, minor=True)
    ax.set_yticks(np.arange(len(shares) + 1) - 0.5, minor=True)
    ax.grid(which="minor", color="0.9", lw=0.3)
    ax.tick_params(which="minor", length=0.0)
