"""The wet sample pulls the platen in before it presses."""

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Specimen, Values


def _instrument(specimen: Specimen, force: Array, travel: Array, values: Values) -> Array:
    reach = 1e-3 * values["range_mm"]
    return force - 1e-3 * values["force_mN"] * np.exp(-np.abs(travel) / reach)


EFFECT = Effect(
    name="adhesion",
    title="Adhesion at first contact",
    parameters=(
        Parameter("force_mN", "mN", 0.0, 60.0, 5.0),
        Parameter("range_mm", "mm", 0.03, 1.0, 0.15, grid=(0.1, 0.3)),
    ),
    source="adhesion hysteresis test, PMC5906650; 0.01 to 0.1 J/m2",
    signature="a pull near zero displacement, gone within 0.3 mm, that returns at the end",
    confused_with=("force_offset", "late_contact"),
    experiment="approach and retract in a loop",
    modes=("compression",),
    instrument=_instrument,
)
