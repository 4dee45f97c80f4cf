"""A strip is pulled taut before it bears, and cannot push: tension only."""

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Specimen, Values

TAUT = 0.01
"""Slack, as a part of the largest displacement, from which on a sample bears no push at all."""


def _contact(specimen: Specimen, force: Array, travel: Array, values: Values) -> Array:
    pushing = max(0.0, 1.0 - 1e-3 * values["slack_mm"] / (TAUT * specimen.reach))
    return np.where(force < 0.0, pushing * force, force)


EFFECT = Effect(
    name="slack",
    title="Slack before tension",
    parameters=(Parameter("slack_mm", "mm", 0.0, 2.0, 0.2),),
    source="estimate; strips are mounted slack to avoid stretching them",
    signature="no force at first, then the curve shifted, never a push on unloading",
    confused_with=("displacement_zero", "permanent_set"),
    experiment="raise the pre-load; mark the displacement at which the strip is straight",
    modes=("tension",),
    starts=({"slack_mm": 0.3}, {"slack_mm": 1.0}),
    travel=lambda specimen, travel, values: travel - 1e-3 * values["slack_mm"],
    contact=_contact,
)
