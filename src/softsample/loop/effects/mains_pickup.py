"""Mains hum, folded by the sampling to a slow beat."""

import numpy as np

from softsample.loop.effects.base import MODES, Array, Effect, Parameter, Specimen, Values


def _instrument(specimen: Specimen, force: Array, travel: Array, values: Values) -> Array:
    angle = 2.0 * np.pi * specimen.clock / values["period_s"]
    for part, of in (("sin", np.sin), ("cos", np.cos)):
        size = values[f"{specimen.kind}_{part}_mN"]
        if size:  # most signatures are those of another mode, and there are many periods
            force = force + 1e-3 * size * of(angle)
    return force


PERIODS = tuple(90.0 / k for k in range(2, 91))

EFFECT = Effect(
    name="mains_pickup",
    title="Mains pickup",
    parameters=(
        *(
            Parameter(f"{mode}_{part}_mN", "mN", -20.0, 20.0, 2.0, kind=mode)
            for mode in MODES
            for part in ("sin", "cos")
        ),
        Parameter("period_s", "s", 0.8, 70.0, 10.0, PERIODS, inside=True),
    ),
    source="100 Hz ripple sampled at 100 Hz",
    signature="a sine of constant amplitude, also at rest",
    confused_with=("force_drift", "viscoelastic_relaxation"),
    experiment="another sampling rate; an analogue low-pass",
    instrument=_instrument,
)
