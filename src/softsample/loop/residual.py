"""What was measured beside what the models of a diagnosis predict, as a table."""

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsample.loop.diagnose import Diagnosis
from softsample.loop.fit import Problem
from softsample.loop.noise import block_size, most_blocks
from softsample.loop.specimen import FORCE, Specimen, blocks

Array = NDArray[np.float64]


def residual_table(found: Diagnosis) -> pd.DataFrame:
    """Measured force of every test and the model's, as means over blocks of time.

    Parameters
    ----------
    found : Diagnosis
        Of a group.

    Returns
    -------
    DataFrame
        `sample`, `mode`, `channel`; `time_s`, missing if time was not recorded;
        `displacement_mm`, `force_N`, with the signs of records; `before_N`, `after_N`: force of
        the calibrated model and of the reported one; `held_out`: not fitted.
    """
    models = found.origin.first, (found.problem, found.predicting)
    predicted = [
        [fit.model.predict(test, fit.state) for test in _tests(problem)] for problem, fit in models
    ]
    most = most_blocks(len(found.problem.specimens))
    return pd.concat(
        [
            _residual(test, before, after, block_size(test, found.problem.settings, most))
            for test, before, after in zip(_tests(found.problem), *predicted, strict=True)
        ],
        ignore_index=True,
    )


def _tests(problem: Problem) -> list[Specimen]:
    """Tests that are fitted, then those that are held out as a whole."""
    return [*problem.specimens, *(test for test in problem.unseen if test.held_out.all())]


def _residual(test: Specimen, before: Array, after: Array, size: int) -> pd.DataFrame:
    """Rows of one test, whose blocks have `size` samples."""
    of_force = test.axis_sign if test.channel == FORCE else 1.0
    return pd.DataFrame(
        {
            "sample": test.name,
            "mode": test.mode,
            "channel": test.channel,
            "time_s": blocks(test.time, size) if test.timed else np.nan,
            "displacement_mm": 1e3 * test.axis_sign * blocks(test.travel, size),
            "force_N": of_force * blocks(test.force, size),
            "before_N": of_force * blocks(before, size),
            "after_N": of_force * blocks(after, size),
            "held_out": blocks(test.held_out.astype(float), size) > 0.0,
        }
    )
