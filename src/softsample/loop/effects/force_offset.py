"""The load cell's zero is off."""

from softsample.loop.effects.base import MODES, Effect, Parameter

EFFECT = Effect(
    name="force_offset",
    title="Offset of the force",
    parameters=tuple(Parameter(f"{m}_mN", "mN", -200.0, 200.0, 5.0, kind=m) for m in MODES),
    source="cells of 2.5 N: about 5 mN; one of 50 N at a fifth of a percent: 100 mN",
    signature="a constant, also at rest",
    confused_with=("self_weight", "adhesion"),
    experiment="rest with the platen off the sample, in both orientations",
    instrument=lambda specimen, force, travel, values: (
        force + specimen.axis_sign * 1e-3 * values[f"{specimen.kind}_mN"]
    ),
)
