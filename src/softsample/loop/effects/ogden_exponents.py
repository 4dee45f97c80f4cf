"""Other exponents than the model's."""

from softsample.constitutive.material import Material
from softsample.loop.effects.base import SOLID, Effect, Parameter

NAMES = ("alpha1", "alpha2")

RANGES = ((-45.0, -0.5), (0.5, 40.0))
"""Of an exponent by its sign."""

NOMINAL = (1.25, 0.875)
"""Nominal value of each exponent, as a part of the model's."""

STARTS = ((-20.0, 20.0), (-3.0, 2.0), (-20.0, 2.0))
"""Exponents from which a fit sets out too: a steep term, a flat one, and one of each."""


def about(solid: Material) -> Effect:
    """The effect for a model with the exponents of a two-term solid."""
    parameters = tuple(map(_parameter, NAMES, solid.alpha, NOMINAL))
    return Effect(
        name="ogden_exponents",
        title="Other exponents",
        parameters=parameters,
        starts=tuple(
            {p.name: min(max(x, p.low), p.high) for p, x in zip(parameters, start, strict=True)}
            for start in STARTS
        ),
        is_law=True,
        like_geometry=True,
        source="R. W. Ogden, Proc. R. Soc. Lond. A 326 (1972) 565, doi:10.1098/rspa.1972.0026",
        signature="S-shaped along the stroke, largest at the end of compression, the same on "
        "unloading",
        confused_with=("bond_peel", "compressible_foam", "late_contact", "machine_compliance"),
        experiment="another mode, or a longer stroke",
        elastic=lambda specimen, fraction, travel, values: specimen.elastic.exponents_change_per_mu(
            fraction, travel, [values[n] for n in NAMES]
        ),
    )


def _parameter(name: str, alpha: float, nominal: float) -> Parameter:
    low, high = RANGES[int(alpha > 0.0)]
    return Parameter(name, "1", low, high, nominal * alpha, neutral=alpha)


EFFECT = about(SOLID)
