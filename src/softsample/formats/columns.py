"""Columns of a record by their titles: which quantity each may hold, and in which unit."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from softsample.errors import InputError, records_setting
from softsample.files import PathLike
from softsample.formats.titles import (
    BESIDE,
    COLUMNS,
    COMPRESSIVE,
    NAMES,
    NUMBERED,
    SHEARED,
    TRUE,
    UNITS,
)

Form = Mapping[str, Sequence[str]]

NEEDED: Form = {"displacement": ("displacement", "strain", "stretch"), "force": ("force", "stress")}
"""What every record holds, and the quantities that may stand for it, the first one first."""

TURNED: Form = {"displacement": ("angle",), "force": ("torque",)}
"""What stands for these where the sample is turned."""

ON_REQUEST = ("force_normal", "torque")
"""Quantities that are read where the settings name their column, and from our own tables."""

RATIOS = ("strain", "stretch")
"""Quantities that need no unit."""

AROUND = "()[]{}<>（）［］ "
"""What may stand around a unit."""

BRACKETED = re.compile(r"(.*?)[\s_]*[(\[{<（［]([^()\[\]{}<>（）［］]*)[)\]}>）］]")
"""A title, and its unit in brackets."""

BRACKETS = re.compile(r"[\s_]*[(\[{<（［]([^()\[\]{}<>（）［］]*)[)\]}>）］]")
"""What each bracket of a title holds."""

FACTOR = re.compile(
    r"(?<![\d.])(?:10\s*(?:\^|\*\*)\s*[-−+]?\d+|10[⁺⁻]?[⁰¹²³⁴-⁹]+|1[eE][-+]?\d+|0[.,]0*1(?!\d|\s*\w+/))"
    r"|[x×·*]\s*10[-−]\d+|(?<!\w)[x×·*]\s*10+(?![\d⁺⁻⁰¹²³⁴-⁹]|\s*(?:\^|\*\*))"
    r"|(?<!\d)1?\s*/\s*10+(?!\d)"
)
"""A power of ten in a title that numbers are to be multiplied with, or were."""

BEHIND = re.compile(r"(.+?)(?:\s*[_/,]\s*|\s+in\s+|\s+)([^\s_/,]+)_?")
"""A title, and its last word, which may be its unit; programs write `_` for a bracket."""

WORDS = re.compile(r"[^\s_.:]+")
"""Each word of a title."""


@dataclass(frozen=True)
class Asked:
    """What the settings of a study say of its records.

    Parameters
    ----------
    columns, units
        Titles and units by quantity, where the file leaves them open.
    block
        Name of the block of `formats` that they come from; empty for the section `records`.
    form
        What a record needs.
    axial
        Whether the test is along the axis, so that no column along the platen is its own.
    """

    columns: Mapping[str, str]
    units: Mapping[str, str]
    block: str
    form: Form
    axial: bool = False

    def ways(self, quantity: str) -> Sequence[str]:
        """The quantities that may stand for one, the first one first."""
        return self.form.get(quantity, (quantity,))

    def setting(self, **keys: Any) -> str:
        """Settings of such records, as a line to paste into study.yaml."""
        return records_setting(keys, self.block)


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
        return COMPRESSIVE.search(self.title) is not None

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


def of_quantities(titles: Sequence[str], asked: Asked) -> dict[str, list[Column]]:
    """Columns that may hold each quantity, by quantity; of what may stand for one, the first."""
    wanted, form = asked.columns, asked.form
    free = ["" if asked.axial and SHEARED.search(title) else title for title in titles]
    found = {"time": candidates("time", titles, wanted.get("time"))}
    for needed, ways in form.items():
        named = [way for way in ways if way in wanted] or ways
        columns = (
            candidates(way, titles if way in wanted else free, wanted.get(way)) for way in named
        )
        found[needed] = next(filter(None, columns), [])
    for name in ON_REQUEST:
        if name not in form["force"] and (name in wanted or COLUMNS[name] in titles):
            found[name] = candidates(name, titles, wanted.get(name))
    return found


def candidates(quantity: str, titles: Sequence[str], called: str | None = None) -> list[Column]:
    """Columns that may hold a quantity; those with one of its units, if there are any.

    Parameters
    ----------
    quantity
        Key of `COLUMNS`.
    titles
        Cells of the line of titles.
    called
        Its title by the settings, with or without a unit; else our own title goes before others.
    """
    split = [(place, title, *split_title(title, quantity)) for place, title in enumerate(titles)]
    if called is None and COLUMNS[quantity] in titles:
        called = COLUMNS[quantity]
    if called is not None:
        named = [one for one in split if one[1] == called] or [
            one for one in split if one[2] == called
        ]
        return [Column(quantity, place, title, unit) for place, title, _, unit in named]
    found = []
    for place, title, name, unit in split:
        words = unnumbered(name)
        if words and (words - BESIDE or words) <= NAMES[quantity]:
            found.append(Column(quantity, place, title, unit))
    fitting = [column for column in found if column.unit in UNITS[quantity]]
    silent = [column for column in found if not column.unit]
    return fitting or silent or found


def only(columns: Sequence[Column], where: str, asked: Asked) -> Column:
    """The only candidate for a quantity; an `InputError` names them all if there are more.

    `where` is file and line, for the message.
    """
    if len(columns) == 1:
        return columns[0]
    quantity = columns[0].quantity
    titles = [column.title for column in columns]
    if titles.count(titles[0]) > 1:
        cure = "delete the columns of other tests, or give each its own title"
    else:
        name = asked.setting(columns={quantity: titles[0]})
        cure = f"name the right one in the settings of the study, such as {name}"
        if len({frozenset(unnumbered(title)) for title in titles}) < len(titles):
            cure += ", or in a block of `formats` for each row if they are of several specimens"
    raise InputError(
        f"{where}: {len(columns)} columns may hold {quantity} "
        f"({', '.join(map(repr, titles))}); {cure}"
    )


def with_unit(column: Column, below: str, path: PathLike, asked: Asked) -> Column:
    """The column with its unit, from its title, the line of units or the settings.

    Parameters
    ----------
    column
        As its title tells.
    below
        Its cell in the line of units; empty if there is none.
    path
        What messages call the file.
    asked
        The settings.

    Raises
    ------
    InputError
        If no unit is named, it is none of the quantity, or two of them differ in size.
    """
    where = f"{path}, column {column.title!r}"
    if factor := FACTOR.search(column.title):
        raise InputError(
            f"{where}: a factor in a title ({factor[0].strip()}) is not read; convert the column, "
            "and take it out of the title"
        )
    below, known = below.strip(AROUND), UNITS[column.quantity]
    told = {"title": column.unit, "below": below, "settings": asked.units.get(column.quantity, "")}
    if below in known and not quantities_with(column.unit):  # then brackets hold any other word
        told["title"] = ""
    said = [*dict.fromkeys(filter(None, told.values()))]
    for unit in said:
        if unit not in known:
            cure = _cure_of_unit(unit, column, asked)
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
        said = ["1"]
    if not said:
        setting = asked.setting(units={column.quantity: next(iter(known))})
        raise InputError(
            f"{where}: no unit is named; name it in the settings of the study, such as {setting}"
        )
    source = next((name for name, unit in told.items() if unit in said), "settings")
    return replace(column, unit=said[0], unit_from=source)


def _cure_of_unit(unit: str, column: Column, asked: Asked) -> str:
    """What to do about a unit that is none of the quantity."""
    alike = [known for known in UNITS[column.quantity] if known.lower() == unit.lower()]
    if alike:
        return f"if it is {alike[0]}, write that in its place"
    others = quantities_with(unit)
    if others and column.quantity != "time":
        return (
            f"it is one of {others[0]}, so name the column as that: "
            f"{asked.setting(columns={others[0]: column.title})}"
        )
    return "write one of these, convert the column or, if it is no unit, take it out of the file"


def split_title(title: str, quantity: str) -> tuple[str, str]:
    """Name and unit of a title: `Load (N)`, `Load [N]`, `Load, N`, `Load_N`, `Weg in mm`.

    Of several brackets the last holds the unit, if those before name a channel or a quantity.
    """
    *inside, last = (word.strip() for word in ("", *BRACKETS.findall(title)))
    if len(inside) > 1 and unnumbered(" ".join(inside)) <= BESIDE.union(*NAMES.values()):
        return BRACKETS.sub("", title), last
    if bracketed := BRACKETED.fullmatch(title):
        return bracketed[1], bracketed[2].strip()
    behind = BEHIND.fullmatch(title)
    if behind and behind[2] in UNITS[quantity]:
        return behind[1], behind[2]
    return title, ""


def words_of(title: str) -> set[str]:
    """Words of a title in lower case."""
    return {*WORDS.findall(title.lower())}


def unnumbered(title: str) -> set[str]:
    """Words of a title without numbers of specimens or channels."""
    return {word for word in words_of(title) if not NUMBERED.fullmatch(word)}


def is_true(title: str) -> bool:
    """Whether a title says that it is of the deformed sample, while nominal ones are needed."""
    return not TRUE.isdisjoint(re.findall(r"[^\W_]+", title.lower()))


def quantities_with(unit: str) -> list[str]:
    """Quantities that have a unit."""
    return [name for name, units in UNITS.items() if unit in units]
