"""Values of the cells of a column: numbers, seconds of a clock, and which mark decimals have."""

import re
from collections.abc import Collection, Sequence
from contextlib import suppress
from datetime import datetime
from typing import Any

import numpy as np
import pandas as pd

from softsample.arrays import Array
from softsample.errors import InputError
from softsample.files import PathLike
from softsample.formats.cells import CLOCK, NUMBER

DAY = 86400.0
"""Seconds of a day, after which a clock begins anew."""

THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}", re.ASCII)
"""A number that may have a thousands separator."""

JUMPS = 1.5
"""How much longer the way of a column is over its range, if 1.000 follows 999 as 1 does."""

DECIMALS = re.compile(r"[+-]?0\d+", re.ASCII)
"""Decimals that a comma between cells has torn from their number."""


def numbers(cells: Sequence[str], factor: float = 1.0) -> Any:
    """Values (n,) of cells, times `factor`: float64, or objects if some are no number.

    Cells that are no number stay text, and empty ones are None.
    """
    values: list[Any] = [
        factor * _number(cell) if NUMBER.fullmatch(cell) else cell for cell in cells
    ]
    if any(isinstance(value, str) for value in values):
        return pd.array([None if value == "" else value for value in values], dtype=object)
    return np.array(values, dtype=np.float64)


def seconds(cells: Sequence[str]) -> Array | None:
    """Seconds (n,) of times of a clock; None if a cell is none.

    The day is that of the date, if it changes; else a new one begins where the clock falls back by
    half of a day.
    """
    times = [time for time in map(CLOCK.fullmatch, cells) if time]
    if len(times) < len(cells):
        return None
    found = np.array([_of_day(time) for time in times])
    dates = [time["date"] or "" for time in times]
    days = _days({*dates})
    if days:
        return found + DAY * np.array([days[date] for date in dates])
    return found + DAY * np.cumsum(np.diff(found, prepend=found[:1]) < -0.5 * DAY)


def _of_day(time: re.Match[str]) -> float:
    """Seconds of a time, with the hour from 0 to 23 if it names the half of a day."""
    hour, half = int(time["hour"] or 0), time["half"]
    if half:
        hour = hour % 12 + 12 * (half in "Pp")
    minute = int(time["minute"] or time["minutes"])
    return 3600.0 * hour + 60.0 * minute + _number(time["second"].replace(":", "."))


def _days(dates: Collection[str]) -> dict[str, int]:
    """Days after the first of some dates; none if there is but one, or some are missing.

    Where day and month may stand in either order, fewer days between the dates are right.
    """
    found = []
    for order in ("%Y-%m-%d", "%d.%m.%Y", "%d/%m/%Y", "%m/%d/%Y"):
        with suppress(ValueError):
            days = {date: datetime.strptime(date, order).toordinal() for date in dates}
            first = min(days.values(), default=0)
            found.append({date: day - first for date, day in days.items()})
    return min(found, key=lambda days: max(days.values())) if found and len(dates) > 1 else {}


def rises(cells: Sequence[str]) -> bool:
    """Whether cells are numbers, or times of a clock, that rise from line to line, as time does."""
    values = seconds(cells)
    values = numbers(cells) if values is None else values
    return bool(values.dtype == np.float64 and len(values) > 1 and np.all(np.diff(values) > 0.0))


def decimal_comma(columns: Collection[Sequence[str]], path: PathLike, delimiter: str) -> bool:
    """Whether the numbers of a file have decimal commas.

    Parameters
    ----------
    columns
        Cells of each column that is read.
    path
        What messages call the file.
    delimiter
        What stands between its cells.

    Raises
    ------
    InputError
        If marks may be thousands separators, or cells are parts of torn numbers.
    """
    cells = [cell for column in columns for cell in column if NUMBER.fullmatch(cell)]
    commas, points = ([cell for cell in cells if mark in cell] for mark in ",.")
    if commas and points:
        raise InputError(
            f"{path}: numbers with a comma ({commas[0]}) and with a point ({points[0]}); export "
            "without thousands separators"
        )
    torn = next(filter(DECIMALS.fullmatch, cells), None)
    if torn and delimiter == "," and not commas and not points:
        raise InputError(
            f"{path}: {torn} begins with 0, as decimals do; if these are decimal commas, export "
            "with semicolons or decimal points"
        )
    all_may = all(map(THOUSANDS.fullmatch, commas or points))
    for column in columns:
        whole = next((cell for cell in column if cell.lstrip("+-").isdigit()), None)
        cell = next(filter(THOUSANDS.fullmatch, column), None)
        if whole and cell and (all_may or _jumps(column)):
            raise InputError(
                f"{path}: {cell} may be a decimal or have a thousands separator, as {whole} has no "
                f"{'comma' if commas else 'point'}; export without thousands separators, or all "
                "rows with decimals"
            )
    return bool(commas)


def _jumps(column: Sequence[str]) -> bool:
    """Whether a column goes back and forth unless its marks are thousands separators."""
    cells = [cell for cell in column if NUMBER.fullmatch(cell)]
    if not all(THOUSANDS.fullmatch(cell) or cell.lstrip("+-").isdigit() for cell in cells):
        return False
    read, joined = np.array([(_number(c), float(re.sub("[.,]", "", c))) for c in cells]).T
    ways = [np.abs(np.diff(x)).sum() / max(np.ptp(x), 1e-300) for x in (read, joined)]
    return bool(ways[0] > JUMPS * ways[1])


def _number(cell: str) -> float:
    return float(cell.replace(",", "."))
