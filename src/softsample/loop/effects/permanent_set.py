"""After its first loading the sample does not come back to its length."""

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Specimen, Values
from softsample.loop.history import turned


def _travel(specimen: Specimen, travel: Array, values: Values) -> Array:
    """It pulls or presses nothing at `set` of its largest displacement, unloading being
    stretched in between; a loading as far to the other side takes the set back.
    """
    furthest = turned(travel)
    off = values["set"] / (1.0 - values["set"])
    return travel - off * np.sign(furthest) * (np.abs(furthest) - np.abs(travel))


EFFECT = Effect(
    name="permanent_set",
    title="Permanent set",
    parameters=(Parameter("set", "1", 0.0, 0.9, 0.05),),
    source="residual strain after unloading: Dorfmann, Ogden, Int. J. Solids Struct. 41 (2004) "
    "1855, doi:10.1016/j.ijsolstr.2003.11.014",
    signature="ramp unchanged; on unloading the force vanishes early, and the next loading begins "
    "there",
    confused_with=("mullins_softening", "unloading_loss", "displacement_zero", "backlash"),
    experiment="measure the sample before and after; a second cycle after a long rest",
    of_past=True,
    travel=_travel,
)
