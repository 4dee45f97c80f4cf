"""The tissue is softer on unloading than on the virgin curve, whatever the pace."""

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Specimen, Values


def _tissue(specimen: Specimen, force: Array, travel: Array, values: Values) -> Array:
    """Below the largest displacement so far, either way; on the virgin curve from there on."""
    out = np.abs(travel)
    reached = out / np.maximum(np.maximum.accumulate(out), 1e-9)
    return force * (1.0 - values["d"] * (1.0 - reached ** values["power"]))


EFFECT = Effect(
    name="mullins_softening",
    title="Softening by the first loading (Mullins)",
    parameters=(
        Parameter("d", "1", 0.0, 0.95, 0.2),
        Parameter("power", "1", 0.5, 10.0, 1.0, grid=(1.0, 3.0, 6.0)),
    ),
    source="Ogden, Roxburgh, Proc. R. Soc. A 455 (1999) 2861, doi:10.1098/rspa.1999.0431",
    signature="ramp and hold unchanged, unloading low except near the largest displacement",
    confused_with=("viscoelastic_relaxation", "backlash", "bond_peel"),
    experiment="a second cycle to a larger displacement, and a second rate",
    of_past=True,
    tissue=_tissue,
)
