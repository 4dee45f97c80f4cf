"""The idealised shape of a sample: a cuboid, or an upright cylinder.

It is measured in an image or in a closed surface (`softsample.imaging.measure`), or stated in the
study table. ``cuboid/{sample}.json`` holds it in either case.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

from softsample.errors import InputError
from softsample.units import MM

STATED = {
    "cuboid": ("length_mm", "width_mm", "height_mm"),
    "cylinder": ("diameter_mm", "diameter_mm", "height_mm"),
}
"""Columns of the study table that hold length, width and height of each kind."""

DIMENSIONS = {kind: tuple(dict.fromkeys(columns)) for kind, columns in STATED.items()}
"""Columns that state the dimensions of each shape."""

ANY_DIMENSION = tuple(dict.fromkeys(name for names in DIMENSIONS.values() for name in names))

BONDED, SLIDING = "bonded", "sliding"

KINDS = tuple(STATED)
"""Shapes that a sample can be idealised as."""


@dataclass(frozen=True)
class IdealShape:
    """A solid with flat, parallel ends on z = 0 and z = height, its axis in the origin.

    Parameters
    ----------
    kind : {"cuboid", "cylinder"}
    length, width, height : float
        Extents along x, y and z [m], all > 0; length and width of a cylinder are its diameter.

    Raises
    ------
    InputError
        If the kind is unknown, a length is no positive number, or the length of a cylinder is not
        its width.
    """

    kind: str
    length: float
    width: float
    height: float

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(f"shape {self.kind!r} is unknown; give one of {', '.join(KINDS)}")
        for name in ("length", "width", "height"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(
                    f"{name} of the {self.kind} is {value / MM:g} mm; give a positive length"
                )
        if self.kind == "cylinder" and self.length != self.width:
            raise InputError(
                f"a cylinder has one diameter, not {self.length / MM:g} and {self.width / MM:g} "
                "mm; give the same twice, or a cuboid"
            )

    @classmethod
    def of_row(cls, row: Mapping[str, str]) -> Self:
        """From the cells of the study table: `shape`, and `length_mm` ... or `diameter_mm`.

        Parameters
        ----------
        row : mapping of str
            Cells as text; empty ones may be absent. Other columns are ignored.

        Raises
        ------
        InputError
            Naming column, value and cure.
        """
        kind = row.get("shape", "")
        if kind not in KINDS:
            raise InputError(f"shape: {kind!r} is not one of {', '.join(KINDS)}")
        needed = STATED[kind]
        for column in sorted({*ANY_DIMENSION} - {*needed}):
            if row.get(column):
                raise InputError(f"{column}: a {kind} has none; leave the cell empty")
        return cls(kind, *(_length(row, column, kind) for column in needed))

    @classmethod
    def of_report(cls, report: Mapping[str, Any]) -> Self:
        """From ``cuboid/{sample}.json``."""
        length, width, height = (report[f"{name}_mm"] for name in ("length", "width", "height"))
        return cls(report["shape"], MM * length, MM * width, MM * height)

    @property
    def area(self) -> float:
        """Area of the section [m2]."""
        return self.length * self.width * (0.25 * math.pi if self.kind == "cylinder" else 1.0)

    @property
    def gyration(self) -> float:
        """Least radius of gyration of the section [m]."""
        if self.kind == "cylinder":
            return self.length / 4.0
        return min(self.length, self.width) / math.sqrt(12.0)

    @property
    def volume(self) -> float:
        """Volume [m3]."""
        return self.area * self.height

    @property
    def smallest(self) -> float:
        """Shortest of length, width and height [m]."""
        return min(self.length, self.width, self.height)

    def grown(self, shift: float) -> Self:
        """The shape with its free faces moved out by `shift` [m], in if negative; the base stays.

        Raises
        ------
        InputError
            If nothing is left of it.
        """
        length, width = self.length + 2.0 * shift, self.width + 2.0 * shift
        return replace(self, length=length, width=width, height=self.height + shift)

    def report(self) -> dict[str, Any]:
        """Keys of ``cuboid/{sample}.json`` about the idealised shape, in mm, mm2 and mm3."""
        lengths = {"length": self.length, "width": self.width, "height": self.height}
        if self.kind == "cylinder":
            lengths["diameter"] = self.length
        return {
            "shape": self.kind,
            **{f"{name}_mm": value / MM for name, value in lengths.items()},
            "ideal_area_mm2": self.area / MM**2,
            "volume_ideal_mm3": self.volume / MM**3,
        }


def _length(row: Mapping[str, str], column: str, kind: str) -> float:
    """A length [m] of a row, or an error that names its column."""
    text = row.get(column, "")
    if not text:
        raise InputError(f"{column}: is missing; a {kind} needs {', '.join(DIMENSIONS[kind])}")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0.0):
        raise InputError(f"{column}: {text!r} is no length; give a positive number of mm")
    return MM * value


def element_size(shape: IdealShape, wanted: float, across: Sequence[float]) -> float:
    """Edge of the elements of a sample [m], the same for its real and its idealised geometry.

    Parameters
    ----------
    wanted : float
        Edge that is taken wherever the bounds allow it [m].
    across : (2,) sequence of float
        Elements along the shortest extent of the shape, at least and at most (config
        `mesh: elements_across`).

    Returns
    -------
    float
        `wanted`; less if too few elements fitted into a small sample, more if there were too many
        in a large one.

    Raises
    ------
    InputError
        If `wanted` is not positive or the bounds do not ascend.
    """
    fewest, most = across
    if not (wanted > 0.0 and 0.0 < fewest <= most):
        raise InputError(
            f"elements of {wanted / MM:g} mm, {fewest:g} to {most:g} across: give a positive size "
            "and ascending numbers"
        )
    return min(max(wanted, shape.smallest / most), shape.smallest / fewest)


INDENTERS = ("sphere", "flat")


@dataclass(frozen=True)
class Indenter:
    """A rigid indenter that comes down along the axis of a sample glued to its base.

    Parameters
    ----------
    kind : {"sphere", "flat"}
        A ball, or an upright cylinder with a flat end.
    radius : float
        Of the ball or of the flat end [m], > 0.
    ends : str or float
        What the sample does on it: `bonded` (no slip), `sliding`, or a coefficient of friction.

    Raises
    ------
    InputError
        If the kind is unknown or the radius is no positive number.
    """

    kind: str
    radius: float
    ends: str | float = BONDED

    @classmethod
    def of_row(cls, row: Mapping[str, str]) -> Self | None:
        """From cells of the study table; none in tests without one."""
        if row.get("mode") != "indentation":
            return None
        ends = row.get("ends", BONDED)
        held: str | float = ends if ends in (BONDED, SLIDING) else float(ends)
        return cls(row["indenter"], MM * float(row["indenter_radius_mm"]), held)

    def __post_init__(self) -> None:
        if self.kind not in INDENTERS:
            raise InputError(f"indenter {self.kind!r} is unknown; give {' or '.join(INDENTERS)}")
        if not (math.isfinite(self.radius) and self.radius > 0.0):
            raise InputError(f"radius of the indenter is {self.radius / MM:g} mm; give one > 0")


ALONG_RADIUS = 16
"""Elements along the radius of an indenter, where it meets the sample."""
