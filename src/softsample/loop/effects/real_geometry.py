"""The shape of the sample, where the model is the idealised cuboid."""

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.specimen import Specimen


def _elastic(specimen: Specimen, fraction: float, travel: Array, values: Values) -> Array:
    return values["share"] * specimen.elastic.change_per_mu("real_geometry", fraction, travel)


EFFECT = Effect(
    name="real_geometry",
    title="Real geometry instead of the cuboid",
    parameters=(Parameter("share", "1", 0.5, 1.5, 1.0, known=(1.0, 0.05)),),
    source="Arzemanzadeh, Miller, Wittek: the study; own runs on both geometries",
    signature="compression: late and growing contact; all modes: smaller bonded area",
    confused_with=("late_contact", "platen_tilt", "partial_bond"),
    experiment="image the sample and mesh its surface",
    idealised=True,
    elastic=_elastic,
)
