"""Test records: is one fit to be used, and what does it hold."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsample.errors import InputError
from softsample.protocol import Phase, loading_ramp, phases, travel_sign
from softsample.validation import refusals

Array = NDArray[np.float64]

MM = 1e-3
SMALLEST_TRAVEL = 0.1 * MM
FEWEST_IN_RAMP = 20
FEWEST_AT_REST = 10
LARGEST_GAP = 0.1
"""A ramp may lack samples over this part of its duration."""
OFF_ZERO = 0.05
"""A ramp may begin at this part of its travel or of its peak force without a word."""
COLUMNS = {"displacement": "displacement_mm", "force": "force_N"}
"""Quantities with a sign and a zero, and their columns."""
TITLED = "rename the column, whose title says that compression is positive"


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
    force_normal : (n,) float64, optional
        Force of the platen along +z in a shear test [N].
    """

    time: Array
    displacement: Array
    force: Array
    force_normal: Array | None = None

    @property
    def ramp(self) -> slice:
        """Samples of the loading ramp."""
        return loading_ramp(self.time, self.displacement)


def record_from_table(table: pd.DataFrame) -> Record:
    """Record in SI units from the columns of a file."""
    time, displacement, force = (
        table[name].to_numpy(dtype=np.float64) for name in ("time_s", "displacement_mm", "force_N")
    )
    normal = table["force_normal_N"].to_numpy(float) if "force_normal_N" in table else None
    return Record(time, displacement * MM, force, normal)


def table_from_record(record: Record) -> pd.DataFrame:
    """Columns of a record's file, in its units."""
    columns = {
        "time_s": record.time,
        "displacement_mm": record.displacement / MM,
        "force_N": record.force,
        "force_normal_N": record.force_normal,
    }
    return pd.DataFrame({name: x for name, x in columns.items() if x is not None})


@dataclass(frozen=True)
class RecordSettings:
    """How records of a study are to be read, where the files do not say it.

    Parameters
    ----------
    columns, units
        Title and unit by quantity (`time`, `displacement`, `force`).
    positive
        What counts as positive, by quantity: `tension` (along +z, or +x in shear), `compression`,
        or `loading` (whatever the sample's mode is). A title such as "Compressive load" wins.
    zero
        Where zero is, by quantity: that of the `file`, or the mean at `rest` before the ramp.
    """

    columns: Mapping[str, str]
    units: Mapping[str, str]
    positive: Mapping[str, str]
    zero: Mapping[str, str]


def aligned_record(
    table: pd.DataFrame,
    reading: Mapping[str, Any],
    mode: str,
    settings: RecordSettings,
    schema: Mapping[str, Any],
    source: str,
) -> tuple[pd.DataFrame, dict[str, Any]]:
    """Bring a record to our signs and zero, check it, and report what it holds.

    Parameters
    ----------
    table, reading
        As read from the file, in mm, N and s (`softsample.formats.machine`).
    mode
        `tension`, `compression` or `shear`.
    settings
        Signs and zero of the study.
    schema
        Schema of the columns.
    source
        The file's path, for the message.

    Returns
    -------
    table : pandas.DataFrame
        The record with our signs and zero.
    facts : dict
        As of `check_record`, and `reading`, `positive` and `subtracted` by column.

    Raises
    ------
    InputError
        Naming the file, the line, the value and the cure.
    """
    _refuse(_no_numbers(table, source))
    _refuse(_wrong_time(table, source))
    aligned = table.astype(np.float64)
    positive, subtracted, cures = {}, {}, {}
    for quantity, column in COLUMNS.items():
        titled = quantity in reading["compressive"]
        positive[column] = "compression" if titled else settings.positive[quantity]
        sign = _sign(positive[column], mode)
        aligned[column] *= sign
        cures[quantity] = TITLED if titled else _cure(quantity, sign)
    for quantity, column in COLUMNS.items():
        subtracted[column] = 0.0
        if settings.zero[quantity] == "rest":
            subtracted[column] = float(aligned[column].iloc[_rest(aligned, source)].mean())
    aligned = aligned - pd.Series(subtracted).reindex(aligned.columns, fill_value=0.0)
    facts = check_record(aligned, mode, schema, source, cures)
    return aligned, {
        **facts,
        "reading": dict(reading),
        "positive": positive,
        "subtracted": subtracted,
    }


def _cure(quantity: str, sign: float) -> str:
    """What turns a sign round that is read with a factor."""
    other = "compression" if sign > 0.0 else "tension"
    setting = f"records: {{positive: {{{quantity}: {other}}}}}"
    return f"tell the machine's sign in the settings of the study: {setting}"


def _sign(positive: str, mode: str) -> float:
    """Factor from what a file counts as positive to tension."""
    return {"tension": 1.0, "compression": -1.0, "loading": travel_sign(mode)}[positive]


def _rest(table: pd.DataFrame, source: str) -> slice:
    """Samples at rest before the first movement."""
    record = record_from_table(table)
    rest = _resting(phases(record.time, record.displacement))
    if rest.stop - rest.start < FEWEST_AT_REST:
        raise InputError(
            f"{source}: no rest before the ramp to take the zero from; set `records: zero` of the "
            "study to `file`, or record a second of rest first"
        )
    return rest


def _resting(found: list[Phase]) -> slice:
    """Samples before the first movement; none if the record starts with it."""
    return found[0].samples if found[0].kind == "baseline" else slice(0, 0)


def check_record(
    table: pd.DataFrame,
    mode: str,
    schema: Mapping[str, Any],
    source: str,
    cures: Mapping[str, str] | None = None,
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
    cures
        What turns the sign of `displacement` and `force` round; by default the study's settings.

    Returns
    -------
    dict
        `samples`, `sampling_rate_hz`, `duration_s`, `travel_mm`, `ramp_start_mm`,
        `ramp_speed_mm_s`, `peak_force_N`, `force_noise_N` (standard deviation at rest, None if
        never at rest), `force_offset_N`, `phases`, `warnings`.

    Raises
    ------
    InputError
        Naming the file, the line, the value and the cure.
    """
    _refuse(_no_numbers(table, source))
    _refuse(_out_of_bounds(table, schema, source))
    _refuse(_wrong_time(table, source))
    record = record_from_table(table)
    try:
        ramp = record.ramp
    except InputError as error:
        raise InputError(f"{source}, column 'displacement_mm': {error}") from error
    faults = _wrong_ramp(table, record, ramp, source)
    known = cures or {quantity: _cure(quantity, 1.0) for quantity in COLUMNS}
    _refuse([*faults, *_wrong_signs(table, record, ramp, mode, source, known)])
    return _facts(record, ramp)


def _refuse(faults: Iterable[str]) -> None:
    """Raise an `InputError` that names all faults, if there are any."""
    found = list(faults)
    if found:
        raise InputError("\n".join(found))


def _no_numbers(table: pd.DataFrame, source: str) -> Iterator[str]:
    for column in table.columns:
        cells = table[column].tolist()
        bad = [n for n, cell in enumerate(cells) if not _is_finite(cell)]
        if bad:
            value = cells[bad[0]]
            shown = "empty" if value is None or value != value else repr(value)
            yield (
                f"{source}, line {table.index[bad[0]]}, column {column!r}: {shown} is not a number "
                f"({len(bad)} such cells); delete the line or give the value, with a decimal point"
            )


def _is_finite(cell: Any) -> bool:
    return isinstance(cell, int | float | np.number) and bool(np.isfinite(cell))


def _out_of_bounds(table: pd.DataFrame, schema: Mapping[str, Any], source: str) -> Iterator[str]:
    """The first refusal of each column, with the number of all."""
    columns = {str(name): table[name].tolist() for name in table.columns}
    found: dict[str, list[tuple[str, str]]] = {}
    for place, reason in refusals(columns, schema):
        column, _, number = place.partition(".")
        found.setdefault(column, []).append((number, reason))
    for column, reasons in found.items():
        number, reason = reasons[0]
        line = f", line {table.index[int(number)]}" if number else ""
        more = f" ({len(reasons)} such cells)" if len(reasons) > 1 else ""
        yield f"{source}{line}, column {column!r}: {reason}{more}"


def _wrong_time(table: pd.DataFrame, source: str) -> Iterator[str]:
    time = table["time_s"].to_numpy(dtype=np.float64)
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if len(back):
        at = int(back[0])
        yield (
            f"{source}, line {table.index[at + 1]}, column 'time_s': {time[at + 1]:g} s follows "
            f"{time[at]:g} s; time must rise from line to line, so sort or delete repeated lines"
        )


def _wrong_ramp(table: pd.DataFrame, record: Record, ramp: slice, source: str) -> Iterator[str]:
    travel = abs(record.displacement[ramp.stop - 1] - record.displacement[ramp.start])
    time = record.time[ramp]
    if travel < SMALLEST_TRAVEL:
        yield (
            f"{source}, column 'displacement_mm': the platen travels {travel / MM:.3g} mm only; "
            "is the column in m instead of mm?"
        )
    if len(time) < FEWEST_IN_RAMP:
        yield (
            f"{source}: the loading ramp (lines {table.index[ramp.start]} to "
            f"{table.index[ramp.stop - 1]}) has {len(time)} samples; record at least "
            f"{FEWEST_IN_RAMP}, at a higher sampling rate"
        )
    gaps = np.diff(time)
    if len(gaps) and gaps.max() > LARGEST_GAP * (time[-1] - time[0]):
        at = ramp.start + int(gaps.argmax())
        yield (
            f"{source}, line {table.index[at + 1]}: {gaps.max():g} s are missing in the loading "
            "ramp; export the whole test, without decimation"
        )


def _wrong_signs(
    table: pd.DataFrame,
    record: Record,
    ramp: slice,
    mode: str,
    source: str,
    cures: Mapping[str, str],
) -> Iterator[str]:
    last = ramp.stop - 1
    tail = slice(max(ramp.start, last - max(5, (ramp.stop - ramp.start) // 20)), ramp.stop)
    values = {
        "displacement": (record.displacement[last] - record.displacement[ramp.start]) / MM,
        "force": float(record.force[tail].mean()),
    }
    sign = travel_sign(mode)
    for quantity, value in values.items():
        if sign * value <= 0.0:
            yield (
                f"{source}, line {table.index[last]}, column {COLUMNS[quantity]!r}: {value:g} at "
                f"the end of loading, but {'negative' if sign < 0 else 'positive'} is right in "
                f"{mode} (force and travel along +z or +x, so tension positive and compression "
                f"negative); change the sample's mode if it is wrong, or {cures[quantity]}"
            )


def _facts(record: Record, ramp: slice) -> dict[str, Any]:
    """What is worth knowing about a record, in the units of files."""
    found = phases(record.time, record.displacement)
    rest = _resting(found)
    known = rest.stop - rest.start >= FEWEST_AT_REST
    force = record.force
    duration = record.time[ramp.stop - 1] - record.time[ramp.start]
    travel = record.displacement[ramp.stop - 1] - record.displacement[ramp.start]
    peak = force[ramp][np.abs(force[ramp]).argmax()]
    warnings = [] if known else ["no rest before the ramp: force zero and noise are not known"]
    warnings += _off_zero(record, ramp, rest if known else slice(0, 0))
    if _is_clipped(force[ramp]):
        warnings.append(f"the force stays at {peak:g} N: the load cell seems to be overloaded")
    return {
        "samples": len(force),
        "sampling_rate_hz": float(1.0 / np.median(np.diff(record.time))),
        "duration_s": float(record.time[-1] - record.time[0]),
        "travel_mm": float(travel / MM),
        "ramp_start_mm": float(record.displacement[ramp.start] / MM),
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


def _off_zero(record: Record, ramp: slice, rest: slice) -> Iterator[str]:
    """What says that the zero of the file is not that of the test."""
    begin, end = record.displacement[ramp.start], record.displacement[ramp.stop - 1]
    if abs(begin) > OFF_ZERO * abs(end - begin):
        yield (
            f"the ramp begins at {begin / MM:.3g} mm, and the sample counts as deformed by that; "
            "if it is not, set `records: {zero: {displacement: rest}}`"
        )
    before, peak = record.force[rest], np.abs(record.force[ramp]).max()
    if len(before) and abs(before.mean()) > max(OFF_ZERO * peak, 5.0 * before.std(ddof=1)):
        yield (
            f"the force before the ramp is {before.mean():.3g} N; if the sample is not loaded "
            "there, set `records: {zero: {force: rest}}`"
        )


def _is_clipped(force: Array, run: int = 10) -> bool:
    """Whether the largest force is repeated exactly by `run` samples in a row."""
    at_peak = np.abs(force) == np.abs(force).max()
    length = longest = 0
    for value in at_peak:
        length = length + 1 if value else 0
        longest = max(longest, length)
    return longest >= run
