"""The line of titles of a record, or what to do about a file that has none."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NoReturn

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
from softsample.formats.columns import (
    AROUND,
    NEEDED,
    RATIOS,
    Asked,
    Column,
    candidates,
    is_true,
    of_quantities,
    only,
    split_title,
    words_of,
)
from softsample.formats.text import NOT_UTF8
from softsample.formats.titles import COLUMNS, NAMES, UNITS

LOOKED_AT = 10
"""Lines below the titles that tell whether a column holds numbers."""

TOLD = 20
"""Titles that a message names at most."""

HEAD = 1000
"""Lines of which the likeliest one to be that of titles is told, if none is."""


@dataclass(frozen=True)
class Heading:
    """The line of titles: its number from 0 on, delimiter, titles, columns of the quantities."""

    line: int
    delimiter: str
    titles: list[str]
    columns: list[Column]

    @property
    def timed(self) -> bool:
        """Whether one of the columns is time."""
        return any(column.quantity == "time" for column in self.columns)

    def cells(self, line: str) -> list[str]:
        """Cells of a line below."""
        return cells_of(line, self.delimiter)

    def valued(self, cells: Sequence[str]) -> list[bool]:
        """Whether each column has a number or a time of a clock, by the cells of a line."""
        return [bool(VALUE.fullmatch(cell_at(cells, column.place))) for column in self.columns]


def heading_of(text: Text, asked: Asked) -> Heading:
    """The first line with titles of all quantities, or else of all but time.

    Parameters
    ----------
    text
        Of a file or a sheet.
    asked
        The settings, which may name titles.

    Raises
    ------
    InputError
        If no line has titles of all that is needed, or one has several for a quantity or units in
        cells of their own; names the likeliest line and the cure.
    """
    untimed: Heading | None = None
    best: tuple[int, list[str], list[str]] = (0, [], [*COLUMNS])
    score = (len(COLUMNS), 0)
    for number, line in enumerate(text.lines):
        if is_comment(line) or (untimed and not WORD.search(line)):
            continue
        for delimiter in DELIMITERS:
            titles = cells_of(line, delimiter)
            if len(titles) < len(asked.form):
                continue
            found = of_quantities(titles, asked)
            needed = dict.fromkeys((*asked.form, *asked.columns))
            missing = [name for name in needed if not found.get(name, True)]
            if missing:
                if untimed is None and not all(VALUE.fullmatch(title) for title in titles):
                    below = _units_below(text, number, titles) if number < HEAD else ()
                    of_line = (len(missing), -len(below))
                    if of_line < score:
                        score, best = of_line, (number, titles, missing)
                continue
            columns = _columns(titles, found, f"{text.path}, line {number + 1}", asked)
            heading = Heading(number, delimiter, titles, columns)
            if heading.timed:
                return heading
            untimed = untimed or heading
    if untimed is None:
        _no_titles(text, *best, asked)
    return untimed


def _columns(
    titles: Sequence[str], found: Mapping[str, list[Column]], where: str, asked: Asked
) -> list[Column]:
    """The only column of each quantity that is there; units may not stand in cells behind."""
    columns = [only(some, where, asked) for some in found.values() if some]
    if all(cell_at(titles, one.place + 1) in UNITS[one.quantity] for one in columns):
        raise InputError(
            f"{where}: units stand in cells of their own ({', '.join(titles)}), so that titles are "
            "not above their numbers; write units in brackets"
        )
    return columns


def _no_titles(
    text: Text, number: int, titles: Sequence[str], missing: Sequence[str], asked: Asked
) -> NoReturn:
    """Refuse a text without a line of titles; `missing` quantities lack in the best line."""
    if not titles:
        _nothing_like_titles(text)
    where = f"{text.path}, line {number + 1}"
    more = f" and {len(titles) - TOLD} more" if len(titles) > TOLD else ""
    there = f"there are {', '.join(map(repr, titles[:TOLD]))}{more}"
    wanted = asked.columns
    absent = [wanted[way] for name in missing for way in asked.ways(name) if way in wanted]
    if absent:
        section = f"formats: {asked.block}" if asked.block else "records"
        raise InputError(
            f"{where}: no column is called {' or '.join(map(repr, absent))} ({there}); correct "
            f"`columns` in section {section} of the settings"
        )
    ways = [_ways_told(asked.ways(name)) for name in missing]
    cure = _cure(titles, _units_below(text, number, titles), missing, asked)
    cure += f"; the file is {NOT_UTF8}" if NOT_UTF8 in text.notes else ""
    raise InputError(f"{where}: no column is known to hold {', nor '.join(ways)} ({there}); {cure}")


def _nothing_like_titles(text: Text) -> NoReturn:
    """Refuse a text that is empty, has numbers alone, or its titles in a comment."""
    if not any(line.strip() for line in text.lines):
        raise InputError(f"{text.path}: the file is empty; export the test again")
    comments = [line.strip() for line in text.lines if is_comment(line)]
    titled = (
        line
        for line in comments
        for delimiter in DELIMITERS
        if len(titles := cells_of(line.lstrip("# "), delimiter)) > 1
        and any(candidates(name, titles) for name in NAMES)
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


def _cure(
    titles: Sequence[str], below: Mapping[str, str], missing: Sequence[str], asked: Asked
) -> str:
    """What to do about quantities that no title is known to name."""
    plausible = (_plausible(titles, below, asked.ways(name)) for name in missing)
    named = dict(filter(None, plausible))
    if len(named) == len(missing) == len({*named.values()}):
        silent = {
            name: next(iter(UNITS[name]))
            for name, title in named.items()
            if not below[title] and not split_title(title, name)[1] and name not in RATIOS
        }
        it, its = ("it", "its") if len(named) == 1 else ("these", "their")
        return (
            f"if {' and '.join(map(repr, named.values()))} may be {it}, name {it}"
            f"{f' and {its} unit' if silent else ''} in the settings of the study: "
            f"{asked.setting(columns=named, **({'units': silent} if silent else {}))}"
        )
    if asked.form is NEEDED and (true := [title for title in below if is_true(title)]):
        return (
            f"nominal stress and strain are needed, and {' and '.join(map(repr, true))} "
            f"{'are' if len(true) > 1 else 'is'} of the deformed sample; export force and "
            "displacement, or convert: stretch = exp(true strain), nominal stress = true stress / "
            "stretch (of an incompressible sample)"
        )
    example = asked.setting(columns={asked.ways(name)[0]: "its title" for name in missing})
    return f"export the test with titles of these, or name them in the settings, such as {example}"


def _units_below(text: Text, number: int, titles: Sequence[str]) -> dict[str, str]:
    """Titles with numbers below them, and what stands between in a line of units, if there is one.

    It is empty where numbers begin at once.
    """
    line = text.lines[number]
    delimiter = next((mark for mark in DELIMITERS if len(cells_of(line, mark)) > 1), ",")
    rows = [cells_of(row, delimiter) for row in text.lines[number + 1 : number + 1 + LOOKED_AT]]
    found = {}
    for place, title in enumerate(titles):
        cells = [cell_at(row, place) for row in rows if any(row)]
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
        return split_title(title, way)[1] or below[title]

    def is_another(title: str, name: str) -> bool:
        return bool(candidates(name, [title])) and unit(title, name) in ("", *UNITS[name])

    free = [
        title
        for title in titles
        if title in below
        and not is_true(title)
        and not any(is_another(title, name) for name in NAMES)
    ]
    units = {unit for way in ways for unit in UNITS[way]}
    fitting = [title for title in free if any(unit(title, way) in units for way in ways)]
    silent = [title for title in free if not any(unit(title, name) for name in COLUMNS)]
    likely = fitting or silent
    if len(likely) != 1:
        return None
    (title,) = likely
    words = words_of(title)

    def fits(way: str) -> tuple[bool, bool]:
        return unit(title, way) in UNITS[way], bool(words & NAMES.get(way, set()))

    return max(ways, key=fits), title
