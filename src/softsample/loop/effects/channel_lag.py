"""The force channel lags behind the travel."""

import numpy as np

from softsample.loop.effects.base import Effect, Parameter
from softsample.loop.specimen import AHEAD

EFFECT = Effect(
    name="channel_lag",
    title="Lag between the channels",
    parameters=(Parameter("lag_ms", "ms", -1e3 * AHEAD, 500.0, 100.0),),
    of_time=True,
    source="Hiti, Measurement: Sensors 38 (2025) 101375",
    signature="shift along the ramp, overshoot at its corners, loop on unloading",
    confused_with=("displacement_zero", "backlash"),
    experiment="the corners of a hold; a second rate",
    instrument=lambda specimen, force, travel, values: np.interp(
        specimen.time - 1e-3 * values["lag_ms"], specimen.time, force
    ),
)
