"""A share of the tissue's modulus follows one Ogden term of another exponent than the model's."""

from softsample.loop.effects.base import Effect, Parameter

GRID = (-35.0, -20.0, -4.0, 2.0, 8.0, 20.0, 35.0)

EFFECT = Effect(
    name="elastic_law",
    title="Another Ogden term",
    parameters=(
        Parameter("share", "1", 0.0, 1.0, 1.0, limits=(0.0, 1.0)),
        Parameter("alpha", "1", -45.0, 40.0, -20.0, GRID, inside=True),
    ),
    is_law=True,
    like_geometry=True,
    source="R. W. Ogden, Proc. R. Soc. Lond. A 326 (1972) 565, doi:10.1098/rspa.1972.0026",
    signature="the same error in loading and unloading, in every mode, growing along the stroke",
    confused_with=("ogden_exponents", "compressible_foam"),
    experiment="another mode, or a longer stroke",
    elastic=lambda specimen, fraction, travel, values: (
        values["share"] * specimen.elastic.one_term_change_per_mu(fraction, travel, values["alpha"])
    ),
)
