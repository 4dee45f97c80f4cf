"""Test records as machines write them: delimited text or workbooks with titles and units.

One reader takes what CellScale UniVert, Instron Bluehill (raw data), TA/Bose WinTest and plain
tables have in common: lines of metadata, a line of titles, units in the titles or in a line of
their own, numbers with decimal points or commas. It guesses no unit and no column: what the file
leaves open has to be named in the study's settings. Time may be missing, and stress and strain
may stand for force and displacement.
"""

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NoReturn, Self

import numpy as np
import pandas as pd

from softsample.arrays import Array
from softsample.errors import InputError, records_setting
from softsample.files import PathLike
from softsample.formats.text import read_lines
from softsample.formats.titles import (
    BESIDE,
    COLUMNS,
    COMPRESSIVE,
    NAMES,
    NUMBERED,
    TRUE,
    UNITS,
)
from softsample.formats.workbook import is_workbook, read_sheets

Form = Mapping[str, Sequence[str]]

NEEDED: Form = {"displacement": ("displacement", "strain", "stretch"), "force": ("force", "stress")}
"""What every record holds, and the quantities that may stand for it, the first one first."""

TURNED: Form = {"displacement": ("angle",), "force": ("torque",)}
"""What stands for these where the sample is turned."""

ON_REQUEST = ("force_normal", "torque")
"""Quantities that are read where the settings name their column, and from our own tables."""

DERIVED = ("phase", "cycle", "calibrated")
"""Columns of our own results that are found anew."""

LOOKED_AT = 10
"""Lines below the titles that tell whether a column holds numbers."""

HEAD = 1000
"""Lines of which the likeliest one to be that of titles is told, if none is."""

KINDS = (
    ("CellScale UniVert", r"\bSetName\b.*\bSize_mm\b"),
    ("TA/Bose WinTest", r"WinTest|ElectroForce"),
    ("Instron Bluehill", r"^\W*Dimension ?:|Bluehill|\bExtension\b.*\bLoad\b"),
)
"""Machines by what their files say."""

NUMBER = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?", re.ASCII)

CLOCK = re.compile(
    r"(?:\d{4}-\d\d-\d\d[ T]|\d\d?[./]\d\d?[./]\d{4} )?(\d+):(\d\d):(\d\d(?:[.,]\d*)?)", re.ASCII
)
"""A time of day, or one that elapsed; a date before it is of no use."""

VALUE = re.compile(f"{NUMBER.pattern}|{CLOCK.pattern}", re.ASCII)

DAY = 86400.0
"""Seconds after which a clock begins anew."""

AROUND = "()[]{}<>（）［］ "
"""What may stand around a unit."""

BRACKETED = re.compile(r"(.*?)[\s_]*[(\[{<（［]([^()\[\]{}<>（）［］]*)[)\]}>）］]")
"""A title, and its unit in brackets."""

WORDS = r"[^\s_.:]+"
"""Each word of a title."""

RATIOS = ("strain", "stretch")
"""Quantities that need no unit."""

WORD = re.compile(r"[^\W\d_]{2}")

NO_NUMBERS = ("", "nan", "inf", "null", "none")
"""What machines write, in lower case, where they have no number."""

THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}", re.ASCII)
"""A number that may have a thousands separator."""

GROUPED = re.compile(
    r"([+-]?)([1-9]\d{0,2}(?:(?:,\d{3})+(?=\.)|(?:\.\d{3})+(?=,)|(?:['’\xa0\u2009\u202f]\d{3})+))"
    r"([.,]\d*)?",
    re.ASCII,
)
"""A number that has them for certain: sign, thousands, and decimals behind another mark."""

LONGEST_TITLE = 6
"""A title in quotes goes over fewer lines."""

OPENED = re.compile(r'(?:^|[\t;,])\s*"[^"]*$')
"""A line that ends within quotes; a mark of inches opens none."""

MINUS = "\u2212"
"""The minus sign of typesetters."""

DECIMALS = re.compile(r"[+-]?0\d+", re.ASCII)
"""Decimals that a comma between cells has torn from their number."""


@dataclass(frozen=True)
class Column:
    """A column of a file that holds one of the quantities.

    Parameters
    ----------
    quantity : str
        Key of `COLUMNS`.
    place : int
        Position in a line.
    title, unit : str
        As written; the unit is empty if only the line below tells it.
    unit_from : str
        What tells the unit: `title`, `below` (a line of units), `settings`, or the `cells` of a
        clock.
    """

    quantity: str
    place: int
    title: str
    unit: str
    unit_from: str = "title"

    @property
    def compressive(self) -> bool:
        """Whether the title says that compression is positive."""
        return any(word in self.title.lower() for word in COMPRESSIVE)

    @property
    def factor(self) -> float:
        """Size of the unit in ours."""
        return UNITS[self.quantity][self.unit]

    def told(self, line: int) -> dict[str, str | float]:
        """What was understood of it; `line` is that of the titles."""
        return {
            "title": self.title,
            "unit": self.unit,
            "factor": self.factor,
            "unit_from": self.unit_from,
            "unit_line": line + (self.unit_from == "below"),
        }


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
        (titles), `ascending` (those of them whose numbers rise as time does), `notes`, `doubts`;
        of a workbook `sheet`.
    """

    table: pd.DataFrame
    reading: dict[str, Any]


@dataclass
class _Text:
    """The lines of a file, taken apart as its line of titles asks for."""

    path: PathLike
    lines: list[str]
    notes: list[str] = field(default_factory=list)
    sheet: str = ""
    doubts: list[str] = field(default_factory=list)

    @classmethod
    def of_file(cls, path: PathLike) -> Self:
        """Decode a file; what is not text is refused."""
        try:
            lines, notes = read_lines(path, "export the test as CSV, text or .xlsx")
        except FileNotFoundError as error:
            raise InputError(f"{path}: no such record; correct its path in the table") from error
        return cls(path, _joined(lines), notes)

    @classmethod
    def of_sheets(cls, path: PathLike, sheet: str | None) -> Iterator[Self]:
        """The sheets of a workbook, or the one that is named."""
        for name, lines in read_sheets(path, sheet):
            yield cls(f"{path} (sheet {name})", lines, sheet=name)

    def cells(self, line: str, delimiter: str) -> list[str]:
        """Cells of a line without blanks around them and without empty ones at its end."""
        try:
            cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
        except csv.Error:
            return [line]
        cells = [_plain(cell.strip()) for cell in cells]
        while cells and not cells[-1]:
            cells.pop()
        return cells


def _joined(lines: Sequence[str]) -> list[str]:
    """Lines with those in one that a title in quotes goes over; empty ones keep their numbers."""
    joined = [*lines]
    first = -LONGEST_TITLE
    for number, line in enumerate(lines):
        if line.count('"') % 2 == 0:
            continue
        if number - first < LONGEST_TITLE:
            joined[first : number + 1] = [" ".join(lines[first : number + 1])]
            joined[first + 1 : first + 1] = [""] * (number - first)
            first = -LONGEST_TITLE
        elif OPENED.search(line):
            first = number
    return joined


def _plain(cell: str) -> str:
    """A cell as it stands; a number without thousands separators, and with the usual minus."""
    if NUMBER.fullmatch(cell):
        return cell
    plain = cell.replace(MINUS, "-", 1)
    if grouped := GROUPED.fullmatch(plain):
        sign, thousands, decimals = grouped.groups(default="")
        plain = sign + re.sub(r"\D", "", thousands) + decimals
    return plain if NUMBER.fullmatch(plain) else cell


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
        Name of the sheet of a workbook; by default the first with titles, if possible of time.
    block
        Name of the block of `formats` that these come from, for the cures of messages.
    mode
        Of the test: one in torsion has an angle and a torque.

    Raises
    ------
    InputError
        If a column or a unit is missing, ambiguous or contradictory, or the file is no such
        text; names file, line and cure. Wrong cells are left for `softsample.records`.
    """
    form = TURNED if mode == "torsion" else NEEDED
    text, heading = _text_with_titles(path, columns or {}, sheet, block, form)
    found = heading.columns
    rows, kept, names = _rows(text, heading)
    if cut := _cut_off(text, heading, rows, kept):
        text.doubts.append(cut)
        rows, kept = rows[:-1], kept[:-1]
    clock = _clock(rows, found)
    found = [
        replace(column, unit="s", unit_from="cells")
        if column.quantity == "time" and clock is not None
        else _with_unit(column, names, units or {}, text, block)
        for column in found
    ]
    comma = _decimal_comma(rows, found, text.path, heading.delimiter)
    titles = heading.titles
    own = {COLUMNS["displacement"], COLUMNS["force"]} <= set(titles)
    cells = {
        COLUMNS[column.quantity]: _numbers(rows, column.place, column.factor) for column in found
    }
    if clock is not None:
        cells[COLUMNS["time"]] = clock
        text.notes.append("times of a clock are read as seconds, and go on after midnight")
    ignored = [title for title in titles if title not in {"", *(one.title for one in found)}]
    if own:  # the schema of records knows what else such a table may hold
        more = [title for title in ignored if title not in {*cells, *DERIVED}]
        cells |= {title: _numbers(rows, titles.index(title), 1.0) for title in more}
        ignored = [title for title in ignored if title not in more]
    table = pd.DataFrame(cells, index=pd.Index(kept, name="line", dtype=np.int64))
    repeated = table.duplicated() & ("time_s" in table)
    if repeated.any():
        text.notes.append(f"lines left out since they repeat another one: {int(repeated.sum())}")
    reading = {
        "kind": _kind(text.lines[: heading.line + 1], own),
        **({"sheet": text.sheet} if text.sheet else {}),
        "columns": {COLUMNS[column.quantity]: column.told(heading.line + 1) for column in found},
        "decimal_comma": comma,
        "compressive": [column.quantity for column in found if column.compressive],
        "ignored": ignored,
        "ascending": _ascending(rows, titles, ignored),
        "notes": text.notes,
        "doubts": text.doubts,
    }
    return MachineRecord(table[~repeated], reading)


@dataclass(frozen=True)
class _Heading:
    """The line of titles: its number from 0 on, delimiter, titles, columns of the quantities."""

    line: int
    delimiter: str
    titles: list[str]
    columns: list[Column]

    @property
    def timed(self) -> bool:
        """Whether one of the columns is time."""
        return any(column.quantity == "time" for column in self.columns)


def _text_with_titles(
    path: PathLike, wanted: Mapping[str, str], sheet: str | None, block: str, form: Form
) -> tuple[_Text, _Heading]:
    """The text of a file, or the first sheet of a workbook with titles, those of time before all.

    What could be read instead is told.
    """
    if not is_workbook(path):
        if sheet is not None and Path(path).suffix.lower() in (".xlsx", ".xls"):
            raise InputError(f"{path}: no workbook, so it has no sheet {sheet!r}; save it as .xlsx")
        text = _Text.of_file(path)
        return text, _heading(text, wanted, block, form)
    refused: list[InputError] = []
    usable: list[tuple[_Text, _Heading]] = []
    for text in _Text.of_sheets(path, sheet):
        try:
            usable.append((text, _heading(text, wanted, block, form)))
        except InputError as error:
            refused.append(error)
    if not usable:
        raise refused[0] if refused else InputError(f"{path}: no sheet with cells; export the test")
    text, heading = next((one for one in usable if one[1].timed), usable[0])
    others = [other.sheet for other, _ in usable if other is not text]
    text.notes.append(f"sheet {text.sheet} is read")
    if others:
        cure = records_setting({"sheet": others[0]}, block)
        text.notes.append(f"sheets that can be read instead: {', '.join(others)}; set {cure}")
    return text, heading


def _heading(text: _Text, wanted: Mapping[str, str], block: str, form: Form) -> _Heading:
    """The first line with titles of all quantities, or else of all but time."""
    untimed: _Heading | None = None
    best: tuple[int, list[str], list[str]] = (0, [], [*COLUMNS])
    score = (len(COLUMNS), 0)
    for number, line in enumerate(text.lines):
        if line.lstrip().startswith("#") or (untimed and not WORD.search(line)):
            continue
        for delimiter in ("\t", ";", ","):
            titles = text.cells(line, delimiter)
            if len(titles) < len(form):
                continue
            candidates = _quantities(titles, wanted, form)
            needed = dict.fromkeys((*form, *wanted))
            missing = [name for name in needed if not candidates.get(name, True)]
            if missing:
                if untimed is None and not all(VALUE.fullmatch(title) for title in titles):
                    below = _units_below(text, number, titles) if number < HEAD else ()
                    of_line = (len(missing), -len(below))
                    best = (number, titles, missing) if of_line < score else best
                    score = min(score, of_line)
                continue
            where = f"{text.path}, line {number + 1}"
            columns = [_only(found, where, block) for found in candidates.values() if found]
            if all(_cell(titles, one.place + 1) in UNITS[one.quantity] for one in columns):
                raise InputError(
                    f"{where}: units stand in cells of their own ({', '.join(titles)}), so that "
                    "titles are not above their numbers; write units in brackets"
                )
            heading = _Heading(number, delimiter, titles, columns)
            if heading.timed:
                return heading
            untimed = untimed or heading
    if untimed is None:
        _no_titles(text, *best, wanted, block, form)
    return untimed


def _no_titles(
    text: _Text,
    number: int,
    titles: Sequence[str],
    missing: Sequence[str],
    wanted: Mapping[str, str],
    block: str,
    form: Form,
) -> NoReturn:
    """Refuse a text without a line of titles; `missing` quantities lack in the best line."""
    if not titles:
        _nothing_like_titles(text)
    ways = [_ways_told(form.get(name, (name,))) for name in missing]
    below = _units_below(text, number, titles)
    found = (_plausible(titles, below, form.get(name, (name,))) for name in missing)
    named = dict(filter(None, found))
    where = f"formats: {block}" if block else "records"
    absent = [wanted[way] for name in missing for way in form.get(name, (name,)) if way in wanted]
    if absent:
        raise InputError(
            f"{text.path}, line {number + 1}: no column is called {' or '.join(map(repr, absent))} "
            f"(there are {', '.join(map(repr, titles))}); correct `columns` in section {where} of "
            "the settings"
        )
    first = [form.get(name, (name,))[0] for name in missing]
    example = records_setting({"columns": dict.fromkeys(first, "its title")}, block)
    cure = f"export the test with titles of these, or name them in the settings, such as {example}"
    if len(named) == len(missing) == len({*named.values()}):
        keys = {"columns": named}
        silent = [
            name
            for name, title in named.items()
            if not below[title] and not _split(title, name)[1] and name not in RATIOS
        ]
        if silent:
            keys["units"] = {name: next(iter(UNITS[name])) for name in silent}
        it, its = ("it", "its") if len(named) == 1 else ("these", "their")
        cure = (
            f"if {' and '.join(map(repr, named.values()))} may be {it}, name {it}"
            f"{f' and {its} unit' if silent else ''} in the settings of the study: "
            f"{records_setting(keys, block)}"
        )
    elif form is NEEDED and (true := [title for title in below if _is_true(title)]):
        cure = (
            f"nominal stress and strain are needed, and {' and '.join(map(repr, true))} "
            f"{'are' if len(true) > 1 else 'is'} of the deformed sample; export force and "
            "displacement, or convert: stretch = exp(true strain), nominal stress = true stress / "
            "stretch (of an incompressible sample)"
        )
    raise InputError(
        f"{text.path}, line {number + 1}: no column is known to hold {', nor '.join(ways)} "
        f"(there are {', '.join(map(repr, titles))}); {cure}"
    )


def _nothing_like_titles(text: _Text) -> NoReturn:
    """Refuse a text that is empty, has numbers alone, or its titles in a comment."""
    if not any(line.strip() for line in text.lines):
        raise InputError(f"{text.path}: the file is empty; export the test again")
    comments = [line.strip() for line in text.lines if line.lstrip().startswith("#")]
    titled = (
        line
        for line in comments
        for delimiter in "\t;,"
        if len(titles := text.cells(line.lstrip("# "), delimiter)) > 1
        and any(_candidates(name, titles, {}) for name in NAMES)
    )
    comment = next(titled, "")
    cure = (
        f"if {comment!r} are its titles, delete the #"
        if comment
        else "export the test with its titles, separated by commas, semicolons or tabs"
    )
    raise InputError(
        f"{text.path}: no line of titles such as time_s,displacement_mm,force_N; {cure}"
    )


def _ways_told(ways: Sequence[str]) -> str:
    """A quantity and what may stand for it, in words."""
    first, *others = ways
    return f"{first} ({' or '.join(others)} may stand for it)" if others else first


def _units_below(text: _Text, number: int, titles: Sequence[str]) -> dict[str, str]:
    """Titles with numbers below them, and what stands between in a line of units, if there is one.

    It is empty where numbers begin at once.
    """
    line = text.lines[number]
    delimiter = next((d for d in "\t;," if len(text.cells(line, d)) > 1), ",")
    rows = [text.cells(row, delimiter) for row in text.lines[number + 1 : number + 1 + LOOKED_AT]]
    found = {}
    for place, title in enumerate(titles):
        cells = [_cell(row, place) for row in rows if any(row)]
        if any(map(NUMBER.fullmatch, cells)):
            found[title] = "" if NUMBER.fullmatch(cells[0]) else cells[0].strip(AROUND)
    return found


def _plausible(
    titles: Sequence[str], below: Mapping[str, str], ways: Sequence[str]
) -> tuple[str, str] | None:
    """The only column of numbers that may hold one of some quantities, and which one of them.

    It has a unit of it, in its title or `below`, or else none; which one it is, its unit tells, or
    a word of its title.
    """

    def unit(title: str, way: str) -> str:
        return _split(title, way)[1] or below[title]

    def is_another(title: str, name: str) -> bool:
        return bool(_candidates(name, [title], {})) and unit(title, name) in ("", *UNITS[name])

    free = [
        title
        for title in titles
        if title in below
        and not _is_true(title)
        and not any(is_another(title, name) for name in NAMES)
    ]
    units = {unit for way in ways for unit in UNITS[way]}
    fitting = [title for title in free if any(unit(title, way) in units for way in ways)]
    silent = [title for title in free if not any(unit(title, name) for name in COLUMNS)]
    title = next((found[0] for found in (fitting, silent) if len(found) == 1), None)
    if title is None:
        return None
    words = _words(title)

    def fits(way: str) -> tuple[bool, bool]:
        return unit(title, way) in UNITS[way], bool(words & NAMES.get(way, set()))

    return max(ways, key=fits), title


def _quantities(
    titles: Sequence[str], wanted: Mapping[str, str], form: Form
) -> dict[str, list[Column]]:
    """Columns that may hold each quantity, by quantity; of what may stand for one, the first."""
    found = {"time": _candidates("time", titles, wanted)}
    for needed, ways in form.items():
        named = [way for way in ways if way in wanted] or ways
        candidates = (_candidates(way, titles, wanted) for way in named)
        found[needed] = next(filter(None, candidates), [])
    others = [name for name in ON_REQUEST if name not in form["force"]]
    asked = [name for name in others if name in wanted or COLUMNS[name] in titles]
    return found | {name: _candidates(name, titles, wanted) for name in asked}


def _candidates(quantity: str, titles: Sequence[str], wanted: Mapping[str, str]) -> list[Column]:
    """Columns that may hold a quantity; those with one of its units, if there are any."""
    if quantity in wanted or COLUMNS[quantity] in titles:
        name = wanted.get(quantity, COLUMNS[quantity])
        places = [place for place, title in enumerate(titles) if title == name] or [
            place for place, title in enumerate(titles) if _split(title, quantity)[0] == name
        ]
        named = [(titles[place], place) for place in places]
        return [Column(quantity, at, title, _split(title, quantity)[1]) for title, at in named]
    found = []
    for place, title in enumerate(titles):
        name, unit = _split(title, quantity)
        words = _unnumbered(name)
        if words and (words - BESIDE or words) <= NAMES[quantity]:
            found.append(Column(quantity, place, title, unit))
    fitting = [column for column in found if column.unit in UNITS[quantity]]
    silent = [column for column in found if not column.unit]
    return fitting or silent or found


def _words(title: str) -> set[str]:
    return set(re.findall(WORDS, title.lower()))


def _is_true(title: str) -> bool:
    """Whether a title says that it is of the deformed sample, while nominal ones are needed."""
    return not TRUE.isdisjoint(re.findall(r"[^\W_]+", title.lower()))


def _unnumbered(title: str) -> set[str]:
    """Words of a title without numbers of specimens or channels."""
    return {word for word in _words(title) if not NUMBERED.fullmatch(word)}


def _split(title: str, quantity: str) -> tuple[str, str]:
    """Name and unit of a title: `Load (N)`, `Load [N]`, `Load, N`, `Load_N`, `Weg in mm`."""
    if bracketed := BRACKETED.fullmatch(title):
        return bracketed[1], bracketed[2].strip()
    behind = re.fullmatch(r"(.+?)(?:\s*[_/,]\s*|\s+in\s+|\s+)([^\s_/,]+)", title)
    if behind and behind[2] in UNITS[quantity]:
        return behind[1], behind[2]
    return title, ""


def _only(columns: Sequence[Column], where: str, block: str) -> Column:
    """The only candidate, or an error that names them all."""
    if len(columns) > 1:
        quantity = columns[0].quantity
        titles = [column.title for column in columns]
        name = records_setting({"columns": {quantity: titles[0]}}, block)
        alike = len({frozenset(_unnumbered(title)) for title in titles}) < len(titles)
        cure = (
            "delete the columns of other tests, or give each its own title"
            if titles.count(titles[0]) > 1
            else f"name the right one in the settings of the study, such as {name}"
        )
        if alike and titles.count(titles[0]) == 1:
            cure += ", or in a block of `formats` for each row if they are of several specimens"
        raise InputError(
            f"{where}: {len(columns)} columns may hold {quantity} "
            f"({', '.join(map(repr, titles))}); {cure}"
        )
    return columns[0]


def _rows(text: _Text, heading: _Heading) -> tuple[list[list[str]], list[int], list[str]]:
    """Cells of the lines of numbers, their numbers in the file, and the line of units if any.

    Titles and units may be repeated, with metadata before them, where a machine begins a new
    block of the same test; metadata may also end the file.
    """
    units: list[str] = []
    rows: list[list[str]] = []
    kept: list[int] = []
    metadata: list[int] = []
    blocks: list[int] = []
    titles, found = heading.titles, heading.columns
    for number, line in enumerate(text.lines[heading.line + 1 :], start=heading.line + 2):
        cells = text.cells(line, heading.delimiter)
        if not any(cells) or line.lstrip().startswith("#"):
            continue
        numbers = [bool(VALUE.fullmatch(_cell(cells, column.place))) for column in found]
        if not rows and not units and not any(numbers) and {*map(str.lower, cells)} != {"nan"}:
            units = cells
        elif cells in (titles, units):
            if cells == titles:
                blocks.append((metadata or [number])[0])
            metadata = []
        elif not numbers[0]:
            metadata.append(number)
        else:
            _check_line(text, metadata, number, cells, heading)
            rows.append(cells)
            kept.append(number)
    _end(text, heading, metadata, bool(rows))
    if not rows:
        raise InputError(f"{text.path}: no numbers below the titles; export the whole test")
    if blocks:
        text.notes.append(f"repetitions of the titles: {len(blocks)}; all blocks are read")
    if blocks and not heading.timed:
        text.doubts.append(
            f"line {blocks[0]}: {text.lines[blocks[0] - 1].strip()!r} begins another block, which "
            "is read as a part of the same test; if of another specimen, give each its own file"
        )
    return rows, kept, units


def _end(text: _Text, heading: _Heading, metadata: Sequence[int], numbers: bool) -> None:
    """Leave out the lines after the last row of numbers if they are metadata, and say so."""
    faulty = [line for line in metadata if not numbers or _is_row(text, heading, line)]
    _check_line(text, faulty, 0, [], heading)
    if metadata:
        line = text.lines[metadata[0] - 1].strip()
        text.notes.append(f"metadata below the numbers, from line {metadata[0]} on: {line!r}")


def _is_row(text: _Text, heading: _Heading, number: int) -> bool:
    """Whether a line without a number in its first column is meant as one of numbers.

    It holds nothing but numbers and what stands for missing ones, or more than one number of
    those that are looked for: a line of metadata has a title before a value.
    """
    cells = text.cells(text.lines[number - 1], heading.delimiter)
    found = [VALUE.fullmatch(_cell(cells, column.place)) for column in heading.columns]
    numeric = [VALUE.fullmatch(cell) or cell.lower() in NO_NUMBERS for cell in cells]
    return all(numeric) or sum(map(bool, found)) > 1


def _cut_off(
    text: _Text, heading: _Heading, rows: Sequence[Sequence[str]], kept: Sequence[int]
) -> str:
    """What says that a file ends within its last number; empty if its last line is whole.

    A cut line has no end, and its last cell fewer decimals than all others of the column, which
    have one number of them.
    """
    place = max(column.place for column in heading.columns)
    *before, last = (_cell(row, place) for row in rows)
    decimals = {_decimals(cell) for cell in before}
    of_last_line = kept[-1] == len(text.lines) and text.lines[-1].endswith(last)
    if text.sheet or not of_last_line or len(rows[-1]) != place + 1 or len(before) < LOOKED_AT:
        return ""
    if len(decimals) > 1 or _decimals(last) >= max(decimals) or not NUMBER.fullmatch(last):
        return ""
    return (
        f"line {kept[-1]}: the file ends within its last number, {last}, so that the line is left "
        "out; if the test went on, export it again"
    )


def _decimals(cell: str) -> int:
    return len(cell.replace(",", ".").partition(".")[2])


def _check_line(
    text: _Text, metadata: Sequence[int], number: int, cells: Sequence[str], heading: _Heading
) -> None:
    if metadata:
        line = text.lines[metadata[0] - 1].strip()
        raise InputError(
            f"{text.path}, line {metadata[0]}: {line!r} stands among the numbers; "
            f"{_cure(text, metadata, heading)}"
        )
    if len(cells) > len(heading.titles):
        raise InputError(
            f"{text.path}, line {number}: {len(cells)} cells below {len(heading.titles)} titles; "
            "if these are decimal commas, export with semicolons or decimal points, else give each "
            "column a title"
        )


def _cure(text: _Text, metadata: Sequence[int], heading: _Heading) -> str:
    """What to do about lines that stand among the numbers.

    To delete them alone would join two tables, or numbers of two units.
    """
    line = text.lines[metadata[0] - 1].strip()
    cells = [cell for cell in text.cells(line, heading.delimiter) if cell]
    if re.match(r"[\d\s./-]*\d:\d", line):
        return "write times in seconds, or as hh:mm:ss"
    if cells and all(_quantities_of(cell.strip(AROUND)) for cell in cells):
        return "units stand once, in the line below the titles; export the test in these alone"
    parted = (cell.partition(" ") for cell in cells)
    behind = [rest for number, _, rest in parted if rest and NUMBER.fullmatch(number)]
    if behind:
        return (
            "export without thousands separators"
            if all(map(NUMBER.fullmatch, behind))
            else "export numbers alone, with units in the titles or in the line below them"
        )
    if len(cells) == 1 and any(
        sum(map(bool, map(VALUE.fullmatch, text.cells(line, other)))) > 1 for other in "\t;,"
    ):
        return "export titles and numbers with the same mark between them"
    for number in metadata:
        words = [cell for cell in text.cells(text.lines[number - 1], heading.delimiter) if cell]
        if len(words) > 1 and all(map(_may_be_title, words)):
            return (
                f"if another table begins in line {number}, delete the one that is not the test, "
                "from its titles on; else delete the line"
            )
    return "delete the line, or export the test again"


def _may_be_title(cell: str) -> bool:
    """Whether a cell is neither a number, nor a missing one, nor what stands before a value."""
    return bool(WORD.search(cell)) and cell.lower() not in NO_NUMBERS and not cell.endswith(":")


def _cell(cells: Sequence[str], place: int) -> str:
    return cells[place] if place < len(cells) else ""


def _quantities_of(unit: str) -> list[str]:
    """Quantities that have a unit."""
    return [name for name, units in UNITS.items() if unit in units]


def _with_unit(
    column: Column, row: Sequence[str], given: Mapping[str, str], text: _Text, block: str
) -> Column:
    """The column with its unit, from its title, the line of units or the settings."""
    where = f"{text.path}, column {column.title!r}"
    below = _cell(row, column.place).strip(AROUND)
    known, settled = UNITS[column.quantity], given.get(column.quantity, "")
    told = {"title": column.unit, "below": below, "settings": settled}
    if below in known and not _quantities_of(column.unit):  # then brackets may hold any other word
        told["title"] = ""
    said = dict.fromkeys(filter(None, told.values()))
    setting = records_setting({"units": {column.quantity: next(iter(known))}}, block)
    for unit in said:
        if unit not in known:
            others = _quantities_of(unit)
            cure = (
                f"it is one of {others[0]}, so name the column as that"
                if others
                else "convert the column or, if it is no unit, take it out of the file"
            )
            raise InputError(
                f"{where}: {unit!r} is no known unit of {column.quantity} ({', '.join(known)}); "
                f"{cure}"
            )
    if len({known[unit] for unit in said}) > 1:
        raise InputError(
            f"{where}: {' and '.join(said)} contradict each other (title, line of units, settings "
            "of the study); keep the right one"
        )
    if not said and column.quantity in RATIOS:
        said = {"1": None}
    if not said:
        raise InputError(
            f"{where}: no unit is named; name it in the settings of the study, such as {setting}"
        )
    source = next((name for name, unit in told.items() if unit in said), "settings")
    return Column(column.quantity, column.place, column.title, next(iter(said)), source)


def _decimal_comma(
    rows: Sequence[Sequence[str]], found: Sequence[Column], path: PathLike, delimiter: str
) -> bool:
    """Whether the numbers have decimal commas; what may be thousands separators is refused."""
    columns = [[_cell(row, column.place) for row in rows] for column in found]
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
    marked = commas or points
    for column in columns if all(map(THOUSANDS.fullmatch, marked)) else ():
        whole = next((cell for cell in column if cell.lstrip("+-").isdigit()), None)
        cell = next(filter(THOUSANDS.fullmatch, column), None)
        if whole and cell:
            raise InputError(
                f"{path}: {cell} may be a decimal or have a mark of thousands, as {whole} has no "
                f"{'comma' if commas else 'point'}; export without thousands separators, or all "
                "rows with decimals"
            )
    return bool(commas)


def _numbers(rows: Sequence[Sequence[str]], place: int, factor: float) -> Any:
    """Values (n,) of a column times `factor`; cells that are no number stay text."""
    cells = (_cell(row, place) for row in rows)
    values: list[Any] = [
        factor * float(cell.replace(",", ".")) if NUMBER.fullmatch(cell) else cell for cell in cells
    ]
    if any(isinstance(value, str) for value in values):
        return pd.array([None if value == "" else value for value in values], dtype=object)
    return np.array(values, dtype=np.float64)


def _clock(rows: Sequence[Sequence[str]], found: Sequence[Column]) -> Array | None:
    """Seconds (n,) of a column of times of a clock, which go on after midnight; None of others."""
    places = [column.place for column in found if column.quantity == "time"]
    times = [CLOCK.fullmatch(_cell(row, place)) for place in places for row in rows]
    seconds = [
        3600.0 * int(time[1]) + 60.0 * int(time[2]) + float(time[3].replace(",", "."))
        for time in times
        if time
    ]
    return np.unwrap(seconds, period=DAY) if len(seconds) == len(rows) else None


def _ascending(
    rows: Sequence[Sequence[str]], titles: Sequence[str], names: Sequence[str]
) -> list[str]:
    """Titles of columns whose numbers rise from line to line, as time does."""
    found = []
    for name in names:
        values = _numbers(rows, titles.index(name), 1.0)
        if values.dtype == np.float64 and len(values) > 1 and np.all(np.diff(values) > 0.0):
            found.append(name)
    return found


def _kind(lines: Sequence[str], own: bool) -> str:
    """Which machine, or which kind of table, a file comes from."""
    if own:
        return "softsample table"
    head = "\n".join(lines)
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
