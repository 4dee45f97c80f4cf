"""The tissue is a foam that changes its volume."""

from softsample.loop.effects.base import Effect, Parameter

WHOLE = 1.0, 1e-4
"""A foam is all of the tissue: what keeps its volume is a thousand times as stiff at half the
height, so that a small share of that would have much of the force."""

MOST_KEPT = 0.45
"""Poisson's ratio from which on a foam is a solid that keeps its volume, as by `elastic_law`."""

EFFECT = Effect(
    name="compressible_foam",
    title="Compressible foam",
    parameters=(
        Parameter("share", "1", 0.0, 1.0, 1.0, limits=(0.0, 1.0), known=WHOLE),
        Parameter("alpha", "1", -45.0, 40.0, 8.0, grid=(-8.0, 4.0, 16.0), inside=True),
        Parameter("nu", "1", 0.0, MOST_KEPT, 0.1, grid=(0.1, 0.35), limits=(0.0,), inside=True),
    ),
    is_law=True,
    has=("poisson_ratio",),
    like_geometry=True,
    source="B. Storakers, J. Mech. Phys. Solids 34 (1986) 125, doi:10.1016/0022-5096(86)90033-5",
    signature="compression far softer than tension and shear; the sides hardly bulge",
    confused_with=("ogden_exponents", "poisson_ratio"),
    experiment="photograph the side walls in compression",
    elastic=lambda specimen, fraction, travel, values: (
        values["share"]
        * specimen.elastic.foam_change_per_mu(fraction, travel, values["alpha"], values["nu"])
    ),
)
