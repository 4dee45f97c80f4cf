"""Stiffness grows with the rate; at one single rate that is a scale of the modulus."""

from softsample.loop.effects.base import Effect, Parameter

EFFECT = Effect(
    name="rate_stiffening",
    title="Rate stiffening",
    parameters=(Parameter("per_decade", "1", 0.0, 0.5, 0.15),),
    of_time=True,
    source="Rashid, Destrade, Gilchrist, J. Mech. Behav. Biomed. Mater. 10 (2012) 23",
    signature="scale between rates",
    confused_with=("gain",),
    experiment="the same sample at ten times the rate, as a group of its own: compare the moduli",
    identifiable=False,
    tissue=lambda specimen, force, travel, values: force * (1.0 + values["per_decade"]),
)
