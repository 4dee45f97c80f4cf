"""Phantoms: imperfect cuboids as zero sets of smooth functions, drawn from a seed.

Lengths are in mm and directions in the shape's own frame: base on z = 0, loading axis +z.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from softsample.arrays import Array

STEP = 1e-4
"""Half-width of the central differences of `gradient` [mm]."""


class Shape(Protocol):
    """A solid that stands on z = 0 and goes on below it."""

    @property
    def box(self) -> Array:
        """Half-lengths in x and y, and height, of a box that holds the solid, (3,) [mm]."""

    def value(self, x: Array, y: Array, z: Array) -> Array:
        """Function that is negative inside and close to the signed distance near the surface."""


@dataclass(frozen=True)
class Waves:
    """Sum of plane waves over a face, and a parabolic bow.

    Attributes
    ----------
    amplitude, phase : (n,) tuple of float
        Of each wave [mm], [rad].
    direction : (n, 2) tuple
        Wave vectors [rad/mm].
    bow : (2,) tuple of float
        Curvature along the two coordinates of the face [1/mm]; positive bulges outward.
    """

    amplitude: tuple[float, ...] = ()
    direction: tuple[tuple[float, float], ...] = ()
    phase: tuple[float, ...] = ()
    bow: tuple[float, float] = (0.0, 0.0)

    def __call__(self, s: Array, t: Array) -> Array:
        """Height [mm] of the waves at face coordinates `s`, `t` [mm]."""
        height = -0.5 * (self.bow[0] * s**2 + self.bow[1] * t**2)
        for size, (k, m), shift in zip(self.amplitude, self.direction, self.phase, strict=True):
            height = height + size * np.cos(k * s + m * t + shift)
        return np.asarray(height)


class Standing:
    """What imperfect samples have in common: a tilted, bumpy top, and edges that are rounded."""

    height: float
    top: Waves
    slope: tuple[float, float]
    edge: float

    def _half_widths(self) -> tuple[float, float]:
        """Nominal, in x and y [mm]."""
        raise NotImplementedError

    def _beyond_walls(self, x: Array, y: Array, z: Array) -> list[Array]:
        """Way outward from each wall [mm]."""
        raise NotImplementedError

    @property
    def box(self) -> Array:
        """Half-lengths in x and y, and height, of a box that holds the solid, (3,) [mm]."""
        return np.array([*self._half_widths(), self.height]) + 2.5

    def value(self, x: Array, y: Array, z: Array) -> Array:
        """Function that is negative inside and close to the signed distance near the surface."""
        top = self.height + self.slope[0] * x + self.slope[1] * y + self.top(x, y)
        return _rounded([*self._beyond_walls(x, y, z), z - top], self.edge)


@dataclass(frozen=True)
class ImperfectCuboid(Standing):
    """Cuboid with taper, bowed and wavy walls, rounded edges and a tilted, bumpy top.

    Attributes
    ----------
    length, width, height : float
        Nominal edges along x, y, z [mm].
    walls : 4 Waves
        Of the walls +x, -x, +y, -y, over (the other horizontal axis, z - height / 2).
    top : Waves
        Over (x, y).
    taper : float
        Loss of half-width per height.
    slope : (2,) tuple of float
        Of the top along x and y.
    edge : float
        Radius of the edges between walls and of the top's rim [mm].
    """

    length: float
    width: float
    height: float
    walls: tuple[Waves, Waves, Waves, Waves]
    top: Waves
    taper: float
    slope: tuple[float, float]
    edge: float

    def _half_widths(self) -> tuple[float, float]:
        return 0.5 * self.length, 0.5 * self.width

    def _beyond_walls(self, x: Array, y: Array, z: Array) -> list[Array]:
        lean, middle = self.taper * z, z - 0.5 * self.height
        return [
            x - 0.5 * self.length + lean - self.walls[0](y, middle),
            -x - 0.5 * self.length + lean - self.walls[1](y, middle),
            y - 0.5 * self.width + lean - self.walls[2](x, middle),
            -y - 0.5 * self.width + lean - self.walls[3](x, middle),
        ]


def _rounded(sides: list[Array], radius: float) -> Array:
    """Meeting of half-spaces with rounded edges."""
    beyond = sum(np.maximum(side + radius, 0.0) ** 2 for side in sides)
    return np.asarray(np.where(beyond > 0.0, np.sqrt(beyond) - radius, np.max(sides, axis=0)))


def gradient(shape: Shape, points: Array) -> Array:
    """Gradient (n, 3) of a shape's function at `points` (n, 3) by central differences."""
    slopes = []
    for axis in range(3):
        step = STEP * np.eye(3)[axis]
        rise = shape.value(*(points + step).T) - shape.value(*(points - step).T)
        slopes.append(rise / (2.0 * STEP))
    return np.stack(slopes, axis=1)


def signed_distance(shape: Shape, points: Array, steps: int = 8) -> Array:
    """Signed distance (n,) to a shape's surface, the base left out.

    The foot point is found by Newton steps onto the surface, each followed by a slide along it.

    Parameters
    ----------
    shape : Shape
    points : (n, 3) float64
        Places [mm].
    steps : int
        Iterations; 8 give 1 um within 0.3 mm of a surface whose radii are 0.5 mm or more.
    """
    points = np.asarray(points, dtype=np.float64)
    foot = points.copy()
    for _ in range(steps):
        value, slope = shape.value(*foot.T), gradient(shape, foot)
        size = np.maximum(np.einsum("ij,ij->i", slope, slope), 1e-6)
        to_point = points - foot
        along = np.einsum("ij,ij->i", to_point, slope) / size
        foot = foot + to_point - (along + value / size)[:, None] * slope
    gap = np.linalg.norm(points - foot, axis=1)
    return np.where(shape.value(*points.T) < 0.0, -gap, gap)


def random_cuboid(seed: int, bumps: float = 1.0) -> ImperfectCuboid:
    """Imperfect cuboid of about 23 x 20 x 13 mm; `bumps` scales its waves."""
    random = np.random.default_rng([seed, 1])
    walls = tuple(waves(random, 3, 0.22 * bumps, 0.012) for _ in range(4))
    return ImperfectCuboid(
        length=random.uniform(19.0, 25.0),
        width=random.uniform(16.0, 22.0),
        height=random.uniform(9.0, 14.0),
        walls=walls,  # type: ignore[arg-type]  # four of them
        top=waves(random, 4, 0.3 * bumps, 0.006),
        taper=random.uniform(-0.02, 0.06),
        slope=(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05)),
        edge=random.uniform(0.7, 1.8),
    )


def waves(random: np.random.Generator, count: int, size: float, bow: float) -> Waves:
    """Waves of 6 to 16 mm length and about `size` amplitude altogether, bow up to `bow`."""
    angle, length = random.uniform(0.0, np.pi, count), random.uniform(6.0, 16.0, count)
    share = random.uniform(0.3, 1.0, count)
    return Waves(
        amplitude=tuple(map(float, size * share / share.sum() * length / length.mean())),
        direction=tuple(
            (float(k * np.cos(a)), float(k * np.sin(a)))
            for k, a in zip(2.0 * np.pi / length, angle, strict=True)
        ),
        phase=tuple(map(float, random.uniform(0.0, 2.0 * np.pi, count))),
        bow=(float(random.uniform(-bow, bow)), float(random.uniform(-bow, bow))),
    )
