"""The tissue is stiffer, or softer, in shear than the law says from tension and compression."""

from collections.abc import Sequence

from softsample.loop.effects.base import Effect, Parameter, Specimen


def of_tests(tests: Sequence[Specimen]) -> Effect | None:
    """The effect if there are tests in shear and others."""
    return EFFECT if len({specimen.kind == "shear" for specimen in tests}) == 2 else None


EFFECT = Effect(
    name="mode_ratio",
    title="Ratio of shear to axial stiffness",
    parameters=(Parameter("shear_over_axial", "1", 0.6, 1.6, 1.1, neutral=1.0),),
    like_geometry=True,
    source="Budday et al., Acta Biomater. 48 (2017) 319, doi:10.1016/j.actbio.2016.10.036; with "
    "one Ogden term the ratio is 0.80 to 0.98 in brain tissue",
    signature="shear scaled relative to tension and compression",
    confused_with=("tension_compression_asymmetry", "anisotropy", "poisson_ratio"),
    experiment="shear, pull and press one and the same sample",
    modes=("shear",),
    tissue=lambda specimen, force, travel, values: force * values["shear_over_axial"],
)
