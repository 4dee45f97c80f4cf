"""Other exponents than the study's."""

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.specimen import Specimen


def _elastic(specimen: Specimen, mixture: float, travel: Array, values: Values) -> Array:
    change = specimen.elastic.change_per_mu
    first = (values["alpha1"] + 8.0) / 2.0 * change("alpha1", mixture, travel)
    return first + (values["alpha2"] - 16.0) / 2.0 * change("alpha2", mixture, travel)


EFFECT = Effect(
    name="ogden_exponents",
    title="Other exponents",
    parameters=(
        Parameter("alpha1", "1", -14.0, -2.0, -10.0, neutral=-8.0),
        Parameter("alpha2", "1", 6.0, 24.0, 14.0, neutral=16.0),
    ),
    tier="L",
    source="own runs with each exponent moved by two",
    signature="S-shaped along the stroke, worst at the end of compression, alike on the way back",
    confused_with=("bond_peel", "late_contact", "machine_compliance"),
    experiment="another mode, or a longer stroke",
    elastic=_elastic,
)
