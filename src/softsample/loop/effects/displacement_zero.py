"""The machine's zero of travel is not where the sample starts."""

from softsample.loop.effects.base import MODES, Effect, Parameter

EFFECT = Effect(
    name="displacement_zero",
    title="Wrong zero of displacement",
    parameters=tuple(Parameter(f"{mode}_mm", "mm", -0.5, 0.5, 0.1, kind=mode) for mode in MODES),
    source="estimate",
    signature="force off by stiffness times shift from the start of the ramp on, constant in the "
    "hold",
    confused_with=("late_contact", "channel_lag", "residual_precompression"),
    experiment="longer rest before the ramp with the platen off the sample; unloading through zero",
    travel=lambda specimen, travel, values: travel + 1e-3 * values[f"{specimen.kind}_mm"],
)
