"""Test protocol: how the moving platen travels over time, and where a record's ramp lies."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsample.errors import InputError

Array = NDArray[np.float64]

DIRECTIONS = {
    "tension": (0.0, 0.0, 1.0),
    "compression": (0.0, 0.0, -1.0),
    "shear": (1.0, 0.0, 0.0),
    "pure_shear": (0.0, 0.0, 1.0),
    "confined_compression": (0.0, 0.0, -1.0),
}
"""Direction of the moving platen's travel in each test mode (sample frame)."""

PRESSED_MODES = ("compression", "confined_compression")
"""Modes in which the platen presses and can leave the sample."""

REACHED = 0.95
"""A ramp counts as the loading ramp if it reaches this part of the record's largest travel."""


SLOW = 0.05
"""Legs below this part of the record's highest speed can be rest with a drifting reading."""


FEWEST_JUMPS = 10
"""Lone jumps of a reading from which on it is a staircase."""


def travel_sign(mode: str) -> float:
    """Sign of displacement and force while loading: -1 in compression, +1 otherwise."""
    return float(sum(DIRECTIONS[mode]))


def smooth_step(fraction: ArrayLike) -> Array:
    """Quintic smooth step ``x^3 (10 - 15 x + 6 x^2)`` from 0 to 1.

    Speed and acceleration vanish at both ends, so that a fast loading excites few vibrations.

    Parameters
    ----------
    fraction : array_like
        Time over loading time, dimensionless; clipped to [0, 1].
    """
    x = np.clip(np.asarray(fraction, dtype=np.float64), 0.0, 1.0)
    return np.asarray(x**3 * (10.0 - 15.0 * x + 6.0 * x**2))


@dataclass(frozen=True)
class History:
    """Any travel of the moving platen over time, as a polygon: ramps, holds, unloading.

    Parameters
    ----------
    time : (n,) float64
        Time of the corners [s], ascending, from zero.
    travel : (n,) float64
        Travel along the direction of loading at the corners [m], from zero.

    Raises
    ------
    InputError
        If the corners are fewer than two, out of order, or do not start at zero and move.
    """

    time: Array
    travel: Array

    def __post_init__(self) -> None:
        if len(self.time) != len(self.travel) or len(self.time) < 2:
            raise InputError("a loading history needs at least two corners of time and travel")
        if not np.all(np.diff(self.time) > 0.0):
            raise InputError(f"times of a loading history must ascend, got {self.time} s")
        if self.time[0] != 0.0 or self.travel[0] != 0.0 or not self.reach > 0.0:
            raise InputError(
                f"a loading history must start at zero and move, got {1e3 * self.travel} mm"
            )

    @classmethod
    def ramp(cls, travel: float, duration: float = 1.0) -> "History":
        """A single ramp to `travel` > 0 [m] in `duration` [s]."""
        if not travel > 0.0:
            raise InputError(f"the platen must travel, got {travel:g} m; check the record")
        return cls(np.array([0.0, duration]), np.array([0.0, travel]))

    @property
    def reach(self) -> float:
        """Largest travel either way [m]."""
        return float(np.abs(self.travel).max())


@dataclass(frozen=True)
class Phase:
    """Part of a record in which the platen does one thing.

    Parameters
    ----------
    kind : str
        `baseline` (at rest before the first movement), `ramp` (away from the start), `hold` (at
        rest later on) or `unloading` (back towards the start).
    start, stop : int
        First sample and the one after the last.
    """

    kind: str
    start: int
    stop: int

    @property
    def samples(self) -> slice:
        """The phase as a slice."""
        return slice(self.start, self.stop)


def phases(time: Array, displacement: Array) -> list[Phase]:
    """Phases of a test, found from the displacement alone.

    The displacement is replaced by the polygon that follows it within its noise
    (Ramer-Douglas-Peucker), so that no speed and no order of phases need be known.

    Parameters
    ----------
    time : (n,) float64
        Time [s], ascending.
    displacement : (n,) float64
        Travel of the platen [m], either sign.

    Returns
    -------
    list of Phase
        In order, without gaps; neighbours differ in kind.

    Raises
    ------
    InputError
        If the platen does not move beyond the noise of its reading.
    """
    tolerance = _tolerance(displacement)
    found: list[Phase] = []
    ends = _split_at_start(displacement, corners(time, displacement), tolerance)
    for start, stop, kind in zip(
        ends[:-1], ends[1:], _kinds(time, displacement, ends, tolerance), strict=True
    ):
        end = stop + int(stop == len(time) - 1)
        if found and found[-1].kind == kind:
            found[-1] = Phase(kind, found[-1].start, end)
        else:
            found.append(Phase(kind, start, end))
    return found


def corners(time: Array, displacement: Array) -> list[int]:
    """Samples where the travel changes its course, the first and the last one included.

    Raises
    ------
    InputError
        If the platen does not move beyond the noise of its reading.
    """
    tolerance = _tolerance(displacement)
    if np.ptp(displacement) < 5.0 * tolerance:
        reach = 1e3 * float(np.ptp(displacement))
        raise InputError(
            f"displacement stays within {reach:.3g} mm, its noise: there is no loading ramp"
        )
    return _polygon(time, displacement, tolerance)


def _tolerance(displacement: Array) -> float:
    """Distance from a polygon that is noise, or the last digit of the reading [m]."""
    reach = float(np.ptp(displacement))
    return max(10.0 * _noise(displacement), 1e-3 * reach, _tread(displacement))


def _tread(displacement: Array) -> float:
    """Height [m] of the steps of a staircase; none if the reading is no staircase.

    A reading that is rounded coarsely stays where it is for some samples, jumps, and stays again.
    """
    step = np.abs(np.diff(displacement))
    jumps = (step[1:-1] > 0.0) & (step[:-2] == 0.0) & (step[2:] == 0.0)
    return float(step[1:-1][jumps].min()) if jumps.sum() >= FEWEST_JUMPS else 0.0


def _split_at_start(displacement: Array, ends: list[int], tolerance: float) -> list[int]:
    """Corners, and where a leg passes the start on its way from one side to the other."""
    away = displacement - displacement[0]
    passed = [
        first + int(np.abs(away[first : last + 1]).argmin())
        for first, last in pairwise(ends)
        if away[first] * away[last] < 0.0
        and min(abs(away[first]), abs(away[last])) > 5.0 * tolerance
    ]
    return sorted({*ends, *passed})


def denoised(time: Array, displacement: Array) -> Array:
    """The polygon behind a noisy travel: a straight line through the samples of every leg.

    Corners are where lines of neighbouring legs meet, so that they are known better than to the
    nearest sample.
    """
    ends = corners(time, displacement)
    lines = []
    for first, last in pairwise(ends):
        trim = (last - first) // 10
        leg = slice(first + trim, last + 1 - trim)
        lines.append(np.polyfit(time[leg], displacement[leg], 1))
    knots = [time[0]]
    for k, (before, after) in enumerate(pairwise(lines)):
        meeting = (
            (after[1] - before[1]) / (before[0] - after[0]) if before[0] != after[0] else np.nan
        )
        corner = time[ends[k + 1]]
        reach = 0.5 * min(corner - time[ends[k]], time[ends[k + 2]] - corner)
        knots.append(meeting if abs(meeting - corner) < reach else corner)
    knots.append(time[-1])
    heights = [
        np.polyval(line, knot) for line, knot in zip([*lines, lines[-1]], knots, strict=True)
    ]
    return np.interp(time, knots, heights)


def _kinds(time: Array, displacement: Array, corners: list[int], tolerance: float) -> list[str]:
    """Kind of each leg of the polygon; a short slow leg is rest, a long slow one is not."""
    distance = np.abs(displacement[corners] - displacement[0])
    step = np.abs(np.diff(displacement[corners]))
    speed = step / np.diff(time[corners])
    rest = (step <= 4.0 * tolerance) & (speed <= SLOW * speed.max())
    kinds: list[str] = []
    for k in range(len(step)):
        if rest[k]:
            kinds.append("hold" if "ramp" in kinds else "baseline")
        else:
            kinds.append("ramp" if distance[k + 1] > distance[k] else "unloading")
    return kinds


def loading_ramp(time: Array, displacement: Array) -> slice:
    """Samples of the ramp that materials are calibrated on.

    It is the first ramp that reaches 95 % of the largest travel, its last sample included;
    smaller ramps before it (preconditioning) are passed over.

    Parameters
    ----------
    time, displacement : (n,) float64
        Time [s] and travel [m].

    Raises
    ------
    InputError
        If there is no such ramp.
    """
    start = displacement[0]
    largest = np.abs(displacement - start).max()
    for phase in phases(time, displacement):
        if phase.kind == "ramp":
            end = min(phase.stop, len(time) - 1)
            if abs(displacement[end] - start) >= REACHED * largest:
                return slice(phase.start, end + 1)
    raise InputError("no ramp reaches the record's largest travel: there is no loading ramp")


def _noise(displacement: Array) -> float:
    """Standard deviation of white noise on a piecewise linear signal, from second differences."""
    second = np.diff(displacement, 2)
    return float(1.4826 * np.median(np.abs(second - np.median(second))) / np.sqrt(6.0))


def _polygon(time: Array, displacement: Array, tolerance: float) -> list[int]:
    """Indices of the corners of the coarsest polygon within `tolerance` of the samples."""
    kept = {0, len(time) - 1}
    todo = [(0, len(time) - 1)]
    while todo:
        first, last = todo.pop()
        if last - first < 2:
            continue
        inner = slice(first + 1, last)
        fraction = (time[inner] - time[first]) / (time[last] - time[first])
        chord = displacement[first] + fraction * (displacement[last] - displacement[first])
        gap = np.abs(displacement[inner] - chord)
        worst = first + 1 + int(gap.argmax())
        if gap[worst - first - 1] > tolerance:
            kept.add(worst)
            todo += [(first, worst), (worst, last)]
    return sorted(kept)
