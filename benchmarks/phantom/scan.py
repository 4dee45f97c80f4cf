"""Magnetic resonance image of a shape: partial volume, film, drops, bias field, texture, noise."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from phantom.sizes import shares
from softsample.arrays import Array, Mask
from softsample.blindlab.phantom import Shape

TISSUE = 300.0
"""Mean intensity of tissue."""

FINE = 0.13
"""Longest edge of the cells that a voxel near the surface is divided into [mm]."""


@dataclass(frozen=True)
class Ripple:
    """Smooth random field: a sum of plane waves of random direction, standard deviation 1.

    Attributes
    ----------
    wave : float
        Typical wave length [mm].
    seed : int
    """

    wave: float
    seed: int

    def __call__(self, points: Array) -> Array:
        """Values (n,) at `points` (n, 3) [mm]."""
        random = np.random.default_rng(self.seed)
        count = 12
        direction = random.normal(size=(count, 3))
        direction *= 2.0 * np.pi / self.wave / np.linalg.norm(direction, axis=1)[:, None]
        direction *= random.uniform(0.6, 1.5, (count, 1))
        phase = random.uniform(0.0, 2.0 * np.pi, count)
        total = np.zeros(len(points))
        for k, shift in zip(direction, phase, strict=True):
            total += np.cos(points @ k + shift)
        return total * np.sqrt(2.0 / count)


@dataclass(frozen=True)
class Scan:
    """How a shape is imaged; lengths in mm.

    Attributes
    ----------
    voxel : (3,) tuple of float
        Edges of a voxel.
    rotation, place : (3, 3) and (3,) arrays
        Sample frame to world.
    image_rotation : (3, 3) array
        Image axes in the world: columns.
    snr : float
        Tissue over the noise's standard deviation.
    bias : float
        Largest relative deviation of the bias field.
    texture : float
        Relative step between grey and white matter, half of it up and half down.
    film : float
        Mean thickness of the saline film; it varies with a standard deviation of a third.
    fluid : float
        Brightness of saline over tissue.
    meniscus : float
        Thickness of the film where wall and base meet; it falls off over 0.3 mm.
    drops, bubbles, neighbours : tuple of (x, y, z, radius)
        Balls of saline, of air inside the tissue, of other tissue; in the sample frame.
    margin : float
        Air between the shape's box and the edge of the field of view; negative cuts it off.
    flips : (3,) tuple of bool
        Image axes that run backwards.
    seed : int
        Of noise, texture, bias field and the film's variation.
    """

    voxel: tuple[float, float, float] = (0.25, 0.25, 0.5)
    rotation: Array = field(default_factory=lambda: np.eye(3))
    place: tuple[float, float, float] = (0.7, -0.4, 1.1)
    image_rotation: Array = field(default_factory=lambda: np.eye(3))
    snr: float = 25.0
    bias: float = 0.15
    texture: float = 0.1
    film: float = 0.0
    fluid: float = 2.2
    meniscus: float = 0.0
    drops: tuple[tuple[float, float, float, float], ...] = ()
    bubbles: tuple[tuple[float, float, float, float], ...] = ()
    neighbours: tuple[tuple[float, float, float, float], ...] = ()
    margin: float = 2.0
    flips: tuple[bool, bool, bool] = (False, False, False)
    seed: int = 0

    @property
    def sample_to_world(self) -> Array:
        """Sample frame to world, (4, 4) [mm]."""
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = self.rotation, self.place
        return matrix

    def image(self, shape: Shape) -> tuple[NDArray[np.int16], Array]:
        """Image (nx, ny, nz) and its affine (4, 4) to world [mm]."""
        count, affine = self._grid(shape)
        to_sample = np.linalg.inv(self.sample_to_world) @ affine
        index = np.indices(count).reshape(3, -1).T.astype(np.float64)
        signal = self._voxel_means(shape, index, to_sample).reshape(count)
        signal *= 1.0 + self._bias(index, count)
        noise = np.random.default_rng(self.seed).normal(0.0, TISSUE / self.snr, (2, *count))
        return np.rint(np.hypot(signal + noise[0], noise[1])).astype(np.int16), affine

    def tissue_mask(self, shape: Shape) -> Mask:
        """Voxels (nx, ny, nz) whose centre lies in the shape above its base."""
        count, affine = self._grid(shape)
        to_sample = np.linalg.inv(self.sample_to_world) @ affine
        points = np.indices(count).reshape(3, -1).T @ to_sample[:3, :3].T + to_sample[:3, 3]
        return np.asarray((shape.value(*points.T) < 0.0) & (points[:, 2] > 0.0)).reshape(count)

    def _grid(self, shape: Shape) -> tuple[tuple[int, int, int], Array]:
        """Numbers of voxels and affine of a field of view around the shape's box."""
        half, low = shape.box, -2.0
        corners = np.array(
            [
                [a * half[0], b * half[1], c]
                for a in (-1, 1)
                for b in (-1, 1)
                for c in (low, half[2])
            ]
        )
        world = corners @ self.rotation.T + self.place
        axes = self.image_rotation * np.where(self.flips, -1.0, 1.0)
        along = world @ axes
        start, end = along.min(axis=0) - self.margin, along.max(axis=0) + self.margin
        count = np.ceil((end - start) / self.voxel).astype(int)
        affine = np.eye(4)
        affine[:3, :3] = axes * self.voxel
        affine[:3, 3] = axes @ start
        return (int(count[0]), int(count[1]), int(count[2])), affine

    def _voxel_means(self, shape: Shape, index: Array, to_sample: Array) -> Array:
        """Mean signal of each voxel; those that hold one thing only are sampled once."""
        matrix, shift = to_sample[:3, :3], to_sample[:3, 3]
        centres = index @ matrix.T + shift
        reach = np.linalg.norm(self.voxel)
        near = np.abs(shape.value(*centres.T)) < reach + 4.0 * self.film + self.meniscus
        near |= (np.abs(centres[:, 2]) < reach) & (shape.value(*centres.T) < reach + self.meniscus)
        for *place, radius in (*self.drops, *self.bubbles, *self.neighbours):
            near |= np.abs(np.linalg.norm(centres - place, axis=1) - radius) < reach
        signal = self._signal(shape, centres, 1e-9)
        parts = [int(np.ceil(edge / FINE)) for edge in self.voxel]
        steps = [(np.arange(n) + 0.5) / n - 0.5 for n in parts]
        cell = float(np.max(np.array(self.voxel) / parts))
        total = np.zeros(np.count_nonzero(near))
        for step in np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3):
            total += self._signal(shape, centres[near] + matrix @ step, cell)
        signal[near] = total / np.prod(parts)
        return signal

    def _signal(self, shape: Shape, points: Array, cell: float) -> Array:
        """Mean signal (n,) of cells of edge `cell` around `points` (n, 3)."""
        tissue = shares(shape, points, cell)
        value = shape.value(*points.T)
        wet = np.clip(0.5 - (value - self._thickness(points)) / cell, 0.0, 1.0)
        for drop in self.drops:
            wet = np.maximum(wet, _ball(points, drop, cell))
        for bubble in self.bubbles:
            air = _ball(points, bubble, cell)
            tissue, wet = tissue * (1.0 - air), wet * (1.0 - air)
        other = np.zeros(len(points))
        for neighbour in self.neighbours:
            other = np.maximum(other, _ball(points, neighbour, cell))
        level = TISSUE * (1.0 + self._texture(points))
        signal = level * np.maximum(tissue, other) + TISSUE * self.fluid * (wet - tissue)
        return np.asarray(signal * np.clip(0.5 + points[:, 2] / cell, 0.0, 1.0))

    def _thickness(self, points: Array) -> Array:
        """Thickness of the film at `points` (n, 3) [mm]."""
        thickness = np.zeros(len(points))
        if self.film > 0.0:
            ripple = Ripple(5.0, self.seed + 1)(points)
            thickness = np.maximum(self.film * (1.0 + ripple / 3.0), 0.0)
        if self.meniscus > 0.0:
            thickness = thickness + self.meniscus * np.exp(-np.maximum(points[:, 2], 0.0) / 0.3)
        return thickness

    def _texture(self, points: Array) -> Array:
        """Relative deviation of the tissue: grey and white with soft borders."""
        return 0.5 * self.texture * np.tanh(2.0 * Ripple(6.0, self.seed + 2)(points))

    def _bias(self, index: Array, count: tuple[int, int, int]) -> Array:
        """Bias field minus 1, at most `bias`: linear and quadratic over the image."""
        random = np.random.default_rng(self.seed + 3)
        u, v, w = (2.0 * index / np.array(count) - 1.0).T
        terms = np.stack([u, v, w, u * v, v * w, u * w, u**2 - 0.5, v**2 - 0.5, w**2 - 0.5])
        mix = random.normal(size=9) * np.array([1.0, 1.0, 1.0, *[0.5] * 6])
        bias = mix @ terms
        return np.asarray(self.bias * bias / np.max(np.abs(bias))).reshape(count)


def _ball(points: Array, ball: tuple[float, float, float, float], cell: float) -> Array:
    """Share (n,) of cells around `points` inside a ball."""
    *centre, radius = ball
    return np.clip(0.5 - (np.linalg.norm(points - centre, axis=1) - radius) / cell, 0.0, 1.0)
