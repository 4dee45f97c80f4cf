"""Part of the glued surface is not glued: tension and shear."""

from softsample.loop.effects.base import Array, Effect, Parameter, Specimen, Values


def _elastic(specimen: Specimen, fraction: float, travel: Array, values: Values) -> Array:
    change = specimen.elastic.change_per_mu
    facing = abs(values["side"])
    end = change(f"partial_bond_{'ahead' if values['side'] > 0.0 else 'behind'}", fraction, travel)
    beside = change("partial_bond_beside", fraction, travel)
    return values["missing"] / 0.125 * (facing * end + (1.0 - facing) * beside)


EFFECT = Effect(
    name="partial_bond",
    title="Part of the bond missing",
    parameters=(
        Parameter("missing", "1", 0.0, 0.5, 0.125),
        Parameter("side", "1", -1.0, 1.0, 0.0, grid=(-0.75, -0.25, 0.25, 0.75)),
    ),
    like_geometry=True,
    source="own runs; `side` is 1 on the side towards which the shear moves, -1 on the opposite "
    "side, 0 on the others",
    signature="tension and shear scaled down from the start, compression unchanged",
    confused_with=("tension_compression_asymmetry", "bond_peel", "platen_slip"),
    experiment="ink on the adhesive; inspect the detached face",
    modes=("tension", "shear"),
    elastic=_elastic,
)
