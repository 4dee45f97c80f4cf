"""Test protocol: how the moving platen travels over time, and where a record's loadings lie."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike, NDArray
from scipy.special import fdtri

from softsample.arrays import Array
from softsample.errors import InputError

DIRECTIONS = {
    "tension": (0.0, 0.0, 1.0),
    "compression": (0.0, 0.0, -1.0),
    "shear": (1.0, 0.0, 0.0),
    "pure_shear": (0.0, 0.0, 1.0),
    "confined_compression": (0.0, 0.0, -1.0),
    "indentation": (0.0, 0.0, -1.0),
    "torsion": (1.0, 0.0, 0.0),
}
"""Direction of the moving platen's displacement in each test mode (sample frame); in torsion the
displacement is that of a point on the rim, and the first component stands for the way around."""

MODES = tuple(DIRECTIONS)

GEOMETRIES = ("real", "ideal")
"""What a sample is simulated as."""

TWO_TERM, ONE_TERM = "ogden2", "ogden1"
"""Material models that are calibrated."""

PRESSED_MODES = ("compression", "confined_compression", "indentation")
"""Modes in which the platen presses and can leave the sample."""

SHEARED_MODES = ("shear", "torsion")
"""Modes in which either direction of the displacement is the mirror image of the other."""

NEVER_UNIFORM = ("indentation", "torsion")
"""Modes in which no sample deforms uniformly."""


def is_homogeneous(mode: str, ends: object) -> bool:
    """Whether an ideal shape deforms uniformly: between ends or walls without friction."""
    uniform = ends == "sliding" or mode == "confined_compression"
    return uniform and mode not in NEVER_UNIFORM


REACHED = 0.95
"""A ramp reaches the largest displacement of a record if it comes to this part of it."""

GIVEN_BACK = 0.5
"""A new loading begins once the unloading has given back this part of the last one."""

LEAST_LOADING = 0.05
"""A smaller part of the largest displacement is no loading, but contact or a fluctuation."""

AWAY = 0.05
"""A record begins deformed if its first displacement is this part of its range or more."""

ALIKE = 1.25
"""Ratio up to which displacements of two tests are about as large, and speeds are one speed."""

LARGEST, FIRST, LAST = "largest", "first", "last"
"""Which loading is calibrated; `largest` is the first that reaches the largest displacement."""


SLOW = 0.05
"""Legs below this part of the record's highest speed can be rest with a drifting reading."""


DEGREE, CHANCE, LEAST_BENT = 5, 1e-3, 24
"""Degree of the polynomial along a leg that bends, the chance at which a straight one seems to,
and the fewest samples of a leg that may."""

FEWEST_JUMPS = 10
"""Lone jumps of a reading from which on it is a staircase."""

FEWEST_RESTING = 10
"""Samples of a leg without time from which on it may be a rest, although each goes further."""


def travel_sign(mode: str) -> float:
    """Sign of displacement and force while loading: -1 in compression, +1 otherwise."""
    return float(sum(DIRECTIONS[mode]))


def loading(modes: Iterable[str]) -> str:
    """Loading of a group in one word: its modes, shear before the others, joined by a plus."""
    order = ("shear", *(mode for mode in MODES if mode != "shear"))
    return "+".join(sorted(set(modes), key=order.index))


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
            raise InputError(
                "a loading history needs at least two corners of time and displacement"
            )
        if not np.all(np.diff(self.time) > 0.0):
            raise InputError(f"times of a loading history must ascend, got {self.time} s")
        if self.time[0] != 0.0 or self.travel[0] != 0.0 or not self.reach > 0.0:
            raise InputError(
                f"a loading history must start at zero and move, got {1e3 * self.travel} mm"
            )

    @classmethod
    def ramp(cls, travel: float) -> "History":
        """A single ramp to `travel` > 0 [m] in 1 s."""
        if not travel > 0.0:
            raise InputError(f"the platen must move, got {travel:g} m; check the record")
        return cls(np.array([0.0, 1.0]), np.array([0.0, travel]))

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


def phases(time: Array | None, displacement: Array, origin: float | None = None) -> list[Phase]:
    """Phases of a test, found from the displacement alone.

    The displacement is replaced by the polygon that follows it within its noise
    (Ramer-Douglas-Peucker), so that no speed and no order of phases need be known.

    Parameters
    ----------
    time : (n,) float64, or None
        Time [s], ascending, if it was recorded.
    displacement : (n,) float64
        Displacement of the platen [m], either sign.
    origin : float, optional
        Displacement of the undeformed sample [m]; by default that of the first sample.

    Returns
    -------
    list of Phase
        In order, without gaps; neighbours differ in kind.

    Raises
    ------
    InputError
        If the platen does not move beyond the noise of its reading.
    """
    tolerance = _tolerance(time, displacement)
    away = displacement - (displacement[0] if origin is None else origin)
    found: list[Phase] = []
    ends = _split_at_origin(away, corners(time, displacement), tolerance)
    for start, stop, kind in zip(
        ends[:-1], ends[1:], _kinds(time, away, ends, tolerance), strict=True
    ):
        end = stop + int(stop == len(displacement) - 1)
        if found and found[-1].kind == kind:
            found[-1] = Phase(kind, found[-1].start, end)
        else:
            found.append(Phase(kind, start, end))
    return found


def corners(time: Array | None, displacement: Array) -> list[int]:
    """Samples where the travel changes its course, the first and the last one included.

    Raises
    ------
    InputError
        If the platen does not move beyond the noise of its reading.
    """
    reach = float(np.ptp(displacement))
    if reach <= 5.0 * max(10.0 * reading_noise(time, displacement), _tread(displacement)):
        raise InputError(
            f"displacement stays within {1e3 * reach:.3g} mm, its noise: there is no loading ramp"
        )
    return _polygon(clock_of(time, displacement), displacement, _tolerance(time, displacement))


def clock_of(time: Array | None, reading: Array) -> Array:
    """Time (n,) [s], or the numbers of samples where none was recorded."""
    return np.arange(len(reading), dtype=np.float64) if time is None else time


def _tolerance(time: Array | None, displacement: Array) -> float:
    """Distance from a polygon that is noise, or the last digit of the reading and a half [m].

    Noise that makes a coarse reading flicker between two digits is up to that of rounding.
    """
    tread = _tread(displacement)
    noise = reading_noise(time, displacement)
    if len(_back_steps(displacement)):
        noise = max(noise, tread / np.sqrt(12.0))
    return max(10.0 * noise, 1e-3 * float(np.ptp(displacement)), 1.5 * tread)


def _tread(displacement: Array) -> float:
    """Height [m] of the steps of a staircase; none if the reading is no staircase.

    A reading that is rounded coarsely stays where it is for some samples, jumps, and stays again.
    """
    step = np.abs(np.diff(displacement))
    jumps = (step[1:-1] > 0.0) & (step[:-2] == 0.0) & (step[2:] == 0.0)
    return float(step[1:-1][jumps].min()) if jumps.sum() >= FEWEST_JUMPS else 0.0


def _split_at_origin(away: Array, ends: list[int], tolerance: float) -> list[int]:
    """Corners, and where a leg passes the origin on its way from one side to the other."""
    passed = [
        first + int(np.abs(away[first : last + 1]).argmin())
        for first, last in pairwise(ends)
        if away[first] * away[last] < 0.0
        and min(abs(away[first]), abs(away[last])) > 5.0 * tolerance
    ]
    return sorted({*ends, *passed})


def denoised(time: Array | None, displacement: Array) -> Array:
    """The travel behind a noisy reading: a straight line through the samples of every leg.

    Corners are where lines of neighbouring legs meet, so that they are known better than to the
    nearest sample. A leg that bends, as of a sinusoidal test or where the sample's own displacement
    is read on a machine that gives way, gets what a polynomial explains of the rest.
    """
    ends, time = corners(time, displacement), clock_of(time, displacement)
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
    found = np.interp(time, knots, heights)
    for first, last in pairwise(ends):
        leg = slice(first, last + int(last == len(time) - 1))
        found[leg] += _bend(time[leg], displacement[leg] - found[leg])
    return found


def _bend(time: Array, rest: Array) -> Array:
    """What a polynomial explains of what a straight leg leaves; nothing if that is chance."""
    if len(time) < LEAST_BENT:
        return np.zeros(len(time))
    straight, bent = (Polynomial.fit(time, rest, degree)(time) for degree in (1, DEGREE))
    left, more = float(np.sum((rest - bent) ** 2)), DEGREE - 1
    free = len(time) - DEGREE - 1
    gain = float(np.sum((rest - straight) ** 2)) - left
    if gain * free <= fdtri(more, free, 1.0 - CHANCE) * more * left:
        return np.zeros(len(time))
    return np.asarray(bent)


def _kinds(time: Array | None, away: Array, corners: list[int], tolerance: float) -> list[str]:
    """Kind of each leg of the polygon; a short slow leg is rest, a long slow one is not.

    Without time, a few samples close together are no rest if each goes further than that before.
    """
    distance = np.abs(away[corners])
    step = np.abs(np.diff(away[corners]))
    speed = step / np.diff(clock_of(time, away)[corners])
    rest = (step <= 4.0 * tolerance) & (speed <= SLOW * speed.max())
    if time is None:
        way, count = np.add.reduceat(np.sign(np.diff(away)), corners[:-1]), np.diff(corners)
        rest &= (np.abs(way) < count) | (count >= FEWEST_RESTING)
    kinds: list[str] = []
    for k in range(len(step)):
        if rest[k]:
            kinds.append("hold" if {"ramp", "unloading"} & {*kinds} else "baseline")
        else:
            kinds.append("ramp" if distance[k + 1] > distance[k] else "unloading")
    return kinds


@dataclass(frozen=True)
class Loading:
    """One loading of a record: its ramps until one of them reaches its largest displacement.

    Parameters
    ----------
    ramps : tuple of slice
        Samples of the ramps, the last one of each included; several with holds between them.
    peak : float
        Largest displacement from the origin [m].
    """

    ramps: tuple[slice, ...]
    peak: float

    @property
    def start(self) -> int:
        """First sample."""
        return int(self.ramps[0].start)

    @property
    def last(self) -> int:
        """Last sample."""
        return int(self.ramps[-1].stop) - 1


@dataclass(frozen=True)
class Course:
    """What the platen does in a record.

    Loadings are counted along one direction. A new one begins with the first ramp after an
    unloading that gave back at least half of the displacement of the one before. So steps with
    holds between them are one loading; the way to the other side of the origin and back belongs
    to the loading before it, which makes one cycle.

    Parameters
    ----------
    phases : list of Phase
    loadings : list of Loading
        At least one, in order.
    """

    phases: list[Phase]
    loadings: list[Loading]

    @classmethod
    def of(cls, time: Array | None, displacement: Array, mode: str | None = None) -> Self:
        """Course of a record.

        Parameters
        ----------
        time : (n,) float64, or None
            Time [s], ascending, if it was recorded.
        displacement : (n,) float64
            Displacement of the platen [m].
        mode : str, optional
            Of the test: loadings are those along its direction, if the platen goes as far there
            as to the other side, or presses there first. Otherwise, and without a mode, the first
            ramp that reaches the largest displacement tells the direction.

        Raises
        ------
        InputError
            If there is no loading.
        """
        found = phases(time, displacement)
        origin = float(displacement[0])
        if mode in SHEARED_MODES and _is_sweep(found, displacement):
            origin = 0.0
            found = phases(time, displacement, origin)
        away = displacement - origin
        return cls(found, _loadings(found, _side(found, away, mode) * away))

    def chosen(self, which: str = LARGEST) -> Loading:
        """The loading that materials are calibrated on.

        Parameters
        ----------
        which
            `largest` (the first that reaches 95 % of the largest displacement, so that smaller
            ones before it are preconditioning), `first`, `last`, or a number from 1 on.

        Raises
        ------
        InputError
            If there are fewer loadings.
        """
        return self.loadings[self.number(which) - 1]

    def number(self, which: str = LARGEST) -> int:
        """Number of the chosen loading, from 1 on."""
        count = len(self.loadings)
        if which == LARGEST:
            enough = REACHED * max(loading.peak for loading in self.loadings)
            return next(n for n, one in enumerate(self.loadings, 1) if one.peak >= enough)
        wanted = {FIRST: 1, LAST: count}.get(which) or int(which)
        if not 1 <= wanted <= count:
            raise InputError(
                f"no loading {which}: the record has {count}; give first, last or a number up to "
                f"{count}"
            )
        return wanted

    @property
    def phase(self) -> NDArray[np.str_]:
        """Kind of the phase of each sample (n,)."""
        kinds = [phase.kind for phase in self.phases]
        return np.repeat(kinds, [phase.stop - phase.start for phase in self.phases])

    @property
    def cycle(self) -> NDArray[np.int64]:
        """Number of the loading that each sample (n,) belongs to; 0 before the first."""
        starts = [loading.start for loading in self.loadings]
        return np.searchsorted(starts, np.arange(self.phases[-1].stop), side="right")


def _is_sweep(found: Sequence[Phase], displacement: Array) -> bool:
    """Whether a record begins deformed and passes zero, as one sweep to both sides does.

    Where the platen rests first, the sample is taken for undeformed there.
    """
    return found[0].kind != "baseline" and sweeps_through_zero(displacement)


def sweeps_through_zero(displacement: Array) -> bool:
    """Whether displacements (n,) begin away from zero and reach to both sides of it."""
    low, high = float(displacement.min()), float(displacement.max())
    least = AWAY * (high - low)
    return min(-low, high) > least and abs(float(displacement[0])) > least


def _ramp_slices(found: Sequence[Phase], away: Array) -> list[slice]:
    """Samples of each ramp with the corner at its end."""
    ends = [min(phase.stop, len(away) - 1) + 1 for phase in found]
    return [
        slice(phase.start, end)
        for phase, end in zip(found, ends, strict=True)
        if phase.kind == "ramp"
    ]


def _side(found: Sequence[Phase], away: Array, mode: str | None) -> float:
    """Direction along which loadings are counted."""
    ends = np.array([away[ramp.stop - 1] for ramp in _ramp_slices(found, away)])
    if not len(ends):
        raise InputError(
            "the platen only comes back from where it starts: there is no loading ramp"
        )
    far = ends[np.abs(ends) >= REACHED * np.abs(ends).max()]
    wanted = np.sign(far[0]) if mode is None else travel_sign(mode)
    first = ends[np.abs(ends) >= LEAST_LOADING * np.abs(ends).max()][0]
    if mode in PRESSED_MODES and wanted * first > 0.0:  # lifted afterwards, however far
        return wanted
    return float(wanted if (wanted * far > 0.0).any() else np.sign(far[0]))


def _loadings(found: Sequence[Phase], away: Array) -> list[Loading]:
    """Loadings of a displacement `away` (n,) from the origin, along its positive direction."""
    ramps = [ramp for ramp in _ramp_slices(found, away) if away[ramp.stop - 1] > 0.0]
    least = LEAST_LOADING * max(float(away[ramp.stop - 1]) for ramp in ramps)
    groups: list[list[slice]] = []
    waiting: list[slice] = []
    peak = 0.0
    for ramp in ramps:
        end = float(away[ramp.stop - 1])
        since = groups[-1][-1].stop if groups else 0
        low = since + int(away[since : ramp.stop].argmin())
        if groups and away[low] > (1.0 - GIVEN_BACK) * peak:
            groups[-1].append(ramp)
            peak = max(peak, end)
            continue
        waiting = [*(one for one in waiting if one.stop > low), ramp]
        if not groups or end - away[low] >= least:  # less is a fluctuation during unloading
            groups.append(waiting)
            waiting, peak = [], end
    every = [_loading(group, away) for group in groups]
    return [loading for loading in every if loading.peak >= least]


def _loading(ramps: Sequence[slice], away: Array) -> Loading:
    ends = [float(away[ramp.stop - 1]) for ramp in ramps]
    until = next(k for k, end in enumerate(ends) if end >= REACHED * max(ends))
    return Loading(tuple(ramps[: until + 1]), max(ends))


def reading_noise(time: Array | None, reading: Array) -> float:
    """Standard deviation of white noise on a piecewise linear reading (n,), in its unit.

    Each sample is compared with the chord of its neighbours. Without time, uneven steps look like
    noise, but only noise makes lone steps back: it is no more than the largest of these.
    """
    untimed, time = time is None, clock_of(time, reading)
    share = (time[1:-1] - time[:-2]) / (time[2:] - time[:-2])
    chord = (1.0 - share) * reading[:-2] + share * reading[2:]
    off = (reading[1:-1] - chord) / np.sqrt(1.0 + share**2 + (1.0 - share) ** 2)
    noise = float(1.4826 * np.median(np.abs(off - np.median(off))))
    return min(noise, float(_back_steps(reading).max(initial=0.0))) if untimed else noise


def _back_steps(reading: Array) -> Array:
    """Sizes of lone steps back, between two steps the other way: a platen turns for longer."""
    step = np.diff(reading)
    step = step[step != 0.0]
    lone = (step[1:-1] * step[:-2] < 0.0) & (step[1:-1] * step[2:] < 0.0)
    return np.asarray(np.abs(step[1:-1][lone]))


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
