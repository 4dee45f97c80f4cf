"""What was measured beside what the models of a diagnosis predict."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from softsample.loop.diagnose import Diagnosis
from softsample.loop.noise import block_size, most_blocks
from softsample.loop.specimen import FORCE, Array, Specimen, blocks


@dataclass(frozen=True)
class Predicted:
    """Record of a test beside the forces of the model without effects and of the reported one.

    Parameters
    ----------
    test : Specimen
        The test.
    before, after : (n,) float64
        Of the models [N].
    size : int
        Samples in a block.
    noise : float
        Standard deviation of a block [N]; NaN if the test is held out as a whole.
    """

    test: Specimen
    before: Array
    after: Array
    size: int
    noise: float


def predicted(found: Diagnosis) -> list[Predicted]:
    """Tests of a group that are fitted, then the others."""
    first, problem, last = found.origin.posed.first, found.posed.problem, found.predicting
    most, noises = most_blocks(len(problem.specimens)), found.posed.spread
    fitted = {(test.name, test.channel) for test in problem.specimens}
    pairs = [
        [*of.specimens, *(s for s in of.unseen if (s.name, s.channel) not in fitted)]
        for of in (first.problem, problem)
    ]
    noises += [np.nan] * (len(pairs[0]) - len(noises))
    return [
        Predicted(
            test,
            first.model.predict(before, first.state),
            last.model.predict(test, last.state),
            block_size(test, problem.settings, most),
            noise,
        )
        for before, test, noise in zip(*pairs, noises, strict=True)
    ]


def residual_table(found: Diagnosis) -> pd.DataFrame:
    """Measured force of every test and the model's, as means over blocks of time.

    Returns
    -------
    DataFrame
        `sample`, `mode`, `channel`; `time_s`, missing if time was not recorded;
        `displacement_mm`, `force_N`, with the signs of records; `before_N`, `after_N`: force of
        the model without effects and of the reported one; `held_out`: not fitted.
    """
    return pd.concat([_rows(one) for one in predicted(found)], ignore_index=True)


def _rows(one: Predicted) -> pd.DataFrame:
    test, size = one.test, one.size
    of_force = test.axis_sign if test.channel == FORCE else 1.0
    return pd.DataFrame(
        {
            "sample": test.name,
            "mode": test.mode,
            "channel": test.channel,
            "time_s": blocks(test.time, size) if test.timed else np.nan,
            "displacement_mm": 1e3 * test.axis_sign * blocks(test.travel, size),
            "force_N": of_force * blocks(test.force, size),
            "before_N": of_force * blocks(one.before, size),
            "after_N": of_force * blocks(one.after, size),
            "held_out": test.out(size),
        }
    )
