"""Test records: is one fit to be used, and what does it hold."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsample.errors import InputError
from softsample.protocol import loading_ramp, phases, travel_sign
from softsample.validation import refusals

Array = NDArray[np.float64]

MM = 1e-3
SMALLEST_TRAVEL = 0.1 * MM
FEWEST_IN_RAMP = 20
LARGEST_GAP = 0.1
"""A ramp may lack samples over this part of its duration."""


@dataclass(frozen=True)
class Record:
    """One test in SI units.

    Parameters
    ----------
    time : (n,) float64
        Time [s], ascending.
    displacement : (n,) float64
        Travel of the moving platen [m], along +z (axial) or +x (shear).
    force : (n,) float64
        Force of the platen on the sample [N], same axis.
    """

    time: Array
    displacement: Array
    force: Array

    @property
    def ramp(self) -> slice:
        """Samples of the loading ramp."""
        return loading_ramp(self.time, self.displacement)


def record_from_table(table: pd.DataFrame) -> Record:
    """Record in SI units from the columns of a file."""
    time, displacement, force = (
        table[name].to_numpy(dtype=np.float64) for name in ("time_s", "displacement_mm", "force_N")
    )
    return Record(time, displacement * MM, force)


def check_record(
    table: pd.DataFrame, mode: str, schema: Mapping[str, Any], source: str
) -> dict[str, Any]:
    """Check a record and report what it holds.

    Parameters
    ----------
    table
        As read; the index is the line in the file.
    mode
        `tension`, `compression` or `shear`.
    schema
        Schema of the columns.
    source
        The file's path, for the message.

    Returns
    -------
    dict
        `samples`, `sampling_rate_hz`, `duration_s`, `travel_mm`, `ramp_speed_mm_s`,
        `peak_force_N`, `force_noise_N` (standard deviation at rest, None if never at rest),
        `force_offset_N`, `phases`, `warnings`.

    Raises
    ------
    InputError
        Naming the file, the line, the value and the cure.
    """
    _check_cells(table, schema, source)
    _check_time(table, source)
    record = record_from_table(table)
    try:
        ramp = record.ramp
    except InputError as error:
        raise InputError(f"{source}, column 'displacement_mm': {error}") from error
    _check_ramp(table, record, ramp, source)
    _check_signs(table, record, ramp, mode, source)
    return _facts(record, ramp)


def _check_cells(table: pd.DataFrame, schema: Mapping[str, Any], source: str) -> None:
    for column in table.columns:
        numbers = pd.to_numeric(table[column], errors="coerce")
        bad = np.flatnonzero(~np.isfinite(numbers.to_numpy(dtype=np.float64)))
        if len(bad):
            value = table[column].iloc[bad[0]]
            shown = "empty" if pd.isna(value) else repr(value)
            raise InputError(
                f"{source}, line {table.index[bad[0]]}, column {column!r}: {shown} is not a number "
                f"({len(bad)} such cells); delete the line or give the value, with a decimal point"
            )
    columns = {str(name): table[name].tolist() for name in table.columns}
    for place, reason in refusals(columns, schema):
        column, _, number = place.partition(".")
        line = f", line {table.index[int(number)]}" if number else ""
        raise InputError(f"{source}{line}, column {column!r}: {reason}")


def _check_time(table: pd.DataFrame, source: str) -> None:
    time = table["time_s"].to_numpy(dtype=np.float64)
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if len(back):
        at = int(back[0])
        raise InputError(
            f"{source}, line {table.index[at + 1]}, column 'time_s': {time[at + 1]:g} s follows "
            f"{time[at]:g} s; time must rise from line to line, so sort or delete repeated lines"
        )


def _check_ramp(table: pd.DataFrame, record: Record, ramp: slice, source: str) -> None:
    travel = abs(record.displacement[ramp.stop - 1] - record.displacement[ramp.start])
    time = record.time[ramp]
    if travel < SMALLEST_TRAVEL:
        raise InputError(
            f"{source}, column 'displacement_mm': the platen travels {travel / MM:.3g} mm only; "
            "is the column in m instead of mm?"
        )
    if len(time) < FEWEST_IN_RAMP:
        raise InputError(
            f"{source}: the loading ramp (lines {table.index[ramp.start]} to "
            f"{table.index[ramp.stop - 1]}) has {len(time)} samples; record at least "
            f"{FEWEST_IN_RAMP}, at a higher sampling rate"
        )
    gaps = np.diff(time)
    if gaps.max() > LARGEST_GAP * (time[-1] - time[0]):
        at = ramp.start + int(gaps.argmax())
        raise InputError(
            f"{source}, line {table.index[at + 1]}: {gaps.max():g} s are missing in the loading "
            "ramp; export the whole test, without decimation"
        )


def _check_signs(table: pd.DataFrame, record: Record, ramp: slice, mode: str, source: str) -> None:
    last = ramp.stop - 1
    tail = slice(max(ramp.start, last - max(5, (ramp.stop - ramp.start) // 20)), ramp.stop)
    values = {
        "displacement_mm": (record.displacement[last] - record.displacement[ramp.start]) / MM,
        "force_N": float(record.force[tail].mean()),
    }
    sign = travel_sign(mode)
    for column, value in values.items():
        if sign * value <= 0.0:
            raise InputError(
                f"{source}, line {table.index[last]}, column {column!r}: {value:g} at the end of "
                f"loading, but {'negative' if sign < 0 else 'positive'} is right in {mode} (force "
                "and travel along +z or +x, so tension positive and compression negative); "
                "change the column's sign, or the sample's mode"
            )


def _facts(record: Record, ramp: slice) -> dict[str, Any]:
    """What is worth knowing about a record, in the units of files."""
    found = phases(record.time, record.displacement)
    rest = found[0].samples if found[0].kind == "baseline" else slice(0, 0)
    known = rest.stop - rest.start >= 10
    force = record.force
    duration = record.time[ramp.stop - 1] - record.time[ramp.start]
    travel = record.displacement[ramp.stop - 1] - record.displacement[ramp.start]
    peak = force[ramp][np.abs(force[ramp]).argmax()]
    warnings = [] if known else ["no rest before the ramp: force zero and noise are not known"]
    if _is_clipped(force[ramp]):
        warnings.append(f"the force stays at {peak:g} N: the load cell seems to be overloaded")
    return {
        "samples": len(force),
        "sampling_rate_hz": float(1.0 / np.median(np.diff(record.time))),
        "duration_s": float(record.time[-1] - record.time[0]),
        "travel_mm": float(travel / MM),
        "ramp_speed_mm_s": float(abs(travel) / MM / duration),
        "peak_force_N": float(peak),
        "force_noise_N": float(force[rest].std(ddof=1)) if known else None,
        "force_offset_N": float(force[rest].mean()) if known else None,
        "phases": [
            {
                "kind": phase.kind,
                "start_s": float(record.time[phase.start]),
                "end_s": float(record.time[phase.stop - 1]),
            }
            for phase in found
        ],
        "warnings": warnings,
    }


def _is_clipped(force: Array, run: int = 10) -> bool:
    """Whether the largest force is repeated exactly by `run` samples in a row."""
    at_peak = np.abs(force) == np.abs(force).max()
    length = longest = 0
    for value in at_peak:
        length = length + 1 if value else 0
        longest = max(longest, length)
    return longest >= run
