"""Loading of one test as a curve: what a calibration follows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import pandas as pd

from softsample.arrays import Array, Mask
from softsample.errors import CalibrationError
from softsample.holdout import held_out
from softsample.protocol import travel_sign
from softsample.records import Record


@dataclass(frozen=True)
class MeasuredCurve:
    """The loading of a record that is calibrated, along its direction.

    Parameters
    ----------
    displacement : (n,) float64
        Displacement of the platen [m].
    force : (n,) float64
        Force of the platen on the sample along the displacement [N]; positive when it resists.
    """

    displacement: Array
    force: Array

    def area_between(self, force: Array) -> float:
        """Absolute area [J] between this curve and `force` (n,) at the same displacements.

        Exact for the two polygons, also where they cross between points. Without that the
        objective would have a kink wherever a point changes sides.
        """
        # ASSUME: areas of several samples are added as they are; the paper names no weights.
        order = np.argsort(self.displacement, kind="stable")
        gap = (self.force - force)[order]
        before, after = np.abs(gap[:-1]), np.abs(gap[1:])
        height = 0.5 * (before + after)
        crossed = gap[:-1] * gap[1:] < 0.0
        height[crossed] -= (before * after)[crossed] / (before + after)[crossed]
        return float(height @ np.diff(self.displacement[order]))

    def along(self, displacement: Array, force: Array) -> Array:
        """Force of another curve (m,) at the displacements of this one (n,)."""
        return np.interp(self.displacement, displacement, force)

    def along_table(self, table: pd.DataFrame, mode: str) -> Array:
        """Force (n,) [N] of a table `displacement_mm`, `force_N` in the signs of the mode."""
        sign = travel_sign(mode)
        displacement, force = (table[name].to_numpy() for name in ("displacement_mm", "force_N"))
        return self.along(sign * 1e-3 * displacement, sign * force)

    def scale_of(self, force: Array) -> float:
        """Factor that brings `force` (n,) at the same displacements closest to this curve.

        Least squares. Force is proportional to the shear modulus at a given fraction, so this is
        the factor by which a calibrated modulus changes if the geometry does.
        """
        return float(self.force @ force / (force @ force))

    @classmethod
    def of_record(cls, record: Record, mode: str, held_out: Mask | None = None) -> Self:
        """The marked loading of a record, without what is held out."""
        kept = record.calibrated.astype(bool)
        if held_out is not None:
            kept = kept & ~held_out
        sign = travel_sign(mode)
        return cls(sign * record.displacement[kept], sign * record.force[kept])

    @property
    def travel(self) -> float:
        """Largest displacement of the platen [m]."""
        return float(self.displacement.max())

    @property
    def area(self) -> float:
        """Area under the curve [J]."""
        return self.area_between(np.zeros_like(self.force))


FEWEST = 3
"""Points of a loading below which it is as good as held out."""


def fitted_curves(
    rows: Mapping[str, Mapping[str, str]],
    records: Sequence[Record],
    heights: Sequence[float],
    hold_out: Sequence[Mapping[str, Any]],
) -> dict[str, MeasuredCurve]:
    """Loadings of a group's samples that are calibrated, without what the study holds out.

    Parameters
    ----------
    rows : mapping
        Rows of the study table by sample, defaults filled in.
    records, heights : sequence
        Record and height of the idealised shape [m] of each.
    hold_out : sequence of mapping
        Selections of the study's settings.

    Raises
    ------
    CalibrationError
        If all of it is held out.
    """
    found = {}
    for (name, row), record, height in zip(rows.items(), records, heights, strict=True):
        curve = MeasuredCurve.of_record(
            record, row["mode"], held_out(record, row, height, "force", hold_out)
        )
        if len(curve.force) >= FEWEST:
            found[name] = curve
    if not found:
        raise CalibrationError(
            f"all of {', '.join(rows)} is held out: nothing is left to calibrate on; narrow "
            "hold_out in the settings of the study, or write the number of another loading into "
            "column cycle of the table"
        )
    return found
