"""The shape of the sample, where the model is the idealised cuboid."""

from softsample.loop.effects.base import Effect, Parameter

EFFECT = Effect(
    name="real_geometry",
    title="Real geometry instead of the cuboid",
    parameters=(Parameter("share", "1", 0.5, 1.5, 1.0, known=(1.0, 0.05)),),
    source="the study; own runs on both geometries",
    signature="compression: late and growing contact; all modes: smaller bonded area",
    confused_with=("late_contact", "platen_tilt", "partial_bond"),
    experiment="image the sample and mesh its surface",
    idealised=True,
    elastic=lambda specimen, fraction, travel, values: (
        values["share"] * specimen.elastic.change_per_mu("real_geometry", fraction, travel)
    ),
)
