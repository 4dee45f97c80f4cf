"""The platen meets the sample later than zero travel says: compression only."""

from softsample.loop.effects.base import Effect, Parameter

EFFECT = Effect(
    name="late_contact",
    title="Late contact",
    parameters=(Parameter("gap_mm", "mm", 0.0, 2.0, 0.2),),
    source="Hrapko et al., Biorheology 45 (2008) 663",
    signature="no force at first, then the curve shifted",
    confused_with=("platen_tilt", "displacement_zero", "real_geometry"),
    experiment="bond the compression sample and pull through zero; scan the top",
    modes=("compression",),
    starts=({"gap_mm": 0.3}, {"gap_mm": 1.0}),
    travel=lambda specimen, travel, values: travel - 1e-3 * values["gap_mm"],
)
