"""Part of the glued surface is not glued: tension and shear."""

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.specimen import Specimen


def _elastic(specimen: Specimen, mixture: float, travel: Array, values: Values) -> Array:
    return values["missing"] / 0.125 * specimen.elastic.change_per_mu("partial_bond", travel)


EFFECT = Effect(
    name="partial_bond",
    title="Part of the glue missing",
    parameters=(Parameter("missing", "1", 0.0, 0.5, 0.125),),
    tier="M",
    source="own finite element runs with an eighth of the glued area taken off",
    signature="tension and shear scaled down from the start, compression untouched",
    confused_with=("tension_compression_asymmetry", "bond_peel", "platen_slip"),
    experiment="ink on the glue; inspect the detached face",
    modes=("tension", "shear"),
    elastic=_elastic,
)
