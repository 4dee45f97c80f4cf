"""Records of an experiment: clock, faults, floor, noise."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.polynomial import Legendre
from scipy.interpolate import PchipInterpolator
from scipy.signal import lfilter

from softsample.arrays import Array
from softsample.blindlab.bodies import MODES, Body
from softsample.blindlab.curves import SLIP_BACK
from softsample.blindlab.faults import Curve, Fault, Trial

SPEED = 0.3  # mm/s
RATE = 100.0  # Hz
FINER = 4  # steps of the laboratory's clock in one of the record
REST, HOLD = 2.0, 60.0  # s
DESIGNS = {"A": (1.0,), "B": (1.0,), "C": (1.0, 10.0)}
"""Speeds of each design, as multiples; A is the loading ramp alone."""

WHITE, SLOW, SLOW_TIME = 1.0e-3, 0.5e-3, 1.0  # N, N, s
READING = 1.0e-3  # mm
FLOOR_LENGTH = 0.25  # of the stroke
DEGREE = 5  # of the floor that is a polynomial
MU_PA = (800.0, 2500.0)

Draw = Callable[[np.random.Generator], Curve]
"""Of a random function of the travel over the stroke."""


def _smooth(random: np.random.Generator) -> Curve:
    """Random smooth function of standard deviation 1 on travels over the stroke."""
    wave = random.normal(0.0, 1.0 / FLOOR_LENGTH, 64)
    phase = random.uniform(0.0, 2.0 * np.pi, 64)
    return lambda x: np.cos(np.outer(x, wave) + phase).sum(axis=1) * np.sqrt(2.0 / 64.0)


def _wandering(random: np.random.Generator, size: float, step: float, count: int) -> Array:
    """Ornstein and Uhlenbeck's noise (count,) of a standard deviation; steps in its own length."""
    keep = np.exp(-step)
    kicks = random.normal(0.0, size * np.sqrt(1.0 - keep**2), count)
    kicks[0] /= np.sqrt(1.0 - keep**2)
    return np.asarray(lfilter([1.0], [1.0, -keep], kicks))


def _rough(random: np.random.Generator) -> Curve:
    """Random function of standard deviation 1 with corners everywhere."""
    grid = np.linspace(-0.2, 1.2, 1401)
    values = _wandering(random, 1.0, (grid[1] - grid[0]) / FLOOR_LENGTH, len(grid))
    return lambda x: np.interp(x, grid, values)


def _polynomial(random: np.random.Generator) -> Curve:
    """Random polynomial without constant, of standard deviation 1 over the stroke."""
    degrees = np.arange(1, DEGREE + 1)
    factors = random.normal(size=DEGREE) * np.sqrt((2.0 * degrees + 1.0) / DEGREE)
    return Legendre([0.0, *factors], domain=[0.0, 1.0])


def of_misfits(misfits: pd.DataFrame) -> Draw:
    """Draws of a table of misfits of measured records, either way up.

    Each row is one of standard deviation 1; columns that are numbers are travels over the stroke.
    """
    errors = misfits.filter(regex=r"^\d")
    travel, every = errors.columns.to_numpy(dtype=float), errors.to_numpy()

    def draw(random: np.random.Generator) -> Curve:
        error = random.choice([-1.0, 1.0]) * every[random.integers(len(every))]
        return PchipInterpolator(travel, error, extrapolate=True)

    return draw


FAMILIES: dict[str, Draw] = {"gaussian": _smooth, "exponential": _rough, "polynomial": _polynomial}
"""Random errors along the travel over the stroke, of standard deviation 1."""


@dataclass(frozen=True)
class Floor:
    """What the model of a test lacks beside the faults.

    Parameters
    ----------
    percent : float
        Standard deviation of an error of each mode that nothing explains [% of peak].
    draw : callable
        How it goes with the travel: a random curve of standard deviation 1 over the stroke.
    scale_percent : float
        Standard deviation of an error of each mode's scale [%].
    """

    percent: float
    draw: Draw = _smooth
    scale_percent: float = 0.0

    def on(self, test: Trial, force: Array, wave: Curve, scale: float) -> Array:
        """Force (n,) [N] with a draw of both errors; nothing before the platen moves."""
        if self.percent:
            moved = np.clip(test.travel / (0.02 * test.stroke), 0.0, 1.0)
            error = 0.01 * self.percent * np.abs(force).max()
            force = force + error * moved * wave(test.travel / test.stroke)
        return force * np.exp(0.01 * self.scale_percent * scale)


@dataclass(frozen=True, eq=False)
class Record:
    """What the machine writes of one test: mode and table."""

    mode: str
    table: pd.DataFrame


def make_records(
    body: Body,
    curves: pd.DataFrame,
    faults: Sequence[Fault],
    mu: float,
    design: str,
    floor: Floor,
    size: float,
    random: np.random.Generator,
) -> list[Record]:
    """Records of one animal: every mode, at every speed of the design.

    Parameters
    ----------
    body : Body
        The sample.
    curves : DataFrame
        As of `planted_curves`.
    faults : sequence of Fault
        What is wrong.
    mu : float
        Shear modulus [Pa].
    design : str
        Key of `DESIGNS`.
    floor : Floor
        What the model lacks beside that.
    size : float
        Multiple of the nominal size, for the faults that are changed curves.
    random : Generator
        Of this experiment.

    Raises
    ------
    ValueError
        If a changed curve was not simulated at this size, so that nothing would be planted.
    """
    known = set(curves.loc[curves["size"] == size, "curve"])
    wanted = {"shape"} if body.imperfect else {fault.curve for fault in faults if fault.curve}
    if wanted - known:
        raise ValueError(f"no curve at {size:g} times the nominal size: {sorted(wanted - known)}")
    elastic = {mode: _curve(body, curves, faults, mode, size) for mode in MODES}
    loop = _loop(curves, size)
    records = []
    for mode in MODES:
        wave = floor.draw(random)
        scale = float(random.normal()) if floor.scale_percent else 0.0
        for speed in DESIGNS[design]:
            test = _test(body, mode, mu, elastic, loop, design, SPEED * speed)
            force = floor.on(test, _force(test, faults), wave, scale)
            records.append(Record(mode, _table(test, force, random)))
    return _relabelled(records, faults)


def _curve(
    body: Body, curves: pd.DataFrame, faults: Sequence[Fault], mode: str, size: float
) -> Curve:
    """Plain curve, plus the differences that changed models make."""
    of_mode = curves[curves["mode"] == mode]
    changed = [fault.curve for fault in faults if fault.curve]
    plain = of_mode[of_mode["curve"] == ("shape" if body.imperfect else "plain")]
    if body.imperfect:
        plain = plain[plain["size"] == size]
    travel = plain["displacement_mm"].to_numpy()
    area = plain["area_mm2"].to_numpy()
    for name in changed if not body.imperfect else []:
        other = of_mode[(of_mode["curve"] == name) & (of_mode["size"] == size)]
        if len(other):
            area = area + other["area_mm2"].to_numpy() - plain["area_mm2"].to_numpy()
    return PchipInterpolator(travel, area, extrapolate=True)


def _loop(curves: pd.DataFrame, size: float) -> Curve:
    """What a slipping sample's force over modulus is more on unloading."""
    of_size = curves[(curves["mode"] == "compression") & (curves["size"] == size)]
    there, back = (of_size[of_size["curve"] == name] for name in ("slip", SLIP_BACK))
    if back.empty:
        return np.zeros_like
    more = back["area_mm2"].to_numpy() - there["area_mm2"].to_numpy()
    return PchipInterpolator(there["displacement_mm"].to_numpy(), more, extrapolate=True)


def _test(
    body: Body,
    mode: str,
    mu: float,
    elastic: Mapping[str, Curve],
    loop: Curve,
    design: str,
    speed: float,
) -> Trial:
    """The platen's travel on the laboratory's clock."""
    stroke = body.stroke(mode)
    way = stroke / speed
    knots, heights = [0.0, way], [0.0, stroke]
    if design != "A":
        knots = [0.0, REST, REST + way, REST + way + HOLD, REST + 2.0 * way + HOLD]
        heights = [0.0, 0.0, stroke, stroke, 0.0]
    time = np.arange(0.0, knots[-1], 1.0 / RATE / FINER)
    return Trial(
        mode, time, np.interp(time, knots, heights), stroke, body.height, mu, elastic, loop
    )


def _force(test: Trial, faults: Sequence[Fault]) -> Array:
    """Force of the platen on the sample along the travel [N], through all faults in order."""
    travel = test.travel
    for fault in faults:
        travel = fault.travel(test, travel)
    force = test.elastic(travel)
    for fault in faults:
        force = fault.tissue(test, force)
    if test.mode == "compression":
        force = np.maximum(force, 0.0)
    for fault in faults:
        force = fault.instrument(test, force)
    return force


def _table(test: Trial, force: Array, random: np.random.Generator) -> pd.DataFrame:
    """Every so many steps of the clock, with the noise of cell and reading."""
    kept = slice(None, None, FINER)
    n = len(test.time[kept])
    slow = _wandering(random, SLOW, 1.0 / RATE / SLOW_TIME, n)
    noise = slow + random.normal(0.0, WHITE, n)
    return pd.DataFrame(
        {
            "time_s": test.time[kept],
            "displacement_mm": test.sign * test.travel[kept] + random.normal(0.0, READING, n),
            "force_N": test.sign * force[kept] + noise,
        }
    )


def _relabelled(records: list[Record], faults: Sequence[Fault]) -> list[Record]:
    for fault in faults:
        if fault.swap:
            one, other = fault.swap
            labels = {one: other, other: one}
            records = [Record(labels.get(r.mode, r.mode), r.table) for r in records]
    return records
