"""What mesh and element type leave open of a simulated force."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class FloorSettings:
    """What mesh and element type leave open; mirrors config `floor:`.

    Parameters
    ----------
    mesh_order : float
        Order with which the error of the mesh is taken to fall with the element size.
    element_size_mm : sequence of float
        Element sizes [mm], ascending, at which `element_percent` was measured.
    element_percent : mapping
        By mode, difference of one-point and three-field hexahedra [% of force] at these sizes.
    """

    mesh_order: float
    element_size_mm: Sequence[float]
    element_percent: Mapping[str, Sequence[float]]

    def element(self, mode: str, size_mm: float) -> float:
        """Difference of the two elements [% of force] at an element size [mm]."""
        # ASSUME: the planes along which a pure shear test is bonded strain its elements as those
        # of a tension test do; confined compression is a homogeneous strain, which both elements
        # represent exactly. Numbers of their own in the config take precedence.
        like = {"pure_shear": "tension"}.get(mode, mode)
        percents = self.element_percent.get(mode, self.element_percent.get(like))
        if percents is None:
            return 0.0
        return float(np.interp(np.log(size_mm), np.log(self.element_size_mm), percents))

    def scale_error(self, mode: str, size_mm: float) -> float:
        """Standard deviation of the scale of a simulated force, as a part of it."""
        return 0.01 * rectangular(self.element(mode, size_mm))


def rectangular(half_width: float) -> float:
    """Standard deviation of a value that lies anywhere within limits; keeps the limit's sign."""
    return half_width / float(np.sqrt(3.0))
