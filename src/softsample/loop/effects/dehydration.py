"""The tissue dries: stiffness grows with the clock, not with the stroke."""

from softsample.loop.effects.base import Effect, Parameter

EFFECT = Effect(
    name="dehydration",
    title="Drying of the tissue",
    parameters=(Parameter("per_100_s", "1", 0.0, 0.3, 0.03),),
    of_time=True,
    source="Forte et al., porcine brain hydration, Bioengineering 6 (2019) 40",
    signature="force grows in proportion to itself, in ramp and hold alike",
    confused_with=("force_drift", "viscoelastic_relaxation", "poroelastic_drainage"),
    experiment="order of the tests drawn by lot; humid chamber; weigh before and after",
    tissue=lambda specimen, force, travel, values: (
        force * (1.0 + values["per_100_s"] * 0.01 * specimen.clock)
    ),
)
