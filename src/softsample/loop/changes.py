"""Changes of the elastic force by variants of the model: from their file, for all mixtures."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsample.calibration.curves import CurveFamily
from softsample.protocol import travel_sign

Array = NDArray[np.float64]

TOUCH = 0.02
"""Part of the largest force below which the platen hardly touches, and a part of it says little."""

DEGREE = 5
"""Of the polynomials for changes as parts of the force."""

FIBRES = ("fibres_", "at_size_anisotropy")
"""How names of changes by fibres begin."""

PRESSED, PRESSED_ELSEWHERE = "pressed", "pressed_elsewhere"
"""Shear of a sample that was compressed before, at the mixture of the others and at another one."""


def read_changes(table: pd.DataFrame, family: CurveFamily, mode: str) -> dict[str, Array]:
    """Changes of the force per modulus [m2] on the displacements of a family, from their file."""
    sign = travel_sign(mode)
    travel = 1e-3 * sign * table["displacement_mm"].to_numpy()
    return {
        name.removesuffix("_mm2"): np.interp(
            family.displacement, travel, 1e-6 * sign * table[name].to_numpy()
        )
        for name in table.columns.drop("displacement_mm")
    }


def table_of_changes(
    mode: str, displacement: Array, changes: Mapping[str, Array]
) -> dict[str, Array]:
    """Columns of their file from travels [m] and changes of the force per modulus (n,) [m2]."""
    sign = travel_sign(mode)
    columns = {f"{name}_mm2": 1e6 * sign * change for name, change in changes.items()}
    return {"displacement_mm": 1e3 * sign * displacement, **columns}


def for_all_mixtures(
    changes: Mapping[str, Array], family: CurveFamily, mixture: float
) -> dict[str, CurveFamily]:
    """Changes that were simulated at one mixture, carried to all, without the grain of the mesh.

    A changed term of the solid goes with its part of the modulus, and fibres are beside it; what
    changes shape, boundary or compressibility changes the force by the same part of it. That part
    is smooth along the travel, while nodes of a coarse mesh meet the platen one by one. Of a sample
    that was compressed before, it is taken to be linear in the mixture.

    Parameters
    ----------
    changes : mapping of (n,) float64
        Change of the force per modulus by variant [m2] on the displacements of the family.
    family : CurveFamily
        Force of the unchanged model.
    mixture : float
        At which they were simulated.
    """
    r, there = family.fractions, family.curve(mixture)
    forces = np.stack([family.curve(x) for x in r])
    follows = {
        "alpha1": np.outer(r / mixture, there),
        "alpha2": np.outer((1.0 - r) / (1.0 - mixture), there),
        **{name: np.tile(there, (len(r), 1)) for name in changes if name.startswith(FIBRES)},
    }
    parts = {
        name: _smooth_part(family.displacement, change, there)
        for name, change in changes.items()
        if name != PRESSED_ELSEWHERE
    }
    if PRESSED_ELSEWHERE in changes:
        other = elsewhere(mixture)
        part = _smooth_part(family.displacement, changes[PRESSED_ELSEWHERE], family.curve(other))
        slope = (part - parts[PRESSED]) / (other - mixture)
        parts[PRESSED] = parts[PRESSED] + np.outer(r - mixture, slope)
    return {
        name: CurveFamily(r, family.displacement, follows.get(name, forces) * part)
        for name, part in parts.items()
    }


def _smooth_part(travel: Array, change: Array, force: Array) -> Array:
    """Polynomial (n,) for a change as a part of the force, fitted where there is force."""
    weight = 1.0 / (np.abs(force) + TOUCH * np.abs(force).max())
    powers = np.vander(travel / travel[-1], DEGREE + 1)
    found, *_ = np.linalg.lstsq((weight * force)[:, None] * powers, weight * change, rcond=None)
    return np.asarray(powers @ found)


def elsewhere(mixture: float) -> float:
    """A mixture that differs by a quarter."""
    return mixture + (0.25 if mixture < 0.5 else -0.25)
