"""Misfits of measured records: what verdicts leave over, as errors for the blind laboratory."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from softsample.arrays import Array, root_mean_square
from softsample.io import read_table

TRAVELS = np.linspace(0.0, 1.0, 41)
"""Parts of the stroke at which a misfit is stated."""

FEWEST = 20
"""Points of a record below which its misfit has no shape to speak of."""

MOST = 3
"""Records of a group, whose misfits are alike."""


def misfit_table(results: Path) -> pd.DataFrame:
    """What the models of all verdicts leave over on the way to the largest displacement fitted.

    Parameters
    ----------
    results
        Folder with the results of each study, `{study}/loop/{group}/residual.csv`.

    Returns
    -------
    DataFrame
        One row a record: `study`, `group`, `sample`, `mode`, `rms_percent` (of the peak), and the
        misfit over its RMS at `TRAVELS`, which name the columns.
    """
    return pd.DataFrame(_misfits(results))


def _misfits(results: Path) -> Iterator[dict[str, Any]]:
    for path in sorted(results.glob("*/loop/*/residual.csv")):
        records = read_table(path).groupby(["sample", "mode", "channel"])
        for (sample, mode, _), record in [*records][:MOST]:
            misfit = _misfit(record)
            rms = root_mean_square(misfit)
            if not rms > 0.0:
                continue
            yield {
                "study": path.parents[2].name,
                "group": path.parent.name,
                "sample": sample,
                "mode": mode,
                "rms_percent": 100.0 * rms / float(record["force_N"].abs().max()),
                **dict(zip((f"{x:g}" for x in TRAVELS), misfit / rms, strict=True)),
            }


def _misfit(record: pd.DataFrame) -> Array:
    """Misfit at `TRAVELS` [N] of the direction that goes further; zero if it has too few points."""
    fitted = record[~record["held_out"]]
    travel = fitted["displacement_mm"]
    travel = travel if travel.max() > -0.5 * travel.min() else -travel
    travel = travel[travel >= 0.0]
    there = travel.loc[: travel.idxmax()] if len(travel) else travel
    there = there[there >= there.cummax()]
    if len(there) < FEWEST:
        return np.zeros_like(TRAVELS)
    left = (fitted["force_N"] - fitted["after_N"])[there.index]
    return np.interp(TRAVELS, there / there.max(), left)
