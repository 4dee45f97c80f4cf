"""Changes of the elastic force by variants of the model: from their file, for all fractions."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from softsample.arrays import Array
from softsample.protocol import travel_sign
from softsample.response.curves import ResponseCurves

TOUCH = 0.02
"""Part of the largest force below which the platen hardly touches, and a part of it says little."""

DEGREE = 5
"""Of the polynomials for changes as parts of the force."""

FIBRES = ("fibres_", "at_size_anisotropy")
"""How names of changes by fibres begin."""

MANY, OF_MANY = 2.0, "_many"
"""k1 over mu of a second run with fibres, and how the name of its change ends."""

NORMAL = "_normal"
"""Ends the names of changes of the normal force."""

ENDINGS = {"force": "_mm2", "force_normal": f"{NORMAL}_mm2"}
"""How columns of changes end, by the force that they are of."""

LAW = "law_"
"""How names of forces of single Ogden terms begin, before the exponent: no changes."""

LESS, NEARER = (0.02, 0.09), 0.04
"""By how much the Poisson's ratio of two runs with more compressible tissue is lower, and that of
the run in place of the second if elements do not stand it."""

PRESSED, PRESSED_ELSEWHERE = "pressed", "pressed_elsewhere"
"""Shear of a sample that was compressed before, at the others' fraction and at another one."""


def lower_ratio(less: float) -> str:
    """Name of the change by a Poisson's ratio that is lower by so much."""
    return f"poisson_{less:g}_less"


def read_changes(
    table: pd.DataFrame, curves: ResponseCurves, mode: str, channel: str = "force"
) -> dict[str, Array]:
    """Changes of a force per modulus [m2] on the displacements of a response, from their file."""
    sign = travel_sign(mode)
    travel = 1e-3 * sign * table["displacement_mm"].to_numpy()
    ending = ENDINGS[channel]
    others = tuple(other for other in ENDINGS.values() if len(other) > len(ending))
    return {
        name.removesuffix(ending): np.interp(
            curves.displacement, travel, 1e-6 * sign * table[name].to_numpy()
        )
        for name in table.columns
        if name.endswith(ending) and not name.endswith(others)
    }


def split_laws(changes: Mapping[str, Array]) -> tuple[dict[str, Array], dict[float, Array]]:
    """Changes by name, and forces of single terms by their exponent."""
    laws = {name: force for name, force in changes.items() if name.startswith(LAW)}
    others = {name: change for name, change in changes.items() if name not in laws}
    return others, {float(name.removeprefix(LAW)): force for name, force in laws.items()}


def table_of_changes(
    mode: str, fraction: float, displacement: Array, changes: Mapping[str, Array]
) -> pd.DataFrame:
    """Their file.

    Parameters
    ----------
    mode : str
        Of the test.
    fraction : float
        Modulus fraction at which the changes were simulated.
    displacement : (n,) float64
        Displacements of the platen [m].
    changes : mapping of (n,) float64
        Changes of the force per modulus [m2] by perturbation.
    """
    sign = travel_sign(mode)
    columns = {f"{name}_mm2": 1e6 * sign * change for name, change in changes.items()}
    table = {"mu1_fraction": fraction, "displacement_mm": 1e3 * sign * displacement}
    return pd.DataFrame({**table, **columns})


def for_all_fractions(
    changes: Mapping[str, Array], curves: ResponseCurves, fraction: float, exact: bool = False
) -> dict[str, ResponseCurves]:
    """Changes that were computed at one fraction, carried to all, without the grain of the mesh.

    Fibres are beside the solid; what changes shape, boundary or compressibility changes the force
    by the same part of it. That part is smooth along the travel, while nodes of a coarse mesh meet
    the platen one by one. Of a sample that was compressed before, it is taken to be linear in the
    fraction.

    Parameters
    ----------
    changes : mapping of (n,) float64
        Change of the force per modulus by variant [m2] on the displacements of the curves.
    curves : ResponseCurves
        Force of the unchanged model.
    fraction : float
        At which they were computed.
    exact : bool
        Whether they are of the closed form, which has no grain.
    """
    r, there = curves.fractions, curves.curve(fraction)
    forces = np.stack([curves.curve(x) for x in r])
    follows = {name: np.tile(there, (len(r), 1)) for name in changes if name.startswith(FIBRES)}
    parts = {
        name: part_of(there, change) if exact else _smooth_part(curves.displacement, change, there)
        for name, change in changes.items()
        if name != PRESSED_ELSEWHERE
    }
    if PRESSED_ELSEWHERE in changes:
        other = elsewhere(fraction)
        part = _smooth_part(curves.displacement, changes[PRESSED_ELSEWHERE], curves.curve(other))
        slope = (part - parts[PRESSED]) / (other - fraction)
        parts[PRESSED] = parts[PRESSED] + np.outer(r - fraction, slope)
    return {name: curves.like(follows.get(name, forces) * part) for name, part in parts.items()}


def between_fractions(
    found: Mapping[float, Mapping[str, ResponseCurves]],
) -> dict[str, ResponseCurves]:
    """Changes for all fractions from those of one, or linearly between those of two.

    The force per modulus is linear in the fraction, and its change nearly so.
    """
    (low, first), *more = sorted(found.items())
    if not more:
        return dict(first)
    ((high, second),) = more
    changes = {}
    for name, one in first.items():
        part = (one.fractions - low) / (high - low)
        at_ends = one.curve(low), second[name].curve(high)
        changes[name] = one.like(np.outer(1.0 - part, at_ends[0]) + np.outer(part, at_ends[1]))
    return changes


def part_of(whole: Array, force: Array) -> Array:
    """A force or a change of one as a part (n,) of a force; all of it where there is none."""
    return np.divide(force, whole, out=np.ones_like(whole), where=whole != 0.0)


def _smooth_part(travel: Array, change: Array, force: Array) -> Array:
    """Polynomial (n,) for a change as a part of the force, fitted where there is force."""
    weight = 1.0 / (np.abs(force) + TOUCH * np.abs(force).max())
    powers = np.vander(travel / travel[-1], DEGREE + 1)
    found, *_ = np.linalg.lstsq((weight * force)[:, None] * powers, weight * change, rcond=None)
    return np.asarray(powers @ found)


def elsewhere(fraction: float) -> float:
    """A fraction that differs by a quarter."""
    return fraction + (0.25 if fraction < 0.5 else -0.25)
