"""A tilted platen meets the top from one side: compression only."""

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Specimen, Values


def _elastic(specimen: Specimen, fraction: float, travel: Array, values: Values) -> Array:
    """Turned about x and about y, each by its part of the tilt and with its own sign.

    A top that is not flat lies better against a platen that is tilted one way, and worse against
    one that is tilted the other way.
    """
    axis = np.radians(values["axis_deg"])
    change = np.zeros_like(travel)
    for name, part in (("x", np.cos(axis)), ("y", np.sin(axis))):
        way = name if part > 0.0 else f"minus_{name}"
        change += abs(part) * specimen.elastic.change_per_mu(f"platen_tilt_{way}", fraction, travel)
    return values["tilt_deg"] * change


EFFECT = Effect(
    name="platen_tilt",
    title="Tilted platen",
    parameters=(
        Parameter("tilt_deg", "deg", 0.0, 4.0, 1.0),
        Parameter("axis_deg", "deg", -180.0, 180.0, 0.0, grid=(-135.0, -45.0, 45.0, 135.0)),
    ),
    like_geometry=True,
    source="own runs; `axis_deg` is the angle of the axis from x towards y",
    signature="a toe as long as the width times the tilt",
    confused_with=("late_contact", "real_geometry"),
    experiment="turn the sample by 180 degrees; pressure film",
    modes=("compression",),
    elastic=_elastic,
)
