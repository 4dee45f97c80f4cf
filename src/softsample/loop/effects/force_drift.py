"""The load cell drifts with the clock."""

from softsample.loop.effects.base import Effect, Parameter

EFFECT = Effect(
    name="force_drift",
    title="Drift of the force",
    parameters=(Parameter("mN_per_s", "mN/s", -2.0, 2.0, 0.1),),
    of_time=True,
    source="makers' creep of load cells; 0.001 to 0.1 mN/s",
    signature="linear in time, the same along the machine's axis in all tests, also without load",
    confused_with=("viscoelastic_relaxation", "dehydration", "poroelastic_drainage"),
    experiment="a run without a sample before and after",
    instrument=lambda specimen, force, travel, values: (
        force + specimen.axis_sign * (1e-3 * values["mN_per_s"] * specimen.clock)
    ),
)
