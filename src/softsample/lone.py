"""Rows of a record that stand alone: one bad reading, far from those beside it."""

from collections.abc import Iterator
from itertools import permutations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsample.arrays import Array
from softsample.protocol import clock_of

FEWEST = 5
"""Of fewer readings none is judged."""
NOISE, STEPS, FASTER = 10.0, 3.0, 5.0
"""A reading stands alone if it is off by so many times what half of the readings that change are,
and by so many times the steps beside it; the first and the last one, which have one neighbour, if
the step to it is so many times as fast as all others."""

JUMP, STAYS, LOST = 0.02, 0.05, 10
"""A jump is larger than this part of a channel's range, and a channel that does not jump stays
within this part of its own; readings are lost in no more lines, before the channel jumps back."""


LOOKED_AT = {"displacement_mm": 0.01, "force_N": 0.05}
"""Columns that are looked at, with the part of its range that a reading has to be off by.

A platen is moved without leaps, so that a small one is none of its own."""


def lone_rows(table: pd.DataFrame, source: str) -> tuple[list[str], list[str]]:
    """What is to be said of rows of a record that stand alone.

    Parameters
    ----------
    table
        Columns `displacement_mm` and `force_N`, and `time_s` if it was recorded, with signs and
        zero of the file; the index is the line.
    source
        The file's path, for the messages.

    Returns
    -------
    faults : list of str
        Rows that decide what all others count for: the first, since zero and signs rest on it,
        and one that is farther from all others than these are from each other.
    doubts : list of str
        The rest of them, the first of each column with the number of others.
    """
    time = table["time_s"].to_numpy(np.float64) if "time_s" in table else None
    faults: list[str] = []
    doubts: list[str] = []
    for column, part in LOOKED_AT.items():
        values = table[column].to_numpy(np.float64)
        found = lone(values, clock_of(time, values), part)
        deciding = [at for at in found if at == 0 or _decides(values, at)]
        faults += [
            f"{source}, line {table.index[at]}, column {column!r}: "
            f"{_alone(values, at, column)}; delete the line"
            for at in deciding
        ]
        doubts += _doubts(table.index, values, column, [*{*found} - {*deciding}])
    for pair in permutations(LOOKED_AT):
        doubts += _shifted(table, *pair)
    return faults, doubts


def lone(values: Array, clock: Array, part: float) -> NDArray[np.intp]:
    """Places of the readings that stand alone.

    A first one that is nearer to zero than the next may be where a sudden step begins, and is none.

    Parameters
    ----------
    values : (n,) float64
        Readings of one quantity, in any unit.
    clock : (n,) float64
        Their times, or numbers of samples, ascending.
    part
        Of the range of the others, which a reading has to be off by.

    Returns
    -------
    places : (k,) int
        Ascending; none of fewer than `FEWEST` readings.
    """
    if len(values) < FEWEST:
        return np.empty(0, np.intp)
    step = np.abs(np.diff(values))
    off = np.abs(values[1:-1] - 0.5 * (values[:-2] + values[2:]))
    changing = (step[:-1] > 0.0) | (step[1:] > 0.0)  # a cell at its limit is off by nothing
    noise = float(np.median(off[changing])) if changing.any() else 0.0
    usual = max(part * float(np.ptp(np.sort(values)[1:-1])), NOISE * noise)
    before_and_after = np.pad(step, 1)
    beside = np.maximum(before_and_after[:-3], before_and_after[3:])
    beside = np.maximum(beside, np.abs(values[2:] - values[:-2]))
    alone = np.zeros(len(values), bool)
    alone[1:-1] = off > np.maximum(usual, STEPS * beside)
    speed = step / np.diff(clock)
    alone[0] = step[0] > usual and speed[0] > FASTER * speed[1:].max()
    alone[0] &= abs(values[0]) > abs(values[1])
    alone[-1] = step[-1] > usual and speed[-1] > FASTER * speed[:-1].max()
    return np.flatnonzero(alone)


def _shifted(table: pd.DataFrame, column: str, other: str) -> Iterator[str]:
    """What to say of a channel that jumps while the other one goes on, or jumps there and back."""
    name, _, unit = column.partition("_")
    values, beside = (table[one].to_numpy(np.float64) for one in (column, other))
    if len(values) < FEWEST:
        return
    time = table["time_s"].to_numpy(np.float64) if "time_s" in table else None
    step = np.diff(values)
    speed = np.abs(step) / np.diff(clock_of(time, values))
    first, last = sorted(np.argsort(speed)[-2:])
    back = 1 < last - first <= LOST and abs(step[first] + step[last]) < 0.5 * abs(step[first])
    at = first if back else int(np.abs(step[:-1]).argmax())
    others = np.delete(speed, [first, last] if back else at)
    if abs(step[at]) <= JUMP * np.ptp(values) or speed[at] <= FASTER * others.max():
        return
    before, after = values[at : at + 2]
    told = f"line {table.index[at + 1]}: the {name} jumps from {before:.4g} to {after:.4g} {unit}"
    if back:
        yield f"{told}, and back; if readings were lost, delete the {last - first} lines between"
    elif np.ptp(beside[max(at - 1, 0) : at + 3]) < STAYS * np.ptp(beside):
        yield (
            f"{told}, while the {other.partition('_')[0]} does not; if the channel was zeroed "
            f"there, add {before - after:.4g} {unit} to it from this line on, else look whether "
            "the sample slipped or failed"
        )


def _decides(values: Array, at: int) -> bool:
    """Whether a reading between others is farther from all of them than they are from each other.

    The last one may be of the unloading, or what is left after failure.
    """
    others = np.delete(values, at)
    beyond = max(others.min() - values[at], values[at] - others.max())
    return at < len(values) - 1 and bool(beyond > np.ptp(others))


def _alone(values: Array, at: int, column: str) -> str:
    """A reading with those beside it and the range of the others, in words."""
    _, _, unit = column.partition("_")
    others = np.delete(values, at)
    beside = " and ".join(f"{x:.4g}" for x in (*values[max(at - 1, 0) : at], values[at + 1]))
    row = "the first row" if at == 0 else "this row"
    return (
        f"{values[at]:.4g} {unit} in {row} stands alone, with {beside} {unit} beside it and "
        f"{others.min():.4g} to {others.max():.4g} {unit} in all others"
    )


def _doubts(lines: pd.Index, values: Array, column: str, found: list[int]) -> Iterator[str]:
    """What to say of readings that decide nothing."""
    name, _, unit = column.partition("_")
    if found:
        at = min(found)
        more = f", and {len(found) - 1} more" if len(found) > 1 else ""
        yield (
            f"line {lines[at]}: the {name} is {values[at]:.3g} {unit}, far from that "
            f"of the lines beside it{more}; delete such lines if the reading was disturbed"
        )
