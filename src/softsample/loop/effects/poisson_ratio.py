"""The tissue is more, or less, compressible than the model."""

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.specimen import Specimen


def _elastic(specimen: Specimen, mixture: float, travel: Array, values: Values) -> Array:
    change = specimen.elastic.change_per_mu
    x = (0.49 - values["nu"]) / 0.02
    once, twice = change("poisson_0.47", mixture, travel), change("poisson_0.45", mixture, travel)
    return x * (2.0 - x) * once + 0.5 * x * (x - 1.0) * twice


EFFECT = Effect(
    name="poisson_ratio",
    title="Another Poisson's ratio",
    parameters=(Parameter("nu", "1", 0.40, 0.498, 0.48, neutral=0.49),),
    tier="L",
    source="Hinrichsen et al., Biomech. Model. Mechanobiol. 2023, doi:10.1007/s10237-023-01739-w",
    signature="compression far more than tension, tension more than shear; grows with the stroke",
    confused_with=("anisotropy", "boundary_shift", "residual_precompression", "machine_compliance"),
    experiment="photograph the bulge of the side walls",
    elastic=_elastic,
)
