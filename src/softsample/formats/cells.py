"""Lines and cells of a record, from a text or a sheet: which are numbers or times of a clock."""

import csv
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from typing import Self

from softsample.errors import InputError
from softsample.files import PathLike
from softsample.formats.text import read_lines
from softsample.formats.workbook import read_sheets

DELIMITERS = "\t;,"
"""Marks that may stand between cells, the likeliest first."""

NUMBER = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?", re.ASCII)
"""A number with a decimal point or comma; it has no thousands separators."""

CLOCK = re.compile(
    r"(?:(?P<date>\d{4}-\d\d-\d\d|\d\d?[./]\d\d?[./]\d{4})[ T])?"
    r"(?:(?P<hour>\d+):(?P<minute>\d\d)|(?P<minutes>\d+)(?=:\d\d[.,]\d)):"
    r"(?P<second>\d\d(?:[.,]\d*|:\d{3})?)"
    r"(?: ?(?P<half>[AaPp])\.?[Mm]\.?)?(?:Z|[+-]\d\d:?\d\d)?",
    re.ASCII,
)
"""A time of day, or one that elapsed: date, hours, minutes, seconds, and the half of a day; the
zone behind is of no use. Without hours, seconds have decimals: 12:30 may be hours and minutes."""

VALUE = re.compile(f"{NUMBER.pattern}|{CLOCK.pattern}", re.ASCII)
"""Either of them."""

WORD = re.compile(r"[^\W\d_]{2}")
"""Letters as a title has them."""

GROUPED = re.compile(
    r"([+-]?)([1-9]\d{0,2}(?:(?:,\d{3})+(?=\.)|(?:\.\d{3})+(?=,)|(?:['’\xa0\u2009\u202f]\d{3})+))"
    r"([.,]\d*)?",
    re.ASCII,
)
"""A number that has thousands separators for certain: sign, thousands, and decimals behind another
mark."""

MINUS = re.compile("^[\u2212\u2013]")
"""The minus sign of typesetters, and the dash that is taken for one."""

BLANKS = (r"\s{2,}", r"\s+(?![(\[])", r"\s+")
"""What may stand between cells where no mark does; a bracket belongs to the word before it."""

LONGEST_TITLE = 6
"""A title in quotes goes over fewer lines."""

OPENED = re.compile(r'(?:^|[\t;,])\s*"[^"]*$')
"""A line that ends within quotes; a mark of inches opens none."""


@dataclass
class Text:
    """The lines of a file or of a sheet, and what is to be said of them.

    Parameters
    ----------
    path
        What messages call it: the file, of a workbook with the sheet.
    lines
        Without their ends; a title in quotes that goes over lines stands in the first of them.
    notes, doubts
        What was done to read it, and what may be wrong with it, in words; readers add to both.
    sheet
        Name of the sheet; empty for a text.
    """

    path: PathLike
    lines: list[str]
    notes: list[str] = field(default_factory=list)
    sheet: str = ""
    doubts: list[str] = field(default_factory=list)

    @classmethod
    def of_file(cls, path: PathLike) -> Self:
        """Decode a file; an `InputError` refuses what is no text, or not there."""
        try:
            lines, notes = read_lines(path, "export the test as CSV, text or .xlsx")
        except FileNotFoundError as error:
            raise InputError(f"{path}: no such record; correct its path in the table") from error
        spaced = _tabbed(lines)
        if spaced is not lines:
            notes.append("cells are separated by blanks")
        return cls(path, _joined(spaced), notes)

    @classmethod
    def of_sheets(cls, path: PathLike, sheet: str | None) -> Iterator[Self]:
        """Read the sheets of a workbook, or the one that is named; errors as of `read_sheets`."""
        for name, lines in read_sheets(path, sheet):
            yield cls(f"{path} (sheet {name})", lines, sheet=name)

    def shown(self, number: int) -> str:
        """A line as messages show it, by its number from 1 on."""
        return self.lines[number - 1].strip()


def cells_of(line: str, delimiter: str) -> list[str]:
    """Cells of a line without blanks around them and without empty ones at its end.

    Numbers have the usual minus and no thousands separators. A line that is no CSV is one cell.
    """
    try:
        cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    except csv.Error:
        return [line]
    cells = [_plain(cell.strip()) for cell in cells]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def cell_at(cells: Sequence[str], place: int) -> str:
    """The cell at a place from 0 on; empty beyond the end of its line."""
    return cells[place] if place < len(cells) else ""


def is_comment(line: str) -> bool:
    """Whether a line begins with #."""
    return line.lstrip().startswith("#")


def _tabbed(lines: list[str]) -> list[str]:
    """Lines with tabs in place of the blanks, if these alone stand between the numbers of a text.

    Only lines with as many cells as those of numbers are changed, so that none is shifted where a
    cell is empty. Commas are those of decimals, if no other line has some.
    """
    if any(mark in line for line in lines for mark in "\t;"):
        return lines
    cells = [line.split() for line in lines]
    numeric = [
        len(row) > 1 and all(VALUE.fullmatch(cell) and cell[-1] != "," for cell in row)
        for row in cells
    ]
    numbers = Counter(len(row) for row, is_one in zip(cells, numeric, strict=True) if is_one)
    count, often = max(numbers.items(), key=itemgetter(1), default=(0, 0))
    commas = {is_one for line, is_one in zip(lines, numeric, strict=True) if "," in line}
    if often < LONGEST_TITLE or 2 * often < sum(map(bool, cells)) or len(commas) > 1:
        return lines
    ways = [[re.split(mark, line.strip()) for mark in BLANKS] for line in lines]
    return [
        "\t".join(next((cut for cut in cuts if len(cut) == count), [line]))
        for cuts, line in zip(ways, lines, strict=True)
    ]


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
    plain = MINUS.sub("-", cell)
    if grouped := GROUPED.fullmatch(plain):
        sign, thousands, decimals = grouped.groups(default="")
        plain = sign + re.sub(r"\D", "", thousands) + decimals
    return plain if NUMBER.fullmatch(plain) else cell
