"""The load cell's gain is off: nothing but a scale of the modulus."""

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.specimen import Specimen


def _instrument(specimen: Specimen, force: Array, travel: Array, values: Values) -> Array:
    return force * (1.0 + values["gain"])


EFFECT = Effect(
    name="gain",
    title="Gain of the force",
    parameters=(Parameter("gain", "1", -0.1, 0.1, 0.01),),
    source="calibration of cells: 0.1 to 1 %",
    signature="a scale",
    confused_with=("rate_stiffening",),
    experiment="a dead weight",
    identifiable=False,
    instrument=_instrument,
)
