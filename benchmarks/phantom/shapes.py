"""More shapes of known surface: imperfect cylinders, and any shape turned about z."""

from dataclasses import dataclass

import numpy as np

from softsample.arrays import Array
from softsample.blindlab.phantom import Shape, Standing, Waves


@dataclass(frozen=True)
class ImperfectCylinder(Standing):
    """Round sample with taper, lobes, a wavy wall, a rounded rim and a tilted, bumpy top.

    Attributes
    ----------
    diameter, height : float
        Nominal sizes [mm].
    lobes : tuple of (float, float)
        Amplitude [mm] and phase [rad] of the radius' waves of two, three, ... around.
    wall : Waves
        Over (x + y, z - height / 2).
    top, taper, slope, edge
        As of `ImperfectCuboid`.
    """

    diameter: float
    height: float
    lobes: tuple[tuple[float, float], ...]
    wall: Waves
    top: Waves
    taper: float
    slope: tuple[float, float]
    edge: float

    def _half_widths(self) -> tuple[float, float]:
        return 0.5 * self.diameter, 0.5 * self.diameter

    def _beyond_walls(self, x: Array, y: Array, z: Array) -> list[Array]:
        angle = np.arctan2(y, x)
        radius = 0.5 * self.diameter - self.taper * z + self.wall(x + y, z - 0.5 * self.height)
        for order, (size, phase) in enumerate(self.lobes, start=2):
            radius = radius + size * np.cos(order * angle + phase)
        return [np.hypot(x, y) - radius]


@dataclass(frozen=True)
class Turned:
    """A shape seen in axes that are turned about z.

    Attributes
    ----------
    shape : Shape
    angle : float
        From the shape's x axis to the new one [rad].
    """

    shape: Shape
    angle: float

    @property
    def box(self) -> Array:
        """Half-lengths in x and y, and height, of a box that holds the solid, (3,) [mm]."""
        reach = float(np.hypot(*self.shape.box[:2]))
        return np.array([reach, reach, self.shape.box[2]])

    def value(self, x: Array, y: Array, z: Array) -> Array:
        """Function that is negative inside and close to the signed distance near the surface."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        return self.shape.value(c * x - s * y, s * x + c * y, z)
