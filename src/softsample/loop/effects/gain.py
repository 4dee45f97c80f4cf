"""The load cell's gain is off: nothing but a scale of the modulus."""

from softsample.loop.effects.base import Effect, Parameter

EFFECT = Effect(
    name="gain",
    title="Gain of the force",
    parameters=(Parameter("gain", "1", -0.1, 0.1, 0.01),),
    source="calibration of cells: 0.1 to 1 %",
    signature="a scale",
    confused_with=("rate_stiffening",),
    experiment="a dead weight",
    identifiable=False,
    instrument=lambda specimen, force, travel, values: force * (1.0 + values["gain"]),
)
