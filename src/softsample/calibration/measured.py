"""Loading ramp of one test as a curve: what a calibration follows."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsample.protocol import loading_ramp, travel_sign

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MeasuredCurve:
    """Loading ramp of one test along the direction of the travel.

    Parameters
    ----------
    displacement : (n,) float64
        Travel of the platen [m].
    force : (n,) float64
        Force of the platen on the sample along the travel [N]; positive when it resists.
    """

    displacement: Array
    force: Array

    def area_between(self, force: Array) -> float:
        """Absolute area [J] between this curve and `force` (n,) at the same displacements.

        Exact for the two polygons, also where they cross between points. Without that the
        objective would have a kink wherever a point changes sides.
        """
        order = np.argsort(self.displacement, kind="stable")
        gap = (self.force - force)[order]
        before, after = np.abs(gap[:-1]), np.abs(gap[1:])
        height = 0.5 * (before + after)
        crossed = gap[:-1] * gap[1:] < 0.0
        height[crossed] -= (before * after)[crossed] / (before + after)[crossed]
        return float(height @ np.diff(self.displacement[order]))

    def scale_of(self, force: Array) -> float:
        """Factor that brings `force` (n,) at the same displacements closest to this curve.

        Least squares. Force is proportional to the shear modulus at a given mixture, so this is
        the factor by which a calibrated modulus changes if the geometry does.
        """
        return float(self.force @ force / (force @ force))

    @classmethod
    def of_record(cls, record: pd.DataFrame, mode: str) -> Self:
        """Loading ramp of a record with columns `time_s`, `displacement_mm`, `force_N`."""
        sign = travel_sign(mode)
        time, displacement = record["time_s"].to_numpy(), record["displacement_mm"].to_numpy()
        ramp = loading_ramp(time, 1e-3 * displacement)
        return cls(sign * 1e-3 * displacement[ramp], sign * record["force_N"].to_numpy()[ramp])

    @property
    def travel(self) -> float:
        """Largest travel of the platen [m]."""
        return float(self.displacement.max())

    @property
    def area(self) -> float:
        """Area under the curve [J]."""
        return self.area_between(np.zeros_like(self.force))
