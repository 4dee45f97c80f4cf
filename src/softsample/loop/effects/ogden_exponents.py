"""Other exponents than the model's."""

from softsample.constitutive.material import Material
from softsample.loop.effects.base import SOLID, Array, Effect, Parameter, Values
from softsample.loop.specimen import Specimen
from softsample.response.pieces import PerturbationSettings

NAMES = ("alpha1", "alpha2")

PARTS = ((0.25, 1.75, 1.25), (0.375, 1.5, 0.875))
"""Range and nominal value of each exponent, as parts of the model's."""


def about(solid: Material) -> Effect:
    """The effect for a model with the exponents of a two-term solid."""

    def elastic(specimen: Specimen, fraction: float, travel: Array, values: Values) -> Array:
        first, second = (
            (values[name] - alpha) / PerturbationSettings.exponent
            * specimen.elastic.change_per_mu(name, fraction, travel)
            for name, alpha in zip(NAMES, solid.alpha, strict=True)
        )  # fmt: skip
        return first + second

    return Effect(
        name="ogden_exponents",
        title="Other exponents",
        parameters=tuple(
            _parameter(name, alpha, *parts)
            for name, alpha, parts in zip(NAMES, solid.alpha, PARTS, strict=True)
        ),
        tier="L",
        source="own runs with each exponent moved by two",
        signature="S-shaped along the stroke, worst at the end of compression, alike on the way "
        "back",
        confused_with=("bond_peel", "late_contact", "machine_compliance"),
        experiment="another mode, or a longer stroke",
        elastic=elastic,
    )


def _parameter(name: str, alpha: float, low: float, high: float, nominal: float) -> Parameter:
    ends = sorted((low * alpha, high * alpha))
    return Parameter(name, "1", ends[0], ends[1], nominal * alpha, neutral=alpha)


EFFECT = about(SOLID)
