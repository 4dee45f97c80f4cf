"""Test records as machines write them: delimited text or workbooks with titles and units.

One reader takes what CellScale UniVert, Instron Bluehill (raw data), TA/Bose WinTest and plain
tables have in common: lines of metadata, a line of titles, units in the titles or in a line of
their own, numbers with decimal points or commas. It guesses no unit and no column: what the file
leaves open has to be named in the study's settings. Time may be missing, and stress and strain
may stand for force and displacement.

Its parts are `cells` (lines and cells), `columns` (what titles name), `heading` (the line of
titles), `rows` (the lines of numbers) and `values` (what cells hold).
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from softsample.errors import InputError
from softsample.files import PathLike
from softsample.formats.cells import Text, cell_at
from softsample.formats.columns import (
    NEEDED,
    TURNED,
    Asked,
    Column,
    of_quantities,
    with_unit,
)
from softsample.formats.heading import Heading, heading_of
from softsample.formats.rows import Rows, rows_of
from softsample.formats.titles import COLUMNS
from softsample.formats.values import decimal_comma, numbers, rises, seconds
from softsample.formats.workbook import is_workbook

OWN = {"height_mm": ("displacement", "strain", 1.0), "area_mm2": ("force", "stress", 1e6)}
"""Sizes that a file itself divided by: what it divided, what came out, and the unit."""

PROPORTIONAL = 0.003
"""They are told if both columns are proportional but for this part of the range."""

DERIVED = ("phase", "cycle", "calibrated")
"""Columns of our own results that are found anew."""

KINDS = (
    ("CellScale UniVert", r"\bSetName\b.*\bSize_mm\b"),
    ("TA/Bose WinTest", r"WinTest|ElectroForce"),
    ("Instron Bluehill", r"^\W*Dimension ?:|Bluehill|\bExtension\b.*\bLoad\b"),
)
"""Machines by what their files say."""


@dataclass(frozen=True)
class MachineRecord:
    """A record as read.

    Parameters
    ----------
    table : pandas.DataFrame
        Those of `COLUMNS` that the file holds, in their units, signs and zero of the file; cells
        that are no number are left as text. The index is the line in the file.
    reading : dict
        What was understood: `kind`, `columns` (title, unit and factor of each), `decimal_comma`,
        `compressive` (quantities whose titles count compression as positive), `ignored`
        (titles), `ascending` (those of them whose numbers rise as time does), `own_size` (the
        dimensions by which the file itself made strain and stress), `notes`, `doubts`; of a
        workbook `sheet`.
    """

    table: pd.DataFrame
    reading: dict[str, Any]


def read(
    path: PathLike,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    sheet: str | None = None,
    block: str = "",
    mode: str = "",
) -> MachineRecord:
    """Read a record of any of the known kinds, or a table whose columns are named.

    Parameters
    ----------
    path
        Text file (UTF-8, UTF-16 or Windows-1252), or a workbook (.xlsx, .xls).
    columns
        Titles by quantity (a key of `COLUMNS`), where they are not self-evident.
    units
        Units by quantity, where the file names none.
    sheet
        Of a workbook; by default the first visible one with titles, if possible of time.
    block
        Name of the block of `formats` that these come from, for the cures of messages.
    mode
        Of the test: one in torsion has an angle and a torque, one along the axis no shear stress.

    Raises
    ------
    InputError
        If a column or a unit is missing, ambiguous or contradictory, or the file is no such
        text; names file, line and cure. Wrong cells are left for `softsample.records`.
    """
    form = TURNED if mode == "torsion" else NEEDED
    axial = mode not in ("", "torsion") and "shear" not in mode
    asked = Asked(columns or {}, units or {}, block, form, axial)
    text, heading = _text_with_titles(path, sheet, asked)
    rows = rows_of(text, heading)
    found = _with_units(text, heading, rows, asked)
    cells = [rows.column(column.place) for column in found]
    comma = decimal_comma(cells, text.path, heading.delimiter)
    table, ignored = _table(text, heading, rows, found)
    reading = {
        "kind": _kind(text, heading),
        **({"sheet": text.sheet} if text.sheet else {}),
        "columns": {COLUMNS[column.quantity]: column.told(heading.line + 1) for column in found},
        "decimal_comma": comma,
        "compressive": [column.quantity for column in found if column.compressive],
        "ignored": ignored,
        "ascending": [title for title in ignored if rises(_titled(title, heading, rows))],
        "own_size": dict(_own_size(text, heading, rows, asked)),
        "notes": text.notes,
        "doubts": text.doubts,
    }
    return MachineRecord(table, reading)


def _text_with_titles(path: PathLike, sheet: str | None, asked: Asked) -> tuple[Text, Heading]:
    """The text of a file, or the first sheet of a workbook with titles, those of time before all.

    Others that could be the test as well are doubted.
    """
    if not is_workbook(path):
        if sheet is not None and Path(path).suffix.lower() in (".xlsx", ".xls"):
            raise InputError(f"{path}: no workbook, so it has no sheet {sheet!r}; save it as .xlsx")
        text = Text.of_file(path)
        return text, heading_of(text, asked)
    refused: list[InputError] = []
    usable: list[tuple[Text, Heading]] = []
    for text in Text.of_sheets(path, sheet):
        try:
            usable.append((text, heading_of(text, asked)))
        except InputError as error:
            refused.append(error)
    if not usable:
        raise refused[0] if refused else InputError(f"{path}: no sheet with cells; export the test")
    text, heading = next((one for one in usable if one[1].timed), usable[0])
    others = [o.sheet for o, h in usable if o is not text and h.timed == heading.timed]
    text.notes.append(f"sheet {text.sheet} is read")
    if others:
        text.doubts.append(
            f"sheet {text.sheet} is read, and others can be: {', '.join(others)}; name the right "
            f"one in the settings of the study, such as {asked.setting(sheet=others[0])}"
        )
    return text, heading


def _with_units(text: Text, heading: Heading, rows: Rows, asked: Asked) -> list[Column]:
    """The columns with their units; the cells of a clock tell theirs."""
    return [
        replace(column, unit="s", unit_from="cells")
        if column.quantity == "time" and seconds(rows.column(column.place)) is not None
        else with_unit(column, cell_at(rows.units, column.place), text.path, asked)
        for column in heading.columns
    ]


def _table(
    text: Text, heading: Heading, rows: Rows, found: Sequence[Column]
) -> tuple[pd.DataFrame, list[str]]:
    """Values of the columns by line, without lines that repeat another one, and titles left out."""
    values: dict[str, Any] = {}
    for column in found:
        cells = rows.column(column.place)
        if column.unit_from == "cells":
            values[COLUMNS[column.quantity]] = seconds(cells)
            text.notes.append("times of a clock are read as seconds, and go on after midnight")
        else:
            values[COLUMNS[column.quantity]] = numbers(cells, column.factor)
    read_from = {"", *(column.title for column in found)}
    ignored = [title for title in heading.titles if title not in read_from]
    if _is_ours(heading):  # the schema of records knows what else such a table may hold
        known = {*values, *DERIVED}
        values |= {
            title: numbers(_titled(title, heading, rows)) for title in ignored if title not in known
        }
        ignored = [title for title in ignored if title in known]
    table = pd.DataFrame(values, index=pd.Index(rows.lines, name="line", dtype=np.int64))
    repeated = table.duplicated() & ("time_s" in table)
    if repeated.any():
        text.notes.append(f"lines left out since they repeat another one: {int(repeated.sum())}")
    return table[~repeated], ignored


def _own_size(
    text: Text, heading: Heading, rows: Rows, asked: Asked
) -> Iterator[tuple[str, float]]:
    """The height [mm] and section [mm2] by which a file made the strain and stress beside it."""
    form = {name: (name,) for wholes in OWN.values() for name in wholes[:2]}
    found = of_quantities(heading.titles, replace(asked, form=form))
    for size, (whole, part, unit) in OWN.items():
        if not len(found[whole]) == len(found[part]) == 1:
            continue
        try:
            columns = [
                with_unit(column, cell_at(rows.units, column.place), text.path, asked)
                for column in (*found[whole], *found[part])
            ]
        except InputError:  # of a column that is not read
            continue
        if columns[1].unit_from == "settings":  # a strain without a unit may be in %
            continue
        y, x = (numbers(rows.column(column.place), column.factor) for column in columns)
        if x.dtype == y.dtype == np.float64 and np.isfinite(x).all() and np.ptp(x) > 0.0:
            slope, rest = np.polyfit(x, y, 1)
            if np.abs(y - slope * x - rest).max() < PROPORTIONAL * np.ptp(y):
                yield size, float(unit * abs(slope))


def _titled(title: str, heading: Heading, rows: Rows) -> list[str]:
    """Cells of the first column with a title."""
    return rows.column(heading.titles.index(title))


def _is_ours(heading: Heading) -> bool:
    """Whether titles are those of our own tables."""
    return {COLUMNS["displacement"], COLUMNS["force"]} <= set(heading.titles)


def _kind(text: Text, heading: Heading) -> str:
    """Which machine, or which kind of table, a file comes from."""
    if _is_ours(heading):
        return "softsample table"
    head = "\n".join(text.lines[: heading.line + 1])
    return next((kind for kind, sign in KINDS if re.search(sign, head, re.M)), "table")


def described(reading: Mapping[str, Any]) -> Iterator[str]:
    """What was understood of a file, in words: columns and units, then peculiarities."""
    parts = []
    for name, column in reading["columns"].items():
        times = "" if column["factor"] == 1.0 else f", times {column['factor']:.6g}"
        parts.append(f"{name} from {column['title']!r} in {column['unit']}{times}")
    yield "; ".join(parts)
    if "time_s" not in reading["columns"]:
        yield "no time: samples are taken in their order, and effects of time are no candidates"
    if reading["decimal_comma"]:
        yield "numbers have decimal commas"
    if reading["ignored"]:
        yield f"not used: {', '.join(reading['ignored'])}"
    yield from reading["notes"]
