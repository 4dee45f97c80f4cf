"""The tissue resists compression more, or less, than tension."""

from softsample.loop.effects.base import Effect, Parameter

EFFECT = Effect(
    name="tension_compression_asymmetry",
    title="Asymmetry of tension and compression",
    parameters=(Parameter("more", "1", -0.5, 1.0, 0.1),),
    like_geometry=True,
    source="Mihai, Budday et al., Proc. R. Soc. A 2018, doi:10.1098/rspa.2017.0858",
    signature="compression scaled relative to tension and shear",
    confused_with=("platen_slip", "partial_bond", "poisson_ratio"),
    experiment="compress and pull one and the same bonded sample",
    modes=("compression",),
    tissue=lambda specimen, force, travel, values: force * (1.0 + values["more"]),
)
