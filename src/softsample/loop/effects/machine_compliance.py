"""Frame and cell give way: the sample gets less travel than the machine reports."""

from softsample.loop.effects.base import Effect, Parameter
from softsample.loop.specimen import FORCE

EFFECT = Effect(
    name="machine_compliance",
    title="Compliance of machine and cell",
    parameters=(Parameter("mm_per_N", "mm/N", 0.0, 0.5, 0.05),),
    source="makers' data of small load cells: 0.1 to 0.5 mm at capacity",
    signature="force low in proportion to stiffness times force: compression most, shear least",
    confused_with=("poisson_ratio", "boundary_shift", "ogden_exponents"),
    experiment="a run on a rigid block",
    compliance=lambda specimen, values: (  # what yields along the displacement yields to that force
        1e-3 * values["mm_per_N"] if specimen.channel == FORCE else 0.0
    ),
)
