"""The tissue is a foam that changes its volume."""

from softsample.loop.effects.base import Effect, Parameter

EFFECT = Effect(
    name="compressible_foam",
    title="Compressible foam",
    parameters=(
        Parameter("share", "1", 0.0, 1.0, 1.0, limits=(0.0, 1.0)),
        Parameter("alpha", "1", -45.0, 40.0, 8.0, grid=(-8.0, 4.0, 16.0), inside=True),
        Parameter("nu", "1", 0.0, 0.49, 0.1, grid=(0.1, 0.35), limits=(0.0, 0.49)),
    ),
    is_law=True,
    has=("poisson_ratio",),
    like_floor=True,
    source="B. Storakers, J. Mech. Phys. Solids 34 (1986) 125, doi:10.1016/0022-5096(86)90033-5",
    signature="compression far softer against tension and shear, its sides hardly bulge",
    confused_with=("ogden_exponents", "poisson_ratio"),
    experiment="photograph the side walls in compression",
    elastic=lambda specimen, fraction, travel, values: (
        values["share"]
        * specimen.elastic.foam_change_per_mu(fraction, travel, values["alpha"], values["nu"])
    ),
)
