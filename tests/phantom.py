"""A made-up image of an imperfect cuboid, written without the code under test.

The shape is implicit, ``f(x, y, z) < 0`` in mm in its own frame, base on z = 0. The image is the
mean over each voxel of tissue, fluid film and darkness, times a bias field, with Rician noise.
"""

from dataclasses import dataclass

import numpy as np

TISSUE, FLUID = 300.0, 660.0


@dataclass(frozen=True)
class Cuboid:
    """Imperfect cuboid: taper, wavy walls, rounded edges, tilted and bumpy top; mm."""

    length: float = 14.0
    width: float = 12.0
    height: float = 9.0
    taper: float = 0.02  # loss of half-width per height
    wave: float = 0.25  # amplitude of the walls
    edge: float = 1.0  # radius
    slope: float = 0.03  # of the top
    bump: float = 0.3

    def top(self, x, y):
        return self.height + self.slope * x + self.bump * np.cos(x / 2.2) * np.cos(y / 2.7)

    def value(self, x, y, z):
        """Near the surface close to the signed distance; a smooth union of its sides."""
        lean = self.taper * z
        walls = (
            np.abs(x + self.wave * np.sin(y / 2.5 + 0.3 * z)) - 0.5 * self.length + lean,
            np.abs(y + self.wave * np.cos(x / 3.0 + 0.2 * z)) - 0.5 * self.width + lean,
            z - self.top(x, y),
        )
        outside = [np.clip(wall + self.edge, 0.0, None) for wall in walls]
        rounded = np.sqrt(sum(part**2 for part in outside)) - self.edge
        return np.where(rounded > -self.edge, rounded, np.max(walls, axis=0))

    def volume(self, step=0.1):
        """Volume above the base by counting points of a fine grid [mm3]."""
        x, y = np.meshgrid(*(np.arange(-9.0, 9.0, step) for _ in "xy"), indexing="ij")
        layers = np.arange(0.5 * step, 12.0, step)
        return step**3 * sum(np.count_nonzero(self.value(x, y, z) < 0.0) for z in layers)

    def highest(self, step=0.02):
        """Height of the highest point [mm]."""
        x, y = np.meshgrid(*(np.arange(-6.0, 6.0, 5 * step) for _ in "xy"), indexing="ij")
        z = np.arange(self.height - 1.0, self.height + 1.5, step)
        full = [height for height in z if (self.value(x, y, height) < 0.0).any()]
        return full[-1] + 0.5 * step


def turned(about_z, tilt, towards):
    """Rotation: by `about_z` in the base plane, then by `tilt` towards a direction [degrees]."""
    a, t, d = np.radians([about_z, tilt, towards])
    spin = np.array([[np.cos(a), -np.sin(a), 0.0], [np.sin(a), np.cos(a), 0.0], [0.0, 0.0, 1.0]])
    axis = np.array([-np.sin(d), np.cos(d), 0.0])
    cross = np.cross(np.eye(3), axis)
    lean = np.eye(3) - np.sin(t) * cross + (1.0 - np.cos(t)) * cross @ cross
    return lean @ spin


@dataclass(frozen=True)
class Scan:
    """How a shape is imaged: its place in the world, voxels, film, bias, noise."""

    voxel: tuple = (0.3, 0.3, 0.5)  # mm
    rotation: np.ndarray = None  # sample to world
    place: tuple = (0.7, -0.4, 1.1)  # of the base's middle in the world, mm
    snr: float = 25.0
    bias: float = 0.15
    film: float = 0.0  # mm
    drop: tuple = None  # centre in the sample frame and radius, mm
    flip: bool = False  # first image axis runs against world x
    seed: int = 3

    def matrix(self):
        """Sample frame to world, 4 x 4, mm."""
        to_world = np.eye(4)
        to_world[:3, :3] = np.eye(3) if self.rotation is None else self.rotation
        to_world[:3, 3] = self.place
        return to_world

    def image(self, shape, samples=4):
        """Image (int16) and affine [mm] of a shape; each voxel is the mean of samples**3 points."""
        voxel = np.array(self.voxel)
        count = np.ceil(np.array([20.0, 18.0, 15.0]) / voxel).astype(int)
        affine = np.diag([*voxel, 1.0])
        affine[:3, 3] = np.array(self.place) - 0.5 * voxel * (count - 1) + [0.0, 0.0, 4.5]
        if self.flip:
            affine[0] = [-voxel[0], 0.0, 0.0, affine[0, 3] + voxel[0] * (count[0] - 1)]
        to_sample = np.linalg.inv(self.matrix()) @ affine
        index = np.indices(count).reshape(3, -1).astype(np.float64)
        steps = (np.arange(samples) + 0.5) / samples - 0.5
        signal = np.zeros(index.shape[1])
        for shift in np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3):
            points = to_sample[:3, :3] @ (index + shift[:, None]) + to_sample[:3, 3:]
            signal += self._signal(shape, *points)
        signal = (signal / samples**3).reshape(count)
        u, v, w = (2.0 * i / n - 1.0 for i, n in zip(np.indices(count), count, strict=True))
        signal *= 1.0 + self.bias * (0.6 * u - 0.4 * v * w)
        noise = np.random.default_rng(self.seed).normal(0.0, TISSUE / self.snr, (2, *count))
        return np.hypot(signal + noise[0], noise[1]).astype(np.int16), affine

    def _signal(self, shape, x, y, z):
        value = shape.value(x, y, z)
        fluid = value < self.film
        if self.drop is not None:
            *centre, radius = self.drop
            away = np.sqrt(sum((p - c) ** 2 for p, c in zip((x, y, z), centre, strict=True)))
            fluid |= away < radius
        wet = np.where(value < 0.0, TISSUE, np.where(fluid, FLUID, 0.0))
        return np.where(z > 0.0, wet, 0.0)
