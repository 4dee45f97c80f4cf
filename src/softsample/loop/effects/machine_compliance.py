"""Frame and cell give way: the sample gets less travel than the machine reports."""

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.specimen import FORCE, Specimen


def _travel(specimen: Specimen, travel: Array, values: Values) -> Array:
    if specimen.channel != FORCE:  # what yields along the displacement yields to that force
        return travel
    return travel - 1e-3 * values["mm_per_N"] * specimen.smooth_force


def _instrument(specimen: Specimen, force: Array, travel: Array, values: Values) -> Array:
    """The cell's noise, which came in with the measured force, goes out again to first order.

    With F(u - c F0) for a measured F0, F = F0 + (F(u - c F0) - F0) / (1 + c k).
    """
    ramp = np.flatnonzero(specimen.phase == "ramp")
    rising = ramp[np.flatnonzero(np.diff(travel[ramp], prepend=-np.inf) > 0.0)]
    if len(rising) < 3:
        return force
    slope = np.interp(travel, travel[rising], np.gradient(force[rising], travel[rising]))
    yielding = 1e-3 * values["mm_per_N"] * np.maximum(slope, 0.0)
    return (force + yielding * specimen.smooth_force) / (1.0 + yielding)


EFFECT = Effect(
    name="machine_compliance",
    title="Compliance of machine and cell",
    parameters=(Parameter("mm_per_N", "mm/N", 0.0, 0.5, 0.05),),
    tier="P",
    source="makers' data of small load cells: 0.1 to 0.5 mm at capacity",
    signature="force low by stiffness times force: compression most, shear least",
    confused_with=("poisson_ratio", "boundary_shift", "ogden_exponents"),
    experiment="a run on a rigid block",
    travel=_travel,
    instrument=_instrument,
)
