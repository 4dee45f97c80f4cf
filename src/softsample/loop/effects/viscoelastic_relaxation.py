"""The tissue relaxes: quasi-linear viscoelasticity with one or two times."""

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.history import relaxed
from softsample.loop.specimen import Specimen

LEAST_FORCE = 0.02
"""Part of the largest force below which the part that is left of it says nothing."""


def _tissue(specimen: Specimen, force: Array, travel: Array, values: Values) -> Array:
    first = relaxed(specimen.time, force, values["g1"], values["tau1_s"])
    if not values["g2"]:
        return first
    second = relaxed(specimen.time, force, values["g2"], values["tau2_s"])
    return first + second - force


def _left(force: Array, relaxed_force: Array, least: float) -> Array:
    """Part of the shear modulus that is left (n,), between `least` and all of it."""
    felt = np.abs(force) > LEAST_FORCE * np.abs(force).max()
    left = np.divide(relaxed_force, force, out=np.ones_like(force), where=felt)
    return np.clip(left, least, 1.0)


def _elastic(specimen: Specimen, mixture: float, travel: Array, values: Values) -> Array:
    """What a bulk modulus that stays adds, by the correspondence of elastic and relaxed.

    With less of its shear modulus the tissue is less compressible: its Poisson's ratio rises.
    """
    if not values["bulk"]:
        return np.zeros_like(travel)
    force = specimen.elastic.force_per_mu(mixture, travel)
    after = _tissue(specimen, force, travel, values)
    left = _left(force, after, max(0.0, 1.0 - values["g1"] - values["g2"]))
    return values["bulk"] * specimen.elastic.softer_change_per_mu(mixture, travel, left)


EFFECT = Effect(
    name="viscoelastic_relaxation",
    title="Viscoelastic relaxation",
    parameters=(
        Parameter("g1", "1", 0.0, 0.9, 0.2),
        Parameter("tau1_s", "s", 0.3, 60.0, 8.0, grid=(2.0, 8.0, 25.0)),
        Parameter("g2", "1", 0.0, 0.6, 0.0),
        Parameter("tau2_s", "s", 10.0, 400.0, 80.0, grid=(60.0,)),
        Parameter("bulk", "1", 0.0, 1.0, 1.0, grid=(1.0,)),
    ),
    tier="P",
    source="Budday et al., Acta Biomater. 48 (2017) 319, doi:10.1016/j.actbio.2016.10.036; "
    "bulk modulus: Tschoegl et al., Mech. Time-Depend. Mater. 6 (2002) 3, "
    "doi:10.1023/A:1014411503170",
    signature="concave ramp, decay in the hold of every mode, of shear most; loop on unloading",
    confused_with=("poroelastic_drainage", "force_drift", "mullins_softening"),
    experiment="a hold ten times as long, in shear as well as in compression",
    elastic=_elastic,
    tissue=_tissue,
)
