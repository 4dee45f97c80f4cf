"""The lines of numbers below the titles of a record, and what stands among and behind them."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from softsample.errors import InputError
from softsample.formats.cells import (
    DELIMITERS,
    NUMBER,
    VALUE,
    WORD,
    Text,
    cell_at,
    cells_of,
    is_comment,
)
from softsample.formats.columns import AROUND, quantities_with
from softsample.formats.heading import Heading

NO_NUMBERS = ("", "nan", "inf", "null", "none")
"""What machines write, in lower case, where they have no number."""

FEWEST = 10
"""Lines before the last one that tell how many decimals it should have."""


@dataclass
class Rows:
    """The lines of numbers.

    Parameters
    ----------
    cells
        Of each line.
    lines
        Their numbers in the file, from 1 on.
    units
        Cells of the line of units; empty if there is none.
    """

    cells: list[list[str]]
    lines: list[int]
    units: list[str]

    def column(self, place: int) -> list[str]:
        """Cells of a column, one a line; empty where a line is shorter."""
        return [cell_at(cells, place) for cells in self.cells]


def rows_of(text: Text, heading: Heading) -> Rows:
    """The lines of numbers; what was passed over or left out goes to the notes and doubts.

    Titles and units may be repeated, with metadata before them, where a machine begins a new
    block of the same test; metadata may also end the file, and a last line in which it was cut off
    is left out.

    Parameters
    ----------
    text
        Of a file or a sheet.
    heading
        Its line of titles.

    Raises
    ------
    InputError
        If there are no numbers, other lines among them, or more cells than titles; names file,
        line and cure.
    """
    rows = Rows([], [], [])
    metadata: list[int] = []
    blocks: list[int] = []
    titles = heading.titles
    for number, cells in _below(text, heading):
        valued = heading.valued(cells)
        begun = rows.cells or rows.units
        if not begun and not any(valued) and {*map(str.lower, cells)} != {"nan"}:
            rows.units = cells
        elif cells in (titles, rows.units):
            if cells == titles:
                blocks.append((metadata or [number])[0])
            metadata = []
        elif not valued[0]:
            metadata.append(number)
        elif metadata:
            raise _among_numbers(text, metadata, heading)
        elif len(cells) > len(titles):
            raise InputError(
                f"{text.path}, line {number}: {len(cells)} cells below {len(titles)} titles; if "
                "these are decimal commas, export with semicolons or decimal points, else give "
                "each column a title"
            )
        else:
            rows.cells.append(cells)
            rows.lines.append(number)
    _leave_end(text, heading, metadata, bool(rows.cells))
    if not rows.cells:
        raise InputError(f"{text.path}: no numbers below the titles; export the whole test")
    _tell_blocks(text, heading, blocks)
    _leave_cut(text, heading, rows)
    return rows


def _below(text: Text, heading: Heading) -> Iterator[tuple[int, list[str]]]:
    """Number and cells of each line below the titles, without empty ones and comments.

    A line of numbers whose first cell is such as #N/A is no comment.
    """
    comments = 0
    for number, line in enumerate(text.lines[heading.line + 1 :], start=heading.line + 2):
        cells = heading.cells(line)
        numbered = any(heading.valued(cells)) and not VALUE.fullmatch(cells[0].lstrip("# "))
        if is_comment(line) and not numbered:
            comments += 1
        elif any(cells):
            yield number, cells
    if comments:
        text.notes.append(f"lines left out that begin with #: {comments}")


def _tell_blocks(text: Text, heading: Heading, blocks: Sequence[int]) -> None:
    """Say that titles are repeated, and from which lines on; doubt it where no time goes on."""
    if blocks:
        text.notes.append(f"repetitions of the titles: {len(blocks)}; all blocks are read")
    if blocks and not heading.timed:
        text.doubts.append(
            f"line {blocks[0]}: {text.shown(blocks[0])!r} begins another block, which is read as a "
            "part of the same test; if of another specimen, give each its own file"
        )


def _leave_end(text: Text, heading: Heading, metadata: Sequence[int], numbers: bool) -> None:
    """Leave out the lines after the last row of numbers if they are metadata, and say so."""
    faulty = [line for line in metadata if not numbers or _is_row(text.lines[line - 1], heading)]
    if faulty:
        raise _among_numbers(text, faulty, heading)
    if metadata:
        first = metadata[0]
        text.notes.append(
            f"metadata below the numbers, from line {first} on: {text.shown(first)!r}"
        )


def _is_row(line: str, heading: Heading) -> bool:
    """Whether a line without a number in its first column is meant as one of numbers.

    It holds nothing but numbers and what stands for missing ones, or more than one number of
    those that are looked for: a line of metadata has a title before a value.
    """
    cells = heading.cells(line)
    numeric = all(VALUE.fullmatch(cell) or cell.lower() in NO_NUMBERS for cell in cells)
    return numeric or sum(heading.valued(cells)) > 1


def _leave_cut(text: Text, heading: Heading, rows: Rows) -> None:
    """Leave out a last line whose last number the end of the file cuts off, and doubt it.

    A cut line has no end, and its last cell fewer decimals than all others of the column, which
    have one number of them.
    """
    place = max(column.place for column in heading.columns)
    *before, last = rows.column(place)
    decimals = {_decimals(cell) for cell in before}
    of_last_line = rows.lines[-1] == len(text.lines) and text.lines[-1].endswith(last)
    if text.sheet or not of_last_line or len(rows.cells[-1]) != place + 1 or len(before) < FEWEST:
        return
    if len(decimals) > 1 or _decimals(last) >= max(decimals) or not NUMBER.fullmatch(last):
        return
    text.doubts.append(
        f"line {rows.lines[-1]}: the file ends within its last number, {last}, so that the line is "
        "left out; if the test went on, export it again"
    )
    rows.cells.pop()
    rows.lines.pop()


def _decimals(cell: str) -> int:
    return len(cell.replace(",", ".").partition(".")[2])


def _among_numbers(text: Text, lines: Sequence[int], heading: Heading) -> InputError:
    """What refuses lines that stand among the numbers, by their numbers in the file."""
    return InputError(
        f"{text.path}, line {lines[0]}: {text.shown(lines[0])!r} stands among the numbers; "
        f"{_cure(text, lines, heading)}"
    )


def _cure(text: Text, lines: Sequence[int], heading: Heading) -> str:
    """What to do about lines that stand among the numbers.

    To delete them alone would join two tables, or numbers of two units.
    """
    line = text.shown(lines[0])
    cells = [cell for cell in heading.cells(line) if cell]
    if re.match(r"[\d\s./-]*\d:\d", line):
        return "write times in seconds, or as hh:mm:ss"
    if cells and all(quantities_with(cell.strip(AROUND)) for cell in cells):
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
        sum(map(bool, map(VALUE.fullmatch, cells_of(line, other)))) > 1 for other in DELIMITERS
    ):
        return "export titles and numbers with the same mark between them"
    for number in lines:
        words = [cell for cell in heading.cells(text.lines[number - 1]) if cell]
        if len(words) > 1 and all(map(_may_be_title, words)):
            return (
                f"if another table begins in line {number}, delete the one that is not the test, "
                "from its titles on; else delete the line"
            )
    return "delete the line, or export the test again"


def _may_be_title(cell: str) -> bool:
    """Whether a cell is neither a number, nor a missing one, nor what stands before a value."""
    return bool(WORD.search(cell)) and cell.lower() not in NO_NUMBERS and not cell.endswith(":")
