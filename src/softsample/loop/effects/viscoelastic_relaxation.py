"""The tissue relaxes: quasi-linear viscoelasticity with one or two times."""

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.history import relaxed
from softsample.loop.specimen import Specimen


def _tissue(specimen: Specimen, force: Array, travel: Array, values: Values) -> Array:
    first = relaxed(specimen.time, force, values["g1"], values["tau1_s"])
    if not values["g2"]:
        return first
    second = relaxed(specimen.time, force, values["g2"], values["tau2_s"])
    return first + second - force


EFFECT = Effect(
    name="viscoelastic_relaxation",
    title="Viscoelastic relaxation",
    parameters=(
        Parameter("g1", "1", 0.0, 0.9, 0.2),
        Parameter("tau1_s", "s", 0.3, 60.0, 8.0, grid=(2.0, 8.0, 25.0)),
        Parameter("g2", "1", 0.0, 0.6, 0.0),
        Parameter("tau2_s", "s", 10.0, 400.0, 80.0, grid=(60.0,)),
    ),
    tier="P",
    source="Budday et al., Acta Biomater. 48 (2017) 319, doi:10.1016/j.actbio.2016.10.036",
    signature="concave ramp, decay in the hold of every mode alike, loop on unloading",
    confused_with=("poroelastic_drainage", "force_drift", "mullins_softening"),
    experiment="a hold ten times as long, in shear as well as in compression",
    tissue=_tissue,
)
