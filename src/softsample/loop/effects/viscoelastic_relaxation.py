"""The tissue relaxes: quasi-linear viscoelasticity with one or two times."""

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.history import relaxed
from softsample.loop.specimen import Specimen

LEAST_FORCE = 0.02
"""Part of the largest force below which the part that is left of it says nothing."""

LEAST_LOST = 1e-6
"""Part of the modulus that is taken for lost at least: a slope is wanted where none is."""


def _tissue(specimen: Specimen, force: Array, travel: Array, values: Values) -> Array:
    first = relaxed(specimen.time, force, values["g1"], values["tau1_s"])
    if not values["g2"]:
        return first
    second = relaxed(specimen.time, force, values["g2"], values["tau2_s"])
    return first + second - force


def _elastic(specimen: Specimen, fraction: float, travel: Array, values: Values) -> Array:
    """What a bulk modulus that stays adds, by the correspondence of elastic and relaxed.

    With less of its shear modulus the tissue is less compressible: its Poisson's ratio rises. The
    change is proportional to what has relaxed, on the way back too, where that is more than is
    left of the elastic force; how much it is goes by the part of the modulus that is left.
    """
    if not values["bulk"]:
        return np.zeros_like(travel)
    force = specimen.elastic.force_per_mu(fraction, travel)
    lost = force - _tissue(specimen, force, travel, values)
    felt = np.maximum(np.abs(force), LEAST_FORCE * np.abs(force).max())
    most = min(values["g1"] + values["g2"], 1.0)
    part = np.clip(lost * np.sign(force) / felt, LEAST_LOST, max(most, LEAST_LOST))
    return values["bulk"] * specimen.elastic.softer_part(fraction, travel, 1.0 - part) * lost / part


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
    of_time=True,
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
