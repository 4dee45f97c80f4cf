"""Fibres make a direction stiffer."""

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Values
from softsample.loop.specimen import Specimen


def _elastic(specimen: Specimen, fraction: float, travel: Array, values: Values) -> Array:
    """At any angle in the x-z plane, from the runs with fibres along z and x and between them.

    Few fibres change the force by an integral of (a . C a - 1) a a over a deformation that stays:
    by a form of fourth degree in sine and cosine of their angle. Its terms in s^3 c and s^4 go with
    C_xx - 1, which shear of a block leaves at nothing; the sign of the angle is nothing to axial
    tests of one.
    """

    def change(name: str) -> Array:
        return specimen.elastic.change_per_mu(f"fibres_{name}", fraction, travel)

    sheared = specimen.mode == "shear"  # half a turn changes nothing in torsion
    upright, ahead = change("z"), change("ahead")
    lying = np.zeros_like(travel) if sheared else change("x")
    behind = change("behind") if sheared else ahead
    s, c = (f(np.radians(values["angle_deg"])) for f in (np.sin, np.cos))
    even = 2.0 * (ahead + behind) - upright - lying
    odd = 2.0 * (ahead - behind)
    form = c**4 * upright + s**4 * lying + s**2 * c**2 * even + s * c**3 * odd
    return np.asarray(values["k1"] / 0.1 * form)


EFFECT = Effect(
    name="anisotropy",
    title="Fibres",
    parameters=(
        Parameter("k1", "mu", 0.0, 1.0, 0.1),
        Parameter("angle_deg", "deg", -90.0, 90.0, 0.0, grid=(-60.0, -30.0, 0.0, 30.0, 60.0, 90.0)),
    ),
    tier="M",
    like_floor=True,
    source="Jin et al., J. Biomech. 46 (2013) 2795; own runs with k1 (I4 - 1)^2, k1 = mu/10, along "
    "z, x and the diagonals; the angle is that from z to where the shear goes",
    signature="ratio of shear to axial stiffness",
    confused_with=("residual_precompression", "poisson_ratio"),
    experiment="turn the direction of shear by 90 degrees",
    elastic=_elastic,
)
