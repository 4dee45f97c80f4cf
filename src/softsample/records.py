"""Test records: is one fit to be used, and what does it hold."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsample.arrays import Array, Mask
from softsample.errors import InputError, records_setting
from softsample.lone import lone_rows
from softsample.protocol import (
    LARGEST,
    NEVER_UNIFORM,
    SHEARED_MODES,
    Course,
    Loading,
    Phase,
    clock_of,
    phases,
    travel_sign,
)
from softsample.units import MM
from softsample.validation import refusals

SMALLEST_TRAVEL, SMALLEST_STRAIN = 0.1 * MM, 0.005
"""A platen moves so far at least; of a sample of known height so much of it is enough, as metres
taken for millimetres would be a thousandth of the strain."""
FEWEST_IN_RAMP = 5
"""A published curve may have few points, all of them good; the schema asks for as many."""
MANY_IN_RAMP = 20
"""Fewer samples in a ramp go with a warning."""
MISSING = 5.0
"""Samples are missing where an interval is this many times the usual one, and a large part."""
FEWEST_AT_REST = 10
LARGEST_GAP = 0.1
"""A ramp may lack samples over this part of its duration."""
OTHER_SIZE = 0.03
"""A file's own dimensions may differ by this part from those stated without a doubt raised."""
OFF_ZERO = 0.05
"""A ramp may begin at this part of its displacement or of its peak force without a doubt raised."""
FREE_PART, FREE_PARTS, FREE_FORCE, FREE_NOISE = 0.25, 20, 0.002, 3.0
"""The first quarter of a loading, in twentieths, is doubted if the mean force of each stays below
this part of the peak and so many standard errors."""
CLIPPED, CLIPPED_COARSE = 10, 5.0
"""A load cell is at its limit if its largest reading is repeated this often, and so many times as
often as half of the others, which few digits repeat too."""

RELAXED = 0.9
"""A loading at whose end less than this part of its largest force is left is doubted."""
REVERSED = 0.9
"""A record without time that begins beyond this part of its largest force, and ends at what is left
of it, is stored from the last line to the first."""
MOSTLY = 0.3
"""A column that is empty in more of its lines is not cured by deleting them."""
COLUMNS = {"displacement": "displacement_mm", "force": "force_N"}
"""Quantities with a sign and a zero that every record has, and their columns."""
STANDS_FOR = {"displacement": ("strain",), "force": ("stress",)}
COUNTED = ("loading", "tension", "compression")
"""What may count as positive; `loading` is right for most machines, whatever the mode."""
TITLED = "rename the column, whose title says that compression is positive"
STRETCHED = "exchange tension and compression in the column mode, or correct the file"
UNITS = {
    "time": ("time_s", 1.0),
    "displacement": ("displacement_mm", MM),
    "force": ("force_N", 1.0),
    "force_normal": ("force_normal_N", 1.0),
    "torque": ("torque_Nmm", MM),
}
"""Column of each quantity of a `Record`, and its unit in ours."""
ZEROED = {name: column for name, (column, _) in UNITS.items() if name != "time"}
"""Quantities with a zero, and their columns."""


@dataclass(frozen=True)
class Record:
    """One test in SI units.

    Parameters
    ----------
    time : (n,) float64 or None
        Time [s], ascending; None if the file tells none.
    displacement : (n,) float64
        Displacement of the moving platen [m], along +z (axial) or +x (shear).
    force : (n,) float64
        Force of the platen on the sample [N], same axis.
    force_normal : (n,) float64, optional
        Force of the platen on the sample along +z in a shear test [N].
    torque : (n,) float64, optional
        Torque of the platen on the sample about +z [N m].
    phase : (n,) str
        `baseline`, `ramp`, `hold` or `unloading`; empty before `marked`, as the next two.
    cycle : (n,) int64
        Number of the loading that a sample belongs to, from 1 on; 0 before the first.
    calibrated : (n,) bool
        Ramps of the loading that materials are calibrated on.
    """

    time: Array | None
    displacement: Array
    force: Array
    force_normal: Array | None = None
    torque: Array | None = None
    phase: NDArray[np.str_] = field(default_factory=lambda: np.empty(0, str))
    cycle: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    calibrated: Mask = field(default_factory=lambda: np.empty(0, bool))

    @classmethod
    def of_table(cls, table: pd.DataFrame) -> Self:
        """Record of the columns of a file, those of `records/{sample}.csv` or of a lab's table."""
        quantities: dict[str, Any] = {
            name: unit * table[column].to_numpy(np.float64) if column in table else None
            for name, (column, unit) in UNITS.items()
        }
        kinds = {"phase": str, "cycle": np.int64, "calibrated": bool}
        marks: dict[str, Any] = {
            name: table[name].to_numpy(kind) for name, kind in kinds.items() if name in table
        }
        return cls(**quantities, **marks)

    @property
    def table(self) -> pd.DataFrame:
        """Columns of the record's file, in its units."""
        values = {column: (getattr(self, name), unit) for name, (column, unit) in UNITS.items()}
        columns = {name: x / unit for name, (x, unit) in values.items() if x is not None}
        return pd.DataFrame(columns | self.marks)

    @property
    def marks(self) -> dict[str, NDArray[Any]]:
        """Columns `phase`, `cycle` and `calibrated`; none before `marked`."""
        if not len(self.phase):
            return {}
        return {
            "phase": self.phase.astype(object),
            "cycle": self.cycle,
            "calibrated": self.calibrated.astype(np.int64),
        }

    @property
    def timed(self) -> bool:
        """Whether time was recorded."""
        return self.time is not None

    @property
    def clock(self) -> Array:
        """Time (n,) [s], or numbers of samples where none was recorded."""
        return clock_of(self.time, self.force)

    def course(self, mode: str) -> Course:
        """Phases and loadings of the record as a test of a mode."""
        return Course.of(self.time, self.displacement, mode)

    def marked(self, mode: str) -> Self:
        """The record as a test of a mode: with phases, cycles and its largest loading.

        Raises
        ------
        InputError
            If there is no loading.
        """
        return self._marked_by(self.course(mode), LARGEST)

    def _marked_by(self, course: Course, which: str) -> Self:
        calibrated = np.zeros(len(self.force), dtype=bool)
        for ramp in course.chosen(which).ramps:
            calibrated[ramp] = True
        return replace(self, phase=course.phase, cycle=course.cycle, calibrated=calibrated)


def reach(records: Iterable[Record], mode: str) -> float:
    """Largest displacement of the platen in the loadings of some records [m], either way in shear.

    What lies beyond in a hold is noise of the reading.
    """
    found = []
    for record in records:
        loading = record.displacement[(record.phase == "ramp") | record.calibrated]
        along = np.abs(loading) if mode in SHEARED_MODES else travel_sign(mode) * loading
        found.append(float(along.max()))
    return max(found)


class Sized(Protocol):
    """A sample whose dimensions are stated, such as a `softsample.shapes.IdealShape`."""

    @property
    def area(self) -> float:
        """Area of its section [m2]."""

    @property
    def height(self) -> float:
        """Distance of the platens [m]."""


@dataclass(frozen=True)
class RecordSettings:
    """How records of a study are to be read, where the files do not say it.

    Parameters
    ----------
    columns, units
        Title and unit by quantity (`time`, `displacement`, `force`, `stress`, ...).
    positive
        What counts as positive, by quantity: `tension` (along +z, or +x in shear), `compression`,
        or `loading` (whatever the sample's mode is). A title such as "Compressive load" wins.
    zero
        Where zero is, by quantity: that of the `file`, the mean at `rest` before the ramp, or the
        first sample, `start`.
    sheet
        Of a workbook; None for the first with titles, if possible of time.
    block
        Name of the block of `formats` that these come from; empty for the section `records`.
    """

    columns: Mapping[str, str]
    units: Mapping[str, str]
    positive: Mapping[str, str]
    zero: Mapping[str, str]
    sheet: str | None = None
    block: str = ""

    @property
    def of_files(self) -> tuple[Mapping[str, str], Mapping[str, str], str | None, str]:
        """What `softsample.formats.machine.read` is told of files: columns, units, sheet, block."""
        return self.columns, self.units, self.sheet, self.block

    def setting(self, **keys: Any) -> str:
        """A line of settings that gives these keys other values, for messages."""
        return records_setting(keys, self.block)


def aligned_record(
    table: pd.DataFrame,
    reading: Mapping[str, Any],
    mode: str,
    settings: RecordSettings,
    schema: Mapping[str, Any],
    source: str,
    size: Sized | None = None,
    which: str = LARGEST,
) -> tuple[pd.DataFrame, dict[str, Any]]:
    """Bring a record to our signs and zero, check it, and report what it holds.

    Parameters
    ----------
    table, reading
        As read from the file, in mm, N, s and Pa (`softsample.formats.machine`).
    mode
        Of the test, a key of `softsample.protocol.DIRECTIONS`.
    settings
        Signs and zero of the study.
    schema
        Schema of the columns.
    source
        The file's path, for the message.
    size
        Dimensions of the sample, if they are stated: what turns nominal stress and strain into
        force and displacement.
    which
        The loading that is calibrated: `largest`, `first`, `last` or a number.

    Returns
    -------
    table : pandas.DataFrame
        The record with our signs and zero, and its columns `phase`, `cycle` and `calibrated`.
    facts : dict
        `samples`, `timed`, `sampling_rate_hz`, `duration_s`, `travel_mm`, `ramp_start_mm`,
        `ramp_speed_mm_s`, `peak_force_N`, `force_noise_N` (standard deviation at rest, None if
        never at rest), `force_offset_N`, `loadings`, `calibrated_loading`, `phases`, `warnings`,
        with a size `strain` and `stress_pa` (both ends of what is calibrated), and `reading`,
        `positive` and `subtracted` by column. What needs time is None without.

    Raises
    ------
    InputError
        Naming the file, the line, the value and the cure.
    """
    _refuse(_no_numbers(table, source))
    _refuse(_wrong_time(table, source))
    aligned = _forces(table.astype(np.float64), size, mode, source)
    faults, lone = lone_rows(aligned, source)
    _refuse(faults)  # first, as zero and signs rest on such rows
    positive, turned = {}, {}
    for quantity, column in COLUMNS.items():
        positive[column], turned[quantity] = _positive(quantity, reading, settings, table, mode)
        aligned[column] *= _sign(positive[column], mode)
    if ZEROED["force_normal"] in aligned:
        said = settings.positive.get("force_normal", "tension")
        aligned[ZEROED["force_normal"]] *= _sign(said, mode)
        positive[ZEROED["force_normal"]] = said
    subtracted = {
        column: _zero(_zero_of(quantity, mode, settings), aligned, column, source)
        for quantity, column in ZEROED.items()
        if column in aligned
    }
    aligned = aligned - pd.Series(subtracted).reindex(aligned.columns, fill_value=0.0)
    _refuse(_parts_of_one(aligned, reading, source))
    signs = _Signs(turned, settings)
    record, facts = _checked(aligned, mode, schema, source, signs, size, which)
    facts["warnings"] += lone
    facts["warnings"] += _own_size(reading, mode, size)
    facts["warnings"] += _untimed(reading, settings) if not record.timed else []
    facts["warnings"] += reading.get("doubts", [])
    return aligned.assign(**record.marks), {
        **facts,
        "reading": dict(reading),
        "positive": positive,
        "subtracted": subtracted,
    }


def _forces(table: pd.DataFrame, size: Sized | None, mode: str, source: str) -> pd.DataFrame:
    """The table with force and displacement in place of what a file may state for them.

    Nominal stress is force over the undeformed section; strain is displacement over height. In
    torsion the displacement is that of the rim, angle times radius, and the force is torque over
    radius, so that they do the same work.
    """
    if mode == "torsion":
        if size is None:
            raise InputError(
                f"{source}: the radius is not known; give shape cylinder with diameter_mm and "
                "height_mm in the table"
            )
        radius = np.sqrt(size.area / np.pi)
        rim = {
            "displacement_mm": table["angle_rad"] * radius / MM,
            "force_N": table["torque_Nmm"] * MM / radius,
        }
        return table.assign(**rim).drop(columns=["angle_rad", "torque_Nmm"])
    stated = [name for name in ("strain", "stretch", "stress_Pa") if name in table]
    if not stated:
        return table
    if size is None:
        raise InputError(
            f"{source}: {' and '.join(stated)} need dimensions, since the section and height that "
            "they were made with are not known; give the force and displacement that the machine "
            "recorded, or shape and dimensions in the table in place of the image"
        )
    columns: dict[str, Any] = {}
    for name in table.columns:
        if name in ("strain", "stretch"):
            columns["displacement_mm"] = (table[name] - (name == "stretch")) * size.height / MM
        elif name == "stress_Pa":
            columns["force_N"] = table[name] * size.area
        else:
            columns[str(name)] = table[name]
    return pd.DataFrame(columns)


def _own_size(reading: Mapping[str, Any], mode: str, size: Sized | None) -> Iterator[str]:
    """What to say of strain and stress that a file made with other dimensions than those stated."""
    if size is None or mode in NEVER_UNIFORM:
        return
    for name, of_file in reading.get("own_size", {}).items():
        stated = size.height / MM if name == "height_mm" else size.area / MM**2
        if abs(of_file - stated) > OTHER_SIZE * stated:
            made, here, unit = (
                ("strain is its displacement", "height", "mm")
                if name == "height_mm"
                else ("stress is its force", "section", "mm2")
            )
            yield (
                f"the file's own {made} over {of_file:.4g} {unit}, but the {here} in the table is "
                f"{stated:.4g} {unit}; correct the dimensions, or the unit that is wrong in the "
                "file, unless the machine was not told this sample's dimensions"
            )


def _positive(
    quantity: str,
    reading: Mapping[str, Any],
    settings: RecordSettings,
    table: pd.DataFrame,
    mode: str,
) -> tuple[str, str]:
    """What a column counts as positive, and what turns its sign round: `COUNTED`, or words."""
    if quantity == "displacement" and "stretch" in table:  # above 1 in tension, whoever wrote it
        return "tension", STRETCHED
    if {quantity, *STANDS_FOR[quantity]} & {*reading["compressive"]}:
        return "compression", TITLED
    said = settings.positive[quantity]
    return said, next(word for word in COUNTED if _sign(word, mode) != _sign(said, mode))


def _zero_of(quantity: str, mode: str, settings: RecordSettings) -> str:
    """Where a quantity has its zero; of the force in torsion, where the torque has it."""
    of_torque = settings.zero.get("torque") if (quantity, mode) == ("force", "torsion") else None
    return of_torque or settings.zero.get(quantity, "file")


def _zero(zero: str, table: pd.DataFrame, column: str, source: str) -> float:
    """What is subtracted from a column."""
    if zero == "start":
        return float(table[column].iloc[0])
    return float(table[column].iloc[_rest(table, source)].mean()) if zero == "rest" else 0.0


@dataclass(frozen=True)
class _Signs:
    """What turns wrong signs round: by quantity a word of `COUNTED`, or what else is to be done."""

    turned: Mapping[str, str]
    settings: RecordSettings

    def cure(self, quantity: str, wrong: Iterable[str]) -> str:
        """What turns a quantity round; one setting for all that are wrong."""
        if self.turned[quantity] not in COUNTED:
            return self.turned[quantity]
        positive = {name: self.turned[name] for name in wrong if self.turned[name] in COUNTED}
        return (
            "tell the machine's sign in the settings of the study: "
            f"{self.settings.setting(positive=positive)}"
        )


def _untimed(reading: Mapping[str, Any], settings: RecordSettings) -> list[str]:
    """What to say of a record without time."""
    may_be = reading.get("ascending", [])
    cure = (
        f"; if {may_be[0]!r} is the time, name it and its unit: "
        f"{settings.setting(columns={'time': may_be[0]}, units={'time': 's'})}"
        if len(may_be) == 1
        else ""
    )
    return [
        "no column is known to hold time: samples are taken in their order, and relaxation, rate "
        f"and drift cannot be told{cure}"
    ]


def _sign(positive: str, mode: str) -> float:
    """Factor from what a file counts as positive to tension."""
    return {"tension": 1.0, "compression": -1.0, "loading": travel_sign(mode)}[positive]


def _rest(table: pd.DataFrame, source: str) -> slice:
    """Samples at rest before the first movement."""
    record = Record.of_table(table)
    rest = _resting(phases(record.time, record.displacement))
    if rest.stop - rest.start < FEWEST_AT_REST:
        raise InputError(
            f"{source}: no rest before the ramp to take the zero from; set `records: zero` of the "
            "study to `start`, the first sample, or to `file`, or record a second of rest first"
        )
    return rest


def _resting(found: list[Phase]) -> slice:
    """Samples before the first movement; none if the record starts with it."""
    return found[0].samples if found[0].kind == "baseline" else slice(0, 0)


def _checked(
    table: pd.DataFrame,
    mode: str,
    schema: Mapping[str, Any],
    source: str,
    signs: _Signs,
    size: Sized | None,
    which: str,
) -> tuple[Record, dict[str, Any]]:
    """The record of a table with its phases and cycles, and what it holds."""
    _refuse(_no_numbers(table, source))
    _refuse(_out_of_bounds(table, schema, source))
    try:
        record = Record.of_table(table)
        course = record.course(mode)
        loading = course.chosen(which)
    except InputError as error:
        raise InputError(f"{source}, column 'displacement_mm': {error}") from error
    least = min(SMALLEST_TRAVEL, SMALLEST_STRAIN * size.height if size else np.inf)
    faults = _wrong_ramp(table, record, loading, source, least)
    _refuse([*faults, *_wrong_signs(table, record, loading, mode, source, signs)])
    _refuse(_wrong_side(record._marked_by(course, which), mode, source, signs.settings))
    return record._marked_by(course, which), {
        **_facts(record, course, loading, size, signs, table.index),
        "calibrated_loading": course.number(which),
    }


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
            empty = value is None or value != value
            cure = "delete the line or give the value, with a decimal point"
            if empty and len(bad) > MOSTLY * len(cells):
                cure = (
                    "record all channels at the same times; if the cells are formulas of a "
                    "workbook, save it in a spreadsheet program, which stores their values"
                )
            yield (
                f"{source}, line {table.index[bad[0]]}, column {column!r}: "
                f"{'empty' if empty else repr(value)} is not a number ({len(bad)} such cells); "
                f"{cure}"
            )


def _is_finite(cell: Any) -> bool:
    return isinstance(cell, int | float | np.number) and bool(np.isfinite(cell))


def _out_of_bounds(table: pd.DataFrame, schema: Mapping[str, Any], source: str) -> Iterator[str]:
    """The first refusal of each column, with the number of all."""
    values = table.to_numpy(np.float64)
    ends = {*values.argmin(axis=0), *values.argmax(axis=0)} if len(values) else set()
    few = table.iloc[sorted({*range(min(len(table), FEWEST_IN_RAMP)), *ends})]
    if not any(refusals(_cells(few), schema)):  # bounds hold for all if they hold for the ends
        return
    found: dict[str, list[tuple[str, str]]] = {}
    for place, reason in refusals(_cells(table), schema):
        column, _, number = place.partition(".")
        found.setdefault(column, []).append((number, reason))
    for column, reasons in found.items():
        number, reason = reasons[0]
        line = f", line {table.index[int(number)]}" if number else ""
        more = f" ({len(reasons)} such cells)" if len(reasons) > 1 else ""
        yield f"{source}{line}, column {column!r}: {reason}{more}"


def _cells(table: pd.DataFrame) -> dict[str, list[Any]]:
    return {str(name): table[name].tolist() for name in table.columns}


def _wrong_time(table: pd.DataFrame, source: str) -> Iterator[str]:
    if "time_s" not in table:
        return
    time = table["time_s"].to_numpy(dtype=np.float64)
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if len(back):
        at = int(back[0])
        if (np.diff(time) < 0.0).all():
            cure = "turn the lines round, as they are stored from the last to the first"
        elif (time[back + 1] < time[back]).any():
            again = time[at + 1] <= time[0]
            cure = (
                "let the time go on if it begins anew in each step" if again else "sort the lines"
            )
            cure += ", or give a test that begins here a file of its own"
            alone = {0: f"line {table.index[0]}", len(time) - 2: f"lines from {table.index[-1]} on"}
            if at in alone:
                cure = f"delete {alone[at]} if they are no readings, else {cure}"
        elif len(back) == 1:
            cure = "delete one of these lines if it repeats the other"
        else:
            cure = (
                f"{len(back)} times are rounded to that of the line before; export time with "
                "more decimals, or take its column out of the file (samples are then taken in "
                "their order, without effects of time)"
            )
        yield (
            f"{source}, line {table.index[at + 1]}, column 'time_s': {time[at + 1]:.10g} s follows "
            f"{time[at]:.10g} s, but time must rise from line to line; {cure}"
        )


def _wrong_ramp(
    table: pd.DataFrame, record: Record, loading: Loading, source: str, least: float
) -> Iterator[str]:
    """Refuse a ramp that moves less than `least` [m], or has too few samples."""
    way = abs(record.displacement[loading.last] - record.displacement[loading.start])
    if way < least:
        yield (
            f"{source}, column 'displacement_mm': the platen moves {way / MM:.3g} mm only; "
            "is the column in m instead of mm?"
        )
    samples = sum(ramp.stop - ramp.start for ramp in loading.ramps)
    if samples < FEWEST_IN_RAMP:
        yield (
            f"{source}: the loading ramp (lines {table.index[loading.start]} to "
            f"{table.index[loading.last]}) has {samples} samples; record at least "
            f"{FEWEST_IN_RAMP}, at a higher sampling rate"
        )


def _parts_of_one(table: pd.DataFrame, reading: Mapping[str, Any], source: str) -> Iterator[str]:
    """Refuse a strain in %, by its title, that moves the platen as little as parts of one would."""
    strain = reading.get("columns", {}).get("strain", {})
    way = np.ptp(table["displacement_mm"]) * MM
    if strain.get("unit") == "%" and 0.0 < way < SMALLEST_TRAVEL:
        yield (
            f"{source}, column {strain['title']!r}: the platen moves {way / MM:.3g} mm only; if "
            "these are parts of one, as in cells of a workbook that show %, write 1 in place of %"
        )


def _gap(lines: pd.Index, time: Array, ramp: slice) -> Iterator[str]:
    """Samples that are missing: the force is taken as straight in between."""
    gaps = np.diff(time[ramp])
    usual = MISSING * float(np.median(gaps)) if len(gaps) else np.inf
    if gaps.max(initial=0.0) > max(usual, LARGEST_GAP * (time[ramp.stop - 1] - time[ramp.start])):
        at = ramp.start + int(gaps.argmax())
        yield (
            f"line {lines[at + 1]}: {gaps.max():g} s are missing in the loading ramp; if the "
            "machine has recorded them, export the whole test, without decimation"
        )


def _wrong_signs(
    table: pd.DataFrame,
    record: Record,
    loading: Loading,
    mode: str,
    source: str,
    signs: _Signs,
) -> Iterator[str]:
    sign = travel_sign(mode)
    way = record.displacement[loading.last] - record.displacement[loading.start]
    force = _tenths(record.force[_rows(loading)])
    most = force[np.abs(force - force[0]).argmax()]
    wrong = ["displacement"] if sign * way <= 0.0 else []
    if (wrong or sign * most <= 0.0) and (turned := [*_turned_round(record, source)]):
        yield from turned
        return
    if sign * most <= 0.0 < sign * (most - force[0]):
        yield (
            f"{source}, column 'force_N': {force[0]:g} N as loading begins and {most:g} N later on "
            f"changes as it should in {mode}, but is {'positive' if sign < 0 else 'negative'}; if "
            f"the cell was not tared, set {signs.settings.setting(zero={'force': 'start'})}"
        )
    elif sign * most <= 0.0:
        wrong.append("force")
    values = {"displacement": way / MM, "force": most}
    for quantity in [name for name in wrong if not getattr(record, name).any()]:
        wrong.remove(quantity)
        yield (
            f"{source}, column {COLUMNS[quantity]!r}: 0 all along; is it the right column, and was "
            "the channel recorded?"
        )
    for quantity in wrong:
        yield (
            f"{source}, line {table.index[loading.last]}, column {COLUMNS[quantity]!r}: "
            f"{values[quantity]:g} in the loading that ends here, but "
            f"{'negative' if sign < 0 else 'positive'} is right in {mode} (force and displacement "
            "along +z or +x, so tension positive and compression negative); change the sample's "
            f"mode if it is wrong, or {signs.cure(quantity, wrong)}"
        )


def _wrong_side(record: Record, mode: str, source: str, settings: RecordSettings) -> Iterator[str]:
    """Refuse a loading that ends on the other side of zero."""
    reached, sign = reach([record], mode), travel_sign(mode)
    if reached <= 0.0:
        yield from [*_turned_round(record, source)] or [
            f"{source}, column 'displacement_mm': {sign * reached / MM:.4g} mm at the end of the "
            f"loading is {'below' if sign > 0.0 else 'above'} zero, where no sample is in {mode}; "
            "if zero is where the loading begins, set "
            f"{settings.setting(zero={'displacement': 'start'})}"
        ]


def _turned_round(record: Record, source: str) -> Iterator[str]:
    """What to say of a record without time from its largest force to almost none."""
    force = np.abs(record.force)
    begins, ends = REVERSED * force.max(), (1.0 - REVERSED) * force.max()
    if not record.timed and force[0] > begins and force[-1] < ends:
        yield (
            f"{source}: the record begins near its largest force and ends near none; if its lines "
            "are stored from the last to the first, turn them round, or give it a column of time"
        )


def _rows(loading: Loading) -> NDArray[np.intp]:
    """Numbers of the samples of a loading's ramps."""
    return np.concatenate([np.arange(ramp.start, ramp.stop) for ramp in loading.ramps])


def _tenths(force: Array) -> Array:
    """Mean force in each tenth of a loading, or of each sample if they are fewer."""
    return np.array([part.mean() for part in np.array_split(force, min(10, len(force)))])


def _facts(
    record: Record,
    course: Course,
    loading: Loading,
    size: Sized | None,
    signs: _Signs,
    lines: pd.Index,
) -> dict[str, Any]:
    """What is worth knowing about a record, in the units of files."""
    rest = _resting(course.phases)
    known = rest.stop - rest.start >= FEWEST_AT_REST
    rows = _rows(loading)
    force = record.force[rows]
    begin, end = record.displacement[[loading.start, loading.last]]
    peak = force[np.abs(force).argmax()]
    warnings = [] if known else ["no rest before the ramp: force zero and noise are not known"]
    warnings += _off_zero(record, loading, peak, rest if known else slice(0, 0), signs.settings)
    if known and loading is course.loadings[0]:
        warnings += _free(record, rows, rest, signs.settings)
    warnings += _relaxing(record, loading, signs)
    for ramp in loading.ramps if record.timed else ():
        warnings += _gap(lines, record.clock, ramp)
    if is_clipped(force):
        warnings.append(
            f"the force stays at {peak:g} N: the load cell seems to be overloaded, or the force "
            "was given (creep), which is no test of this model"
        )
    warnings += _few(record, rows)
    return {
        "samples": len(record.force),
        "timed": record.timed,
        **_pace(record, loading, abs(end - begin)),
        "travel_mm": float((end - begin) / MM),
        "ramp_start_mm": float(begin / MM),
        "peak_force_N": float(peak),
        "force_noise_N": float(record.force[rest].std(ddof=1)) if known else None,
        "force_offset_N": float(record.force[rest].mean()) if known else None,
        "loadings": len(course.loadings),
        "phases": [_told(phase, record) for phase in course.phases],
        **({} if size is None else _of_material(record, rows, size)),
        "warnings": warnings,
    }


def _few(record: Record, rows: NDArray[np.intp]) -> Iterator[str]:
    """What to say of few samples, or of few different readings, of a loading."""
    if len(rows) < MANY_IN_RAMP:
        yield f"the loading has {len(rows)} samples only"
        return
    for quantity in COLUMNS:
        different = len(np.unique(getattr(record, quantity)[rows]))
        if different < MANY_IN_RAMP:
            yield (
                f"the {quantity} has {different} different readings only in {len(rows)} samples of "
                "the loading; export it with more digits or, if it was recorded less often than "
                "the rest, record all at the same times"
            )


def _pace(record: Record, loading: Loading, way: float) -> dict[str, float | None]:
    """What only time tells."""
    if record.time is None:
        return dict.fromkeys(("sampling_rate_hz", "duration_s", "ramp_speed_mm_s"))
    time = record.time
    moving = sum(time[ramp.stop - 1] - time[ramp.start] for ramp in loading.ramps)
    return {
        "sampling_rate_hz": float(1.0 / np.median(np.diff(time))),
        "duration_s": float(time[-1] - time[0]),
        "ramp_speed_mm_s": float(way / MM / moving),
    }


def _told(phase: Phase, record: Record) -> dict[str, Any]:
    """A phase with its ends: times, or numbers of samples where there is no time."""
    ends = {"start": phase.start, "end": phase.stop - 1}
    if record.time is None:
        return {"kind": phase.kind, **ends}
    times = {f"{name}_s": float(record.time[at]) for name, at in ends.items()}
    return {"kind": phase.kind, **times}


def _of_material(record: Record, rows: NDArray[np.intp], size: Sized) -> dict[str, list[float]]:
    """Nominal strain and stress [Pa] at both ends of what is calibrated."""
    strain, stress = record.displacement[rows] / size.height, record.force[rows] / size.area
    return {
        "strain": [float(strain.min()), float(strain.max())],
        "stress_pa": [float(stress.min()), float(stress.max())],
    }


def _relaxing(record: Record, loading: Loading, signs: _Signs) -> Iterator[str]:
    """What says that the sample failed, or that what is taken for a ramp is none.

    A force that falls from the start of a single ramp on may as well have the wrong sign, if the
    cell was not tared.
    """
    tenths = _tenths(record.force[loading.ramps[-1]])
    highest = int(np.abs(tenths).argmax())
    largest, last = tenths[highest], tenths[-1]
    if abs(last) < RELAXED * abs(largest):
        falls = highest == 0 and len(loading.ramps) == 1
        sign = f"; if it should grow instead, {signs.cure('force', ['force'])}" if falls else ""
        yield (
            f"the force falls from {largest:.3g} N to {last:.3g} N along the loading, as in a hold "
            "or after failure; export the whole test with its ramp, or choose another loading in "
            f"column cycle{sign}"
        )


def _off_zero(
    record: Record, loading: Loading, peak: float, rest: slice, settings: RecordSettings
) -> Iterator[str]:
    """What says that the zero of the file is not that of the test."""
    begin, end = record.displacement[[loading.start, loading.last]]
    far = OFF_ZERO * abs(end - begin)
    zero = "rest" if rest.stop else "start"
    if abs(begin) > far:
        yield (
            f"the ramp begins at {begin / MM:.3g} mm, and the sample counts as deformed by that; "
            f"if it is not, set {settings.setting(zero={'displacement': zero})}"
        )
    before = record.force[rest] if rest.stop else record.force[:1]
    if rest.stop:
        loaded = abs(before.mean()) > max(OFF_ZERO * abs(peak), 5.0 * before.std(ddof=1))
    else:  # a test to both sides may be on its way through zero
        away = record.displacement
        there = abs(away[0]) <= far and not (away.min() < -far and away.max() > far)
        loaded = there and abs(before.mean()) > OFF_ZERO * abs(peak)
    if loaded:
        yield (
            f"the force before the ramp is {before.mean():.3g} N; if the sample is not loaded "
            f"there, set {settings.setting(zero={'force': zero})}"
        )


def _free(
    record: Record, rows: NDArray[np.intp], rest: slice, settings: RecordSettings
) -> Iterator[str]:
    """What says that the platen moves a long way before it loads the sample."""
    force = record.force - record.force[rest].mean()
    noise, least = force[rest].std(ddof=1), FREE_FORCE * np.abs(force[rows]).max()
    parts = np.array_split(rows, min(FREE_PARTS, len(rows)))
    loaded = [
        abs(force[part].mean()) > max(least, FREE_NOISE * noise / np.sqrt(len(part)))
        for part in parts
    ]
    free = loaded.index(True) if any(loaded) else len(parts)
    if FREE_PART * len(parts) <= free < len(parts):
        way = abs(record.displacement[parts[free][0]] - record.displacement[rows[0]])
        yield (
            f"the force stays within its noise over the first {way / MM:.3g} mm of the loading, "
            "which count as strain; if nothing touches there, delete the lines before contact and "
            f"set {settings.setting(zero={'displacement': 'start'})}"
        )


def is_clipped(force: Array) -> bool:
    """Whether the largest force is repeated exactly, many times as often as other readings are."""
    ends = np.flatnonzero(np.diff(force)) + 1
    often = np.diff([0, *ends, len(force)])
    at_peak = np.abs(force[[0, *ends]]) == np.abs(force).max()
    longest = int(np.where(at_peak, often, 0).argmax())
    others = np.delete(often, longest)
    usual = float(np.median(others)) if len(others) else 1.0
    return bool(often[longest] >= max(CLIPPED, CLIPPED_COARSE * usual))
