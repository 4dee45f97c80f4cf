"""What of a study no model is fitted to: rules on rows and on parts of records.

No rule reads a force, so that what is held out cannot be chosen by what it would show.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any, Self

import numpy as np

from softsample.arrays import Mask
from softsample.errors import InputError
from softsample.records import Record
from softsample.validation import resolved

Row = Mapping[str, str]

OF_ROWS = ("mode", "group", "specimen", "sample")
"""Keys of a selection that whole rows of the table have."""

PHASES = {"loading": ("baseline", "ramp"), "hold": ("hold",), "unloading": ("unloading",)}
"""Phases of a record by the names that selections use."""

CHANNELS = ("force", "force_normal", "torque")
"""Forces of a record by the names that selections use."""

SIDES = {"positive": 1.0, "negative": -1.0}
"""Sign of the displacement by the names that selections use."""


FEWEST_OTHERS = 3
"""Other groups from which one is predicted: each of them in its turn from two at least."""


@dataclass(frozen=True)
class Selection:
    """What fits all of its keys; empty ones fit everything. Mirrors an item of `hold_out`.

    Parameters
    ----------
    mode, group, specimen, sample : tuple of str
        Values of the row of the table; in a name `*` stands for any letters, `[2-5]` for one of
        these.
    channel : tuple of str
        `force`, `force_normal`, `torque`.
    phase : tuple of str
        Keys of `PHASES`.
    cycle : tuple of int
        Numbers of loadings, from 1 on.
    direction : tuple of str
        Keys of `SIDES`: to which side of its zero the displacement is.
    strain_above : float, optional
        Nominal strain, displacement over height to either side, that is exceeded.
    """

    mode: tuple[str, ...] = ()
    group: tuple[str, ...] = ()
    specimen: tuple[str, ...] = ()
    sample: tuple[str, ...] = ()
    channel: tuple[str, ...] = ()
    phase: tuple[str, ...] = ()
    cycle: tuple[int, ...] = ()
    direction: tuple[str, ...] = ()
    strain_above: float | None = None

    @classmethod
    def of(cls, settings: Mapping[str, Any]) -> Self:
        """Selection of an item of `hold_out`, whose values are single ones or lists."""
        lists = {
            name: tuple(value) if isinstance(value, list) else (value,)
            for name, value in settings.items()
            if name != "strain_above"
        }
        return cls(**lists, strain_above=settings.get("strain_above"))

    @property
    def of_samples(self) -> bool:
        """Whether samples are selected as a whole, and no parts of their records."""
        parts = self.channel or self.phase or self.cycle or self.direction
        return not (parts or self.strain_above is not None)

    def fits(self, row: Row) -> bool:
        """Whether it selects a sample of the table, or a part of its record."""
        cells = resolved(row)
        return all(
            any(fnmatchcase(cells.get(name, ""), value) for value in getattr(self, name) or ("*",))
            for name in OF_ROWS
        )

    def mask(self, record: Record, row: Row, height: float, channel: str) -> Mask:
        """Samples (n,) of a channel of a record that it selects, as `held_out`."""
        selected = np.full(len(record.displacement), self.fits(row))
        if self.channel:
            selected &= channel in self.channel
        if self.phase:
            selected &= np.isin(record.phase, [p for name in self.phase for p in PHASES[name]])
        if self.cycle:
            selected &= np.isin(record.cycle, self.cycle)
        if self.direction:
            selected &= np.isin(np.sign(record.displacement), [SIDES[x] for x in self.direction])
        if self.strain_above is not None:
            selected &= np.abs(record.displacement) > self.strain_above * height
        return selected


def held_out(
    record: Record, row: Row, height: float, channel: str, selections: Sequence[Mapping[str, Any]]
) -> Mask:
    """Samples of a channel of a record that are held out: what one of the selections selects.

    Parameters
    ----------
    record : Record
        With phases and cycles (`Record.marked`).
    row : mapping of str
        Of the sample, in the table.
    height : float
        Of the undeformed sample [m].
    channel : str
        `force`, `force_normal` or `torque`.
    selections : sequence of mapping
        Section `hold_out` of the configuration.

    Returns
    -------
    (n,) bool
    """
    masks = [Selection.of(item).mask(record, row, height, channel) for item in selections]
    return np.any([np.zeros(len(record.displacement), dtype=bool), *masks], axis=0)


def selecting(
    record: Record, row: Row, height: float | None, selections: Sequence[Mapping[str, Any]]
) -> set[int]:
    """Numbers of the selections that select some of a record; all of strains if there is no height.

    Parameters
    ----------
    record, row, selections
        As of `held_out`.
    height : float or None
        Of the undeformed sample [m]; None if it is not known.
    """
    there = [name for name in CHANNELS if getattr(record, name) is not None]
    return {
        number
        for number, selection in enumerate(map(Selection.of, selections))
        if any(selection.mask(record, row, height or 0.0, channel).any() for channel in there)
    }


def wholly_held_out(row: Row, selections: Sequence[Mapping[str, Any]]) -> bool:
    """Whether a sample is held out as a whole."""
    every = map(Selection.of, selections)
    return any(selection.of_samples and selection.fits(row) for selection in every)


def check_hold_out(rows: Sequence[Row], selections: Sequence[Mapping[str, Any]]) -> None:
    """Refuse a selection that fits no row of the table, and a group that is all held out.

    Raises
    ------
    InputError
        Naming the selection and what there is.
    """
    for number, selection in enumerate(map(Selection.of, selections)):
        if not any(selection.fits(row) for row in rows):
            raise InputError(f"hold_out.{number}: no sample fits it; {_there(selection, rows)}")
    left = {row["group"] for row in rows if not wholly_held_out(row, selections)}
    for row in rows:
        if row["group"] not in left:
            raise InputError(
                f"hold_out: all samples of group {row['group']!r} are held out, so that it has no "
                "model that could predict them; leave some in"
            )


def _there(selection: Selection, rows: Sequence[Row]) -> str:
    """Values in the table of the keys that a selection uses."""
    used = [name for name in OF_ROWS if getattr(selection, name)]
    values = {name: dict.fromkeys(resolved(row)[name] for row in rows) for name in used}
    listed = [f"{name}: {', '.join(names)}" for name, names in values.items()]
    return f"there are {'; '.join(listed)}"


def in_turn(
    selections: Sequence[Mapping[str, Any]], leave_out: str | None, groups: Collection[str]
) -> bool:
    """Whether what a study holds out is held out of one group at a time.

    So it is with `hold_out` and `leave_out: group`, and more than `FEWEST_OTHERS` groups.
    """
    return bool(selections) and leave_out == "group" and len(groups) > FEWEST_OTHERS


def folds(rows: Sequence[Row], leave_out: str | None) -> list[tuple[str, list[str]]]:
    """What is left out in turn and predicted from the others.

    Parameters
    ----------
    rows : sequence of mapping
        Of the table: those of one group, or of the study if groups are left out.
    leave_out : str or None
        `group`, `specimen`, `mode` or `sample`.

    Returns
    -------
    list of (str, list of str)
        Each value and the samples that have it, in the order of the table; none if there are
        fewer than two values, so that nothing would be left to fit.
    """
    samples: dict[str, list[str]] = {}
    for row in rows if leave_out else ():
        samples.setdefault(resolved(row)[str(leave_out)], []).append(row["sample"])
    return list(samples.items()) if len(samples) > 1 else []


def hold_out_text(
    hold_out: Sequence[Mapping[str, Any]], leave_out: str | None, pooled: bool = False
) -> str:
    """What a study holds out, in words; empty if nothing. `pooled`: of one group at a time."""
    parts = [
        " and ".join(f"{key.replace('_', ' ')} {_told(value)}" for key, value in part.items())
        for part in hold_out
    ]
    if pooled:
        return f"held out of one group at a time: {'; '.join(parts)}"
    held = [f"held out: {'; '.join(parts)}"] if parts else []
    return "; ".join([*held, *([f"each {leave_out} left out in turn"] if leave_out else [])])


def _told(value: Any) -> str:
    """A value of a selection, or the values of which it takes any."""
    return " or ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)
