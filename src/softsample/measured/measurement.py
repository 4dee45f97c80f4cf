"""One test of others, in SI units, with the shape that they state."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsample.records import MM, Record

Array = NDArray[np.float64]

GRAM_FORCE = 9.80665e-3
"""One gram-force [N]."""


@dataclass(frozen=True)
class Shape:
    """Ideal cylinder or cuboid, upright.

    Parameters
    ----------
    kind : str
        `cylinder` or `cuboid`.
    length, width, height : float
        Along x, y and z [m]; both of the first are the diameter of a cylinder.
    """

    kind: str
    length: float
    width: float
    height: float

    @property
    def area(self) -> float:
        """Of the section [m2]."""
        share = 0.25 * np.pi if self.kind == "cylinder" else 1.0
        return float(share * self.length * self.width)


@dataclass(frozen=True)
class Measurement:
    """A test of others.

    Parameters
    ----------
    name : str
        Of the record.
    group, specimen : str
        Material that it belongs to, and piece of it.
    mode : str
        `tension`, `compression` or `shear`.
    shape : Shape
        Ideal shape of the stated dimensions.
    record : Record
        Signs as everywhere: force of the platen on the sample, tension positive.
    timed : bool
        Whether time was recorded; if not, the record counts its samples.
    """

    name: str
    group: str
    specimen: str
    mode: str
    shape: Shape
    record: Record
    timed: bool = True

    @property
    def strain(self) -> Array:
        """Travel over height (n,): nominal strain, or amount of shear."""
        return self.record.displacement / self.shape.height

    @property
    def table(self) -> pd.DataFrame:
        """Columns and units of a record's file."""
        return self.record.table


def untimed(displacement: Array, force: Array, force_normal: Array | None = None) -> Record:
    """Record without time [m, N]: a sample a second."""
    return Record(np.arange(len(displacement), dtype=float), displacement, force, force_normal)


def cuboid(length_mm: float, width_mm: float, height_mm: float) -> Shape:
    """Cuboid of stated edges [mm]."""
    return Shape("cuboid", MM * length_mm, MM * width_mm, MM * height_mm)


def cylinder(diameter_mm: float, height_mm: float) -> Shape:
    """Cylinder of stated diameter and height [mm]."""
    return Shape("cylinder", MM * diameter_mm, MM * diameter_mm, MM * height_mm)
