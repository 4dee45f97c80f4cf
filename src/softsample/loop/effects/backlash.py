"""Play in the drive: after a reversal the platen follows late."""

from softsample.loop.effects.base import Effect, Parameter
from softsample.loop.history import followed

EFFECT = Effect(
    name="backlash",
    title="Backlash of the drive",
    parameters=(
        Parameter("play_mm", "mm", 0.0, 0.3, 0.03),
        Parameter("ahead", "1", 0.0, 1.0, 0.0, grid=(0.0, 1.0)),
    ),
    source="drives of test machines: 5 to 50 micrometres",
    signature="flat step at the start of the unloading (of the loading, if the play lies ahead), "
    "then the curve shifted",
    confused_with=("mullins_softening", "channel_lag"),
    experiment="small loops back and forth; a gauge on the platen",
    of_past=True,
    travel=lambda specimen, travel, values: followed(
        travel, 1e-3 * values["play_mm"], values["ahead"]
    ),
)
