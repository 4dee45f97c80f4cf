"""A tilted platen meets the top from one side: compression only."""

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.specimen import Specimen


def _elastic(specimen: Specimen, mixture: float, travel: Array, values: Values) -> Array:
    if specimen.mode != "compression":
        return np.zeros_like(travel)
    change = specimen.elastic.change_per_mu
    edge = change("platen_tilt", mixture, travel)
    corner = change("platen_tilt_corner", mixture, travel)
    return values["tilt_deg"] * (edge + values["corner"] * (corner - edge))


EFFECT = Effect(
    name="platen_tilt",
    title="Tilted platen",
    parameters=(
        Parameter("tilt_deg", "deg", 0.0, 4.0, 1.0),
        Parameter("corner", "1", 0.0, 1.0, 0.0, grid=(0.0, 1.0)),
    ),
    tier="M",
    source="own finite element runs of the sample with a platen tilted by one degree, towards an "
    "edge and towards a corner",
    signature="compression only: a toe as long as the width times the tilt",
    confused_with=("late_contact", "real_geometry"),
    experiment="turn the sample by 180 degrees; pressure film",
    modes=("compression",),
    elastic=_elastic,
)
