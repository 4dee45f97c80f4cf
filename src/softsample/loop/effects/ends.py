"""The ends of the sample slide on the platens where the model bonds them.

It has no size: `softsample.loop.ends` compares the model with sliding ends with the bonded one.
"""

from softsample.loop.effects.base import Effect

EFFECT = Effect(
    name="ends",
    title="Sliding ends",
    parameters=(),
    source="a model of its own, whose ends bear no lateral force",
    signature="softer in every mode, most in compression and for wide samples",
    confused_with=("platen_slip", "poisson_ratio"),
    experiment="lubricate the platens, or bond the ends",
    identifiable=False,
)
