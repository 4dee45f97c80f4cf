"""The segmented surface lies too far out or in."""

from softsample.loop.effects.base import Effect, Parameter

EFFECT = Effect(
    name="boundary_shift",
    title="Surface too far out or in",
    parameters=(Parameter("shift_mm", "mm", -0.3, 0.3, 0.1),),
    like_geometry=True,
    source="half a voxel; own runs",
    signature="compression and tension slightly scaled, shear nearly unchanged",
    confused_with=("poisson_ratio", "machine_compliance"),
    experiment="weigh the sample: volume is mass over density",
    elastic=lambda specimen, fraction, travel, values: (
        values["shift_mm"]
        / 0.1
        * specimen.elastic.change_per_mu("boundary_shift", fraction, travel)
    ),
)
