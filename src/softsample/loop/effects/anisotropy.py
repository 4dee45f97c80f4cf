"""Fibres make a direction stiffer."""

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.specimen import Specimen


def _elastic(specimen: Specimen, mixture: float, travel: Array, values: Values) -> Array:
    change = specimen.elastic.change_per_mu
    along = values["k1_along_z"] / 0.1 * change("fibres_z", mixture, travel)
    return along + values["k1_along_x"] / 0.1 * change("fibres_x", mixture, travel)


EFFECT = Effect(
    name="anisotropy",
    title="Fibres",
    parameters=(
        Parameter("k1_along_z", "mu", 0.0, 1.0, 0.1),
        Parameter("k1_along_x", "mu", 0.0, 1.0, 0.0),
    ),
    tier="M",
    source="Jin et al., J. Biomech. 46 (2013) 2795; own runs with k1 (I4 - 1)^2, k1 = mu/10",
    signature="ratio of shear to axial stiffness",
    confused_with=("residual_precompression", "poisson_ratio"),
    experiment="turn the direction of shear by 90 degrees",
    elastic=_elastic,
)
