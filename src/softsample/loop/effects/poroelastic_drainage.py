"""Fluid leaves the compressed or stretched tissue, slowly; shear keeps its volume."""

from softsample.loop.effects.base import Effect, Parameter
from softsample.loop.history import drained

EFFECT = Effect(
    name="poroelastic_drainage",
    title="Poroelastic drainage",
    parameters=(
        Parameter("g", "1", 0.0, 0.7, 0.1),
        Parameter("tau_s", "s", 40.0, 3000.0, 300.0, grid=(80.0, 300.0)),
    ),
    of_time=True,
    source="Greiner et al., Front. Mech. Eng. 7 (2021) 708350, doi:10.3389/fmech.2021.708350",
    signature="slow decay in the hold of tension and compression, none in shear",
    confused_with=("viscoelastic_relaxation", "force_drift", "dehydration"),
    experiment="hold in shear beside hold in compression; samples of two sizes",
    modes=("tension", "compression"),
    tissue=lambda specimen, force, travel, values: drained(
        specimen.time, force, values["g"], values["tau_s"]
    ),
)
