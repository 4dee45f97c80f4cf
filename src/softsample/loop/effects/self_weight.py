"""The sample's own weight hangs on the load cell: a constant along the axis."""

from softsample.loop.effects.base import Effect, Parameter

EFFECT = Effect(
    name="self_weight",
    title="Own weight",
    parameters=(Parameter("weight_mN", "mN", -60.0, 60.0, -30.0),),
    source="half the weight of 6 g",
    signature="a constant along the machine's axis in tension and compression, none in shear",
    confused_with=("force_offset", "adhesion"),
    experiment="turn the machine upside down; tare before and after mounting",
    modes=("tension", "compression"),
    instrument=lambda specimen, force, travel, values: (
        force + specimen.axis_sign * 1e-3 * values["weight_mN"]
    ),
)
