"""The tissue bears less on unloading, whatever the speed, and all of it when loaded again."""

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Specimen, Values
from softsample.loop.history import followed


def _tissue(specimen: Specimen, force: Array, travel: Array, values: Values) -> Array:
    """The loss grows along a parabola over its reach back from a turn, and goes the same way."""
    reach, out = values["reach"] * specimen.reach, np.abs(travel)
    back = (followed(out, reach) - out) / reach
    return force * (1.0 - values["loss"] * back * (2.0 - back))


EFFECT = Effect(
    name="unloading_loss",
    title="Loss of force on unloading",
    parameters=(
        Parameter("loss", "1", 0.0, 0.9, 0.1),
        Parameter("reach", "1", 0.02, 1.0, 0.2, grid=(0.1, 0.4)),
    ),
    source="a play operator: Visintin, Differential Models of Hysteresis, Springer 1994; measured "
    "cryogels lose 19 %",
    signature="ramp and hold unchanged, unloading low by a constant part of the force soon after "
    "the turn; a second loading has the full force",
    confused_with=("mullins_softening", "viscoelastic_relaxation", "permanent_set", "backlash"),
    experiment="a second cycle: its loading is low after softening; a second rate",
    of_past=True,
    tissue=_tissue,
)
