"""The samples of the laboratory: cuboids of many proportions, and imperfect ones."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from softsample.blindlab.phantom import random_cuboid
from softsample.shapes import IdealShape
from softsample.units import MM

MODES = ("tension", "compression", "shear")

STROKE = {"tension": 0.27, "compression": 0.23, "shear": 0.5}
"""Travel of each test over the height of the sample."""

ALPHA = (-8.0, 16.0)
"""Exponents of the tissue."""

POISSON = 0.49

PRESSED = 0.28
"""Compression that is left over from the pre-load where one is [mm]."""


@dataclass(frozen=True)
class Body:
    """A sample and what is drawn by lot about it.

    Parameters
    ----------
    number : int
        Seed.
    imperfect : bool
        Whether it has a bumpy, tilted, tapered surface; its cuboid is the judge's model then.
    length, width, height : float
        Of the cuboid [mm].
    mixture : float
        r = mu1 / mu, dimensionless.
    azimuth : float
        Direction in the x-y plane of what has one: tilt, peeled side, fibres, inclusion [rad].
    """

    number: int
    imperfect: bool
    length: float
    width: float
    height: float
    mixture: float
    azimuth: float

    @classmethod
    def draw(cls, number: int, imperfect: bool) -> Self:
        """Body of a number; an imperfect one is nearly as tall, long and wide as its phantom."""
        random = np.random.default_rng([number, 7])
        length, width, height = random.uniform((18.0, 15.0, 10.0), (25.0, 22.0, 15.0)).tolist()
        if imperfect:
            shape = random_cuboid(number)
            length, width, height = shape.length, shape.width, shape.height
        mixture, azimuth = random.uniform((0.45, 0.0), (0.95, 2.0 * np.pi))
        return cls(number, imperfect, length, width, height, float(mixture), float(azimuth))

    @classmethod
    def named(cls, name: str) -> Self:
        """Body of a `name`."""
        kind, number = name.rsplit("_", 1)
        return cls.draw(int(number), kind == "shape")

    @property
    def name(self) -> str:
        """Name of its files."""
        return f"{'shape' if self.imperfect else 'cuboid'}_{self.number}"

    @property
    def shape(self) -> IdealShape:
        """Its cuboid [m]."""
        return IdealShape("cuboid", MM * self.length, MM * self.width, MM * self.height)

    @property
    def volume(self) -> float:
        """Of the cuboid [mm3]."""
        return self.length * self.width * self.height

    def stroke(self, mode: str) -> float:
        """Travel of a test [mm]."""
        return STROKE[mode] * self.height

    def toward(self) -> tuple[float, float]:
        """Unit vector in the x-y plane along the body's azimuth."""
        return float(np.cos(self.azimuth)), float(np.sin(self.azimuth))
