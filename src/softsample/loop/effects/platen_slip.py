"""The sample slips on the moving platen instead of sticking: compression."""

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.specimen import Specimen


def _elastic(specimen: Specimen, mixture: float, travel: Array, values: Values) -> Array:
    return values["share"] * specimen.elastic.change_per_mu("platen_slip", mixture, travel)


EFFECT = Effect(
    name="platen_slip",
    title="Slip on the platen",
    parameters=(Parameter("share", "1", 0.0, 1.0, 0.3),),
    tier="M",
    source="Rashid, Destrade, Gilchrist, J. Mech. Behav. Biomed. Mater. 12 (2012); own runs "
    "without friction",
    signature="compression softer, more so with the stroke",
    confused_with=("tension_compression_asymmetry", "poisson_ratio", "partial_bond"),
    experiment="marks on the edge of the top; glue the compression sample",
    modes=("compression",),
    elastic=_elastic,
)
