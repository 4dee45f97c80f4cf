"""The sample's own weight hangs on the load cell: a constant along the axis."""

from softsample.loop.effects.base import Effect, Parameter

MOST_MN = 60.0
"""Weight of a sample of 6 g; of a known shape that of its volume takes its place [mN]."""

EFFECT = Effect(
    name="self_weight",
    title="Own weight",
    parameters=(Parameter("weight_mN", "mN", -MOST_MN, MOST_MN, -0.5 * MOST_MN),),
    source="at most all of the weight; half of it of a sample held at both ends",
    signature="a constant along the machine's axis in tension and compression, none in shear",
    confused_with=("force_offset", "adhesion"),
    experiment="turn the machine upside down; tare before and after mounting",
    modes=("tension", "compression"),
    instrument=lambda specimen, force, travel, values: (
        force + specimen.axis_sign * 1e-3 * values["weight_mN"]
    ),
)
