"""What the pre-load and the rest after it have left: a sample that starts compressed."""

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Specimen, Values


def _elastic(specimen: Specimen, fraction: float, travel: Array, values: Values) -> Array:
    if specimen.kind == "shear":
        return values["d_mm"] / 0.3 * specimen.elastic.change_per_mu("pressed", fraction, travel)
    start = values["d_mm"] * 1e-3 * -specimen.axis_sign
    force = specimen.elastic.force_per_mu
    shifted = force(fraction, travel + start) - force(fraction, np.full_like(travel, start))
    return shifted - force(fraction, travel)


EFFECT = Effect(
    name="residual_precompression",
    title="Compression left over from the pre-load",
    parameters=(Parameter("d_mm", "mm", 0.0, 1.0, 0.3),),
    source="Zhang et al., Adv. Mech. Eng. 10 (2018), doi:10.1177/1687814018795045; own runs of "
    "shear",
    signature="compression steeper, tension softer at the start, no force at zero displacement; "
    "shear scaled by a few percent",
    confused_with=("anisotropy", "poisson_ratio", "displacement_zero"),
    experiment="record the force during pre-load and rest; shear before and after",
    starts=({"d_mm": 0.5},),
    elastic=_elastic,
)
