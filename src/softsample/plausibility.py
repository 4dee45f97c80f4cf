"""Whether a test can be what its file says: one set of limits, and the unit that would explain it.

Nothing is refused here: what lies outside is doubted, with the cure that is likeliest, and with
the setting that accepts it if it is right.
"""

import math
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Any

from softsample.errors import InputError, as_setting, records_setting
from softsample.files import PathLike
from softsample.formats.titles import COLUMNS, UNITS
from softsample.protocol import NEVER_UNIFORM, PRESSED_MODES
from softsample.records import Sized
from softsample.units import MM
from softsample.wording import significant

USUAL_MM, USUAL_N = 100.0, 100.0
"""Largest displacement and force that raise no doubt if no dimensions are known."""

CRUSHED = 0.99
"""No sample is pressed by more of its height."""

LENGTHS = {"cm": 10.0, "m": 1e3, "inches": 25.4}
"""Units that dimensions may have been written in, and their size in mm."""


@dataclass(frozen=True)
class Limits:
    """What goes without a word: the config section `plausibility`; lower and upper ends.

    Parameters
    ----------
    strain
        Nominal strain at the end of the calibrated loading, displacement over height.
    strain_rate_per_s
        That strain over the time of its ramps [1/s].
    stiffness_pa
        Nominal stress over strain at the peak [Pa].
    sampling_hz
        Samples per second.
    stiffness_ratio, volume_ratio, strain_ratio
        A sample against each of the study's others: stiffness and strain in its mode, and
        volume; either way.
    """

    strain: tuple[float, float]
    strain_rate_per_s: tuple[float, float]
    stiffness_pa: tuple[float, float]
    sampling_hz: tuple[float, float]
    stiffness_ratio: float
    volume_ratio: float
    strain_ratio: float

    def of(self, mode: str) -> "Limits":
        """Those of a mode; where no sample deforms uniformly, its section tells no stress."""
        if mode not in NEVER_UNIFORM:
            return self
        return replace(self, stiffness_pa=(0.0, math.inf), strain=(0.0, self.strain[1]))


WORDS = {
    "strain": ("strain of {} %", 100.0),
    "strain_rate_per_s": ("strain rate of {} per s", 1.0),
    "stiffness_pa": ("stress over strain of {} kPa", 1e-3),
    "sampling_hz": ("{} samples per s", 1.0),
}
"""How each quantity is told, and its size in the unit of these words."""


def figures(facts: Mapping[str, Any], size: Sized | None) -> dict[str, float]:
    """What `Limits` bounds, of a record; without dimensions and time only what needs none.

    Parameters
    ----------
    facts
        Of `softsample.records.aligned_record`.
    size
        Dimensions of the sample, if they are known.
    """
    found = {"sampling_hz": facts["sampling_rate_hz"]}
    if size is not None:
        strain = abs(facts["travel_mm"]) * MM / size.height
        force = abs(facts["peak_force_N"] - (facts["force_offset_N"] or 0.0))
        speed = facts["ramp_speed_mm_s"]
        found["strain"] = strain
        found["strain_rate_per_s"] = None if speed is None else speed * MM / size.height
        found["stiffness_pa"] = force / size.area / strain
    return {name: value for name, value in found.items() if value is not None}


def doubts(
    facts: Mapping[str, Any],
    size: Sized | None,
    limits: Limits,
    dimensions: Mapping[str, str] | None = None,
    block: str = "",
    mode: str = "",
    source: PathLike = "",
) -> Iterator[str]:
    """What may be written in another unit than it is read in.

    Parameters
    ----------
    facts, size
        As of `figures`.
    limits
        What goes without a word.
    dimensions
        Cells of the study table that state dimensions, if there are any.
    block
        Name of the block of `formats` that the record is read by.
    mode, source
        Of the test, and the record's path, for what is refused.

    Yields
    ------
    str
        Value, limits, and cure.

    Raises
    ------
    InputError
        If the sample would be pressed by all of its height.
    """
    values = figures(facts, size)
    crushed = mode in PRESSED_MODES and values.get("strain", 0.0) >= 1.0
    if crushed:
        limits = replace(limits, strain=(0.0, min(limits.strain[1], CRUSHED)))
    outside = _outside(values, limits)
    if outside:
        told = ", ".join(
            words.format(significant(scale * values[name]))
            for name, (words, scale) in WORDS.items()
            if name in outside
        )
        accepted = {name: _widened(getattr(limits, name), values[name]) for name in outside}
        cure = next(_explained(facts, values, limits, dimensions or {}, block), "")
        powers = _powers_of_size(_by_quantity(facts))
        sized = size if any(powers.get(name) for name in outside) else None
        doubt = f"{told}{_of(sized)}: is a unit{' or a dimension' if sized else ''} wrong? {cure}"
        if crushed:
            raise InputError(f"{source}: {doubt}No sample can be pressed by its height")
        yield f"{doubt}If it is right, set {as_setting({'plausibility': accepted})}"
    if size is None:
        yield from _large(facts)
    elif mode in PRESSED_MODES and (end := _end_mm(facts)) >= size.height / MM:
        raise InputError(
            f"{source}: the displacement ends at {end:.4g} mm, and no sample can be pressed by its "
            f"height, {size.height / MM:.4g} mm; if the file's zero is not where the platen "
            "touches, write `records: {zero: {displacement: start}}`"
        )


def _large(facts: Mapping[str, Any]) -> Iterator[str]:
    """What is large for any sample."""
    far = max(abs(facts["travel_mm"]), _end_mm(facts))
    if far > USUAL_MM:
        yield f"displacement of {far:.4g} mm; was it written in another unit?"
    if abs(facts["peak_force_N"]) > USUAL_N:
        yield f"force of {abs(facts['peak_force_N']):.4g} N; was it written in mN or g?"


def _end_mm(facts: Mapping[str, Any]) -> float:
    """Magnitude of the displacement at the end of the loading [mm]."""
    return float(abs(facts["travel_mm"] + facts["ramp_start_mm"]))


def _of(size: Sized | None) -> str:
    if size is None:
        return ""
    return f" at a height of {size.height / MM:.4g} mm and {size.area / MM**2:.4g} mm2"


def _outside(values: Mapping[str, float], limits: Limits) -> list[str]:
    """Quantities beyond their limits, with the digits that are told of them."""
    bounds = {name: getattr(limits, name) for name in values}
    told = {name: float(f"{value:.3g}") for name, value in values.items()}
    return [name for name, (low, high) in bounds.items() if not low <= told[name] <= high]


def _widened(bounds: tuple[float, float], value: float) -> list[float]:
    """Limits that a value is within, with a digit or two."""
    low, high = (float(f"{factor * value:.2g}") for factor in (0.8, 1.25))
    return [min(bounds[0], low), max(bounds[1], high)]


POWERS = {
    "displacement": {"strain": 1, "strain_rate_per_s": 1, "stiffness_pa": -1},
    "force": {"stiffness_pa": 1},
    "time": {"strain_rate_per_s": -1, "sampling_hz": -1},
}
"""Power of each figure in the scale of displacement, force and time."""

STANDS_FOR = {
    "strain": "displacement",
    "stress": "force",
    "angle": "displacement",
    "torque": "force",
}
"""Quantities of a file that scale as others."""


def _by_quantity(facts: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """What was understood of the columns of a file, by quantity."""
    columns = facts["reading"].get("columns", {})
    return {name: columns[title] for name, title in COLUMNS.items() if title in columns}


def _powers_of_size(stated: Container[str]) -> dict[str, int]:
    """Power of each figure in the scale of the dimensions, by the quantities that a file states.

    Strain, stretch and angle are strain at any size, and nominal stress is stress.
    """
    strain = 0 if any(name in stated for name in ("strain", "stretch", "angle")) else -1
    stress = -3 if "angle" in stated else 0 if "stress" in stated else -2
    return {"strain": strain, "strain_rate_per_s": strain, "stiffness_pa": stress - strain}


def _explained(
    facts: Mapping[str, Any],
    values: Mapping[str, float],
    limits: Limits,
    dimensions: Mapping[str, str],
    block: str,
) -> Iterator[str]:
    """Cures with which every figure would be plausible, the likeliest first."""
    by_quantity = _by_quantity(facts)
    all_powers = {**POWERS, "size": _powers_of_size(by_quantity)}

    def fits(what: str, factor: float) -> bool:
        powers = all_powers[what]
        scaled = {name: v * factor ** powers.get(name, 0) for name, v in values.items()}
        return not _outside(scaled, limits)

    for what in ("displacement", "size", "force", "time"):
        if what == "size":
            yield from (
                f"If the dimensions are in {unit}, {_cells(dimensions, factor)}. "
                for unit, factor in LENGTHS.items()
                if dimensions and fits(what, factor)
            )
        for quantity, column in by_quantity.items():
            if STANDS_FOR.get(quantity, quantity) != what or column["unit_from"] == "cells":
                continue
            for factor, unit in _units(quantity).items():
                if factor != column["factor"] and fits(what, factor / column["factor"]):
                    cure = _retitled(quantity, column, unit, block)
                    yield f"If {quantity} is in {unit}, {cure}. "


def _units(quantity: str) -> dict[float, str]:
    """The first name of each unit of a quantity, by its size."""
    found: dict[float, str] = {}
    for name, size in UNITS[quantity].items():
        found.setdefault(size, name)
    return found


def _cells(dimensions: Mapping[str, str], factor: float) -> str:
    """What to write into cells of the study table so that each is larger by a factor."""
    sizes = {
        name: f"{(Decimal(cell) * Decimal(str(factor))).normalize():f}"
        for name, cell in dimensions.items()
    }
    if len(sizes) > 1 and len({*sizes.values()}) == 1:
        return f"write {next(iter(sizes.values()))} into columns {_listed([*sizes])}"
    return f"write {_listed([f'{size} into column {name}' for name, size in sizes.items()])}"


def _listed(words: Sequence[str]) -> str:
    """Words with commas and an "and" between them."""
    *others, last = words
    return f"{', '.join(others)} and {last}" if others else last


def _retitled(quantity: str, column: Mapping[str, Any], unit: str, block: str) -> str:
    """How to say that a column of a file has another unit than it is read in."""
    if column["unit_from"] == "settings":
        return f"set {records_setting({'units': {quantity: unit}}, block)}"
    old = column["title"] if column["unit_from"] == "title" else column["unit"]
    new = unit.join(old.rsplit(column["unit"], 1))
    return f"write {new!r} in place of {old!r} in line {column['unit_line']}"
