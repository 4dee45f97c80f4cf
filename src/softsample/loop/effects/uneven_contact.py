"""The platen meets a rough or uneven face bit by bit: compression only."""

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Specimen, Values

PLACES, WEIGHTS = np.polynomial.legendre.leggauss(8)


def _heights(specimen: Specimen, values: Values) -> tuple[Array, Array]:
    """Columns side by side, their tops spread evenly over the depth below the highest one."""
    return 0.5 * (1e-3 * values["depth_mm"]) * (1.0 + PLACES), 0.5 * WEIGHTS


EFFECT = Effect(
    name="uneven_contact",
    title="Rough or uneven face",
    parameters=(Parameter("depth_mm", "mm", 0.0, 2.0, 0.3),),
    like_geometry=True,
    source="a bed of columns: Johnson, Contact Mechanics, Cambridge 1985, "
    "doi:10.1017/CBO9781139171731",
    signature="a toe as long as the depth, then the curve shifted by half of it",
    confused_with=("late_contact", "platen_tilt", "real_geometry"),
    experiment="scan the face; cut it anew; pressure film",
    modes=("compression",),
    starts=({"depth_mm": 0.5},),
    heights=_heights,
)
