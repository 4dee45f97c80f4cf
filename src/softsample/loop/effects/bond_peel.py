"""The glue lets go while the sample is pulled, for good."""

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Specimen, Values


def _tissue(specimen: Specimen, force: Array, travel: Array, values: Values) -> Array:
    furthest = np.maximum.accumulate(np.clip(travel / specimen.reach, 0.0, None))
    start = values["onset"]
    opened = np.clip((furthest - start) / (1.0 - start), 0.0, None) ** 2
    return force * (1.0 - values["lost"] * opened)


EFFECT = Effect(
    name="bond_peel",
    title="Peeling of the bond",
    parameters=(
        Parameter("lost", "1", 0.0, 0.8, 0.1),
        Parameter("onset", "1", 0.0, 0.8, 0.0, grid=(0.0, 0.5)),
    ),
    source="estimate",
    signature="tension and shear soften towards the end and stay low on unloading",
    confused_with=("mullins_softening", "ogden_exponents", "partial_bond"),
    experiment="load again: low from the start",
    modes=("tension", "shear"),
    tissue=_tissue,
)
