"""One sample of a study that a reader makes: its row of the table and its record."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from softsample.arrays import Array

KPA = 1e-3
"""One kPa [N/mm2]."""


@dataclass(frozen=True)
class Sample:
    """A test on a piece of stated size.

    Parameters
    ----------
    name, group, mode : str
        Cells `sample`, `group` and `mode` of the table of samples.
    shape : mapping
        Cells `shape` and its dimensions [mm].
    record : DataFrame
        Columns of a record's file: `displacement_mm`, `force_N` (tension and shear positive,
        compression negative), optional `time_s` first and `force_normal_N` last.
    specimen : str
        Piece that was tested; `name` if empty.
    cycle : str
        Loading that is calibrated, of a record with several.
    material_z, material_x : str
        Directions of the material along the loading axis and along the shear, if known.
    """

    name: str
    group: str
    mode: str
    shape: Mapping[str, str | float]
    record: pd.DataFrame
    specimen: str = ""
    cycle: str = ""
    material_z: str = ""
    material_x: str = ""

    @property
    def strain(self) -> pd.Series:
        """Nominal strain, or amount of shear, of each row of the record."""
        return self.record["displacement_mm"] / float(self.shape["height_mm"])


def cuboid(length_mm: float, width_mm: float, height_mm: float) -> dict[str, str | float]:
    """Cells of a cuboid of stated edges [mm] along x, y and z."""
    edges = {"length_mm": length_mm, "width_mm": width_mm, "height_mm": height_mm}
    return {"shape": "cuboid", **edges}


def cylinder(diameter_mm: float, height_mm: float) -> dict[str, str | float]:
    """Cells of an upright cylinder of stated diameter and height [mm]."""
    return {"shape": "cylinder", "height_mm": height_mm, "diameter_mm": diameter_mm}


def record(
    displacement_mm: ArrayLike,
    force_N: ArrayLike,
    time_s: ArrayLike | None = None,
    force_normal_N: ArrayLike | None = None,
) -> pd.DataFrame:
    """Columns of a record's file; those that were not measured are absent."""
    columns = {
        "time_s": time_s,
        "displacement_mm": displacement_mm,
        "force_N": force_N,
        "force_normal_N": force_normal_N,
    }
    return pd.DataFrame({name: x for name, x in columns.items() if x is not None})


def outward(along: Array, force: Array, sign: float) -> tuple[Array, Array]:
    """What lies on one side of zero or at it, from zero outward."""
    chosen = np.flatnonzero(sign * along >= 0.0)
    order = chosen[np.argsort(sign * along[chosen])]
    return along[order], force[order]
