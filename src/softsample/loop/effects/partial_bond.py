"""Part of the glued surface is not glued: tension and shear."""

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.specimen import Specimen


def _elastic(specimen: Specimen, mixture: float, travel: Array, values: Values) -> Array:
    change = specimen.elastic.change_per_mu
    facing = change("partial_bond_x", mixture, travel)
    along = change("partial_bond_y", mixture, travel)
    return values["missing"] / 0.125 * (facing + values["along"] * (along - facing))


EFFECT = Effect(
    name="partial_bond",
    title="Part of the glue missing",
    parameters=(
        Parameter("missing", "1", 0.0, 0.5, 0.125),
        Parameter("along", "1", 0.0, 1.0, 0.0, grid=(0.0, 1.0)),
    ),
    tier="M",
    source="own finite element runs with an eighth of the glued area taken off, on the sides that "
    "face the shear and on those along it",
    signature="tension and shear scaled down from the start, compression untouched",
    confused_with=("tension_compression_asymmetry", "bond_peel", "platen_slip"),
    experiment="ink on the glue; inspect the detached face",
    modes=("tension", "shear"),
    elastic=_elastic,
)
