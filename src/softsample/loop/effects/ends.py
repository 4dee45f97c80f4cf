"""The ends of the sample slide on the platens where the model bonds them."""

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.specimen import Specimen
from softsample.response.perturbations import ENDS


def _elastic(specimen: Specimen, fraction: float, travel: Array, values: Values) -> Array:
    return values["share"] * specimen.elastic.change_per_mu(ENDS, fraction, travel)


EFFECT = Effect(
    name="ends",
    title="Sliding ends",
    parameters=(Parameter("share", "1", 0.0, 1.0, 1.0, limits=(0.0, 1.0)),),
    tier="L",
    source="own runs with ends that bear no lateral force",
    signature="softer in every mode, of wide samples and in compression most",
    confused_with=("platen_slip", "poisson_ratio"),
    experiment="lubricate the platens, or bond the ends",
    elastic=_elastic,
)
