"""Fibres make a direction stiffer."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from softsample.loop.effects.base import Array, Effect, Parameter, Specimen, Values
from softsample.response.changes import MANY, OF_MANY
from softsample.response.memory import remembered

GRID = (-60.0, -30.0, 0.0, 30.0, 60.0, 90.0)
"""Angles [deg] from which a fit sets out."""

FEW = 0.1
"""k1 over mu of the runs with few fibres."""

LEAST_RATIO = 1.2
"""Of the changes by many and by few fibres: at 1 the form would rise to no end."""


def of_tests(tests: Sequence[Specimen]) -> Effect:
    """Fibres in one direction of the material if the study states how it lies in each test."""
    return BY_DIRECTION if all(test.material_z for test in tests) else EFFECT


@remembered
def _by_many(specimen: Specimen, name: str, fraction: float, travel: Array, k1: float) -> Array:
    """Change by fibres in one direction of the runs.

    Few change the force in proportion to k1; of many it rises less and less, since they change the
    deformation: as k1 / (1 + b k1), through the runs with k1 = mu/10 and 2 mu, within 3 % of the
    force at mu and 13 % at 3 mu; of sliding ends 2 and, at 5 mu, 8. Without the second run, in
    proportion.
    """
    few, many = (
        specimen.elastic.change_per_mu(f"fibres_{name}{end}", fraction, travel)
        for end in ("", OF_MANY)
    )
    most = MANY / FEW
    ratio = np.divide(many, few, out=np.full_like(few, most), where=(few != 0.0) & (many != 0.0))
    ratio = np.clip(ratio, LEAST_RATIO, most)
    bent = (most - ratio) / (most * (ratio - 1.0))
    return np.asarray(few * k1 / FEW * (1.0 + bent) / (1.0 + bent * k1 / FEW))


def _change(
    specimen: Specimen, fraction: float, travel: Array, k1: float, c: float, s: float
) -> Array:
    """With fibres that have a part `c` along z and `s` where the shear goes.

    From the runs with fibres along z and x and between them. Few fibres change the force by an
    integral of (a . C a - 1) a a over a deformation that stays: by a form of fourth degree in the
    components of their direction. Its terms in s^3 c and s^4 go with C_xx - 1, which shear of a
    block leaves at nothing; the sign of the angle is nothing to axial tests of one. Shear to the
    other side is the mirror image with fibres that lean the other way.
    """

    def change(name: str) -> Array:
        return _by_many(specimen, name, fraction, travel, k1)

    sheared = specimen.mode == "shear"  # half a turn changes nothing in torsion
    upright, ahead = change("z"), change("ahead")
    lying = np.zeros_like(travel) if sheared else change("x")
    behind = change("behind") if sheared else ahead
    even = 2.0 * (ahead + behind) - upright - lying
    odd = 2.0 * np.sign(travel) * (ahead - behind)
    return np.asarray(c**4 * upright + s**4 * lying + s**2 * c**2 * even + s * c**3 * odd)


def _in_plane(specimen: Specimen, fraction: float, travel: Array, values: Values) -> Array:
    s, c = (f(np.radians(values["angle_deg"])) for f in (np.sin, np.cos))
    return _change(specimen, fraction, travel, values["k1"], c, s)


def _by_direction(specimen: Specimen, fraction: float, travel: Array, values: Values) -> Array:
    """What lies along y is not stretched by shear; to axial tests all that lies is alike."""
    azimuth, elevation = (np.radians(values[name]) for name in ("azimuth_deg", "elevation_deg"))
    lying = np.cos(elevation)
    fibre = lying * np.cos(azimuth), lying * np.sin(azimuth), np.sin(elevation)

    def along(direction: int) -> float:
        return float(np.sign(direction) * fibre[abs(direction) - 1])

    c = along(specimen.material_z)
    s = along(specimen.material_x) if specimen.mode == "shear" else np.sqrt(max(1.0 - c**2, 0.0))
    return _change(specimen, fraction, travel, values["k1"], c, s)


EFFECT = Effect(
    name="anisotropy",
    title="Fibres",
    parameters=(
        Parameter("k1", "mu", 0.0, 1.0, FEW),
        Parameter("angle_deg", "deg", -90.0, 90.0, 0.0, grid=GRID),
    ),
    like_geometry=True,
    beside=True,
    source="Jin et al., J. Biomech. 46 (2013) 2795; own runs with energy k1 (I4 - 1)^2; the angle "
    "is from z towards the direction of shear",
    signature="changes the ratio of shear to axial stiffness",
    confused_with=("residual_precompression", "poisson_ratio"),
    experiment="turn the direction of shear by 90 degrees",
    elastic=_in_plane,
)

BY_DIRECTION = replace(
    EFFECT,
    parameters=(
        Parameter("k1", "mu", 0.0, 5.0, FEW),
        Parameter("azimuth_deg", "deg", -90.0, 90.0, 0.0, grid=GRID),
        Parameter("elevation_deg", "deg", -90.0, 90.0, 0.0, grid=GRID),
    ),
    experiment="shear of a piece that is cut along another direction",
    elastic=_by_direction,
)
"""From direction 1 of the material towards 2 and, out of their plane, towards 3."""
