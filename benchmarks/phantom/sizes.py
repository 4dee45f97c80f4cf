"""Exact sizes of a shape: surface, volume, highest point, areas, cuboid."""

from dataclasses import dataclass

import numpy as np
from skimage.measure import marching_cubes

from softsample.arrays import Array
from softsample.blindlab.phantom import Shape, gradient

SECTION_OFFSET = 0.75
"""Distance of the lower and upper section of the cuboid from base and top [mm]."""

CORE = 0.7
"""Central part of an extent over which widths and heights are averaged."""


@dataclass(frozen=True)
class Sizes:
    """Sizes of a shape, defined as in ``docs/geometry.md``.

    Attributes
    ----------
    length, width, height : float
        Cuboid [mm].
    volume : float
        Above the base [mm3].
    highest : float
        Height of the highest point [mm].
    bottom_area, top_area : float
        Section at z = 0; projection of the upper surface within 30 degrees of vertical [mm2].
    """

    length: float
    width: float
    height: float
    volume: float
    highest: float
    bottom_area: float
    top_area: float


def measured(shape: Shape, step: float = 0.1) -> Sizes:
    """Sizes of a shape on a grid of `step` [mm], points on its surface found by bisection."""
    x, y = (np.arange(-half, half, step) + 0.5 * step for half in shape.box[:2])
    top = _tops(shape, x, y)
    floor = _column_shares(shape, x, y, 0.0)
    centre = (x @ floor.sum(axis=1) / floor.sum(), y @ floor.sum(axis=0) / floor.sum())
    length, width, height = 0.8 * shape.box
    for _ in range(5):
        core = np.outer(
            abs(x - centre[0]) < 0.5 * CORE * length, abs(y - centre[1]) < 0.5 * CORE * width
        )
        height = float(np.nanmean(top[core]))
        levels = (SECTION_OFFSET, 0.5 * height, height - SECTION_OFFSET)
        length = float(np.mean([_mean_width(shape, z, 0) for z in levels]))
        width = float(np.mean([_mean_width(shape, z, 1) for z in levels]))
    points, vectors = surface_points(shape, step=0.3)
    steep = vectors[:, 2] > np.cos(np.radians(30.0)) * np.linalg.norm(vectors, axis=1)
    upper = steep & (points[:, 2] > 0.5 * np.nanmax(top))
    return Sizes(
        length=length,
        width=width,
        height=height,
        volume=_volume(shape, step),
        highest=float(np.nanmax(top)),
        bottom_area=float(floor.sum() * step**2),
        top_area=float(vectors[upper, 2].sum()),
    )


def surface_points(shape: Shape, step: float = 0.3) -> tuple[Array, Array]:
    """Points (n, 3) on the surface above the base and the area vector (n, 3) [mm2] of each.

    Centres of the facets of a grid of `step` [mm], moved onto the surface.
    """
    half = shape.box
    low, high = np.array([-half[0], -half[1], 0.0]), half
    axes = [np.arange(a, b + step, step) for a, b in zip(low, high, strict=True)]
    value = shape.value(*np.meshgrid(*axes, indexing="ij"))
    corners, faces, _, _ = marching_cubes(value, 0.0, gradient_direction="descent")
    corners = (low + step * corners.astype(np.float64))[faces]
    vectors = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    points = corners.mean(axis=1)
    outward = np.einsum("ij,ij->i", vectors, gradient(shape, points)).sum()
    for _ in range(3):
        slope = gradient(shape, points)
        size = np.einsum("ij,ij->i", slope, slope)
        points = points - (shape.value(*points.T) / size)[:, None] * slope
    return points, np.sign(outward) * vectors


def shares(shape: Shape, points: Array, edge: float) -> Array:
    """Share (n,) of small cells of `edge` [mm] around `points` (n, 3) inside a shape."""
    return np.clip(0.5 - shape.value(*points.T) / edge, 0.0, 1.0)


def _volume(shape: Shape, step: float) -> float:
    """Volume above the base: coarse cells, those near the surface divided [mm3]."""
    parts = 4
    coarse = parts * step
    axes = [
        np.arange(a, b, coarse) + 0.5 * coarse
        for a, b in (
            (-shape.box[0], shape.box[0]),
            (-shape.box[1], shape.box[1]),
            (0.0, shape.box[2]),
        )
    ]
    centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    value = shape.value(*centres.T)
    near = np.abs(value) < 1.1 * coarse  # half a diagonal, and slopes a little off 1
    total = np.count_nonzero((value < 0.0) & ~near) * coarse**3
    offsets = (np.arange(parts) + 0.5) * step - 0.5 * coarse
    for offset in np.stack(np.meshgrid(*(offsets,) * 3), axis=-1).reshape(-1, 3):
        total += shares(shape, centres[near] + offset, step).sum() * step**3
    return float(total)


def _column_shares(shape: Shape, x: Array, y: Array, z: float) -> Array:
    """Share of each cell of the plane at `z` inside, (nx, ny)."""
    u, v = np.meshgrid(x, y, indexing="ij")
    points = np.stack([u.ravel(), v.ravel(), np.full(u.size, z)], axis=1)
    return shares(shape, points, x[1] - x[0]).reshape(u.shape)


def _tops(shape: Shape, x: Array, y: Array) -> Array:
    """Height of the top over each column, (nx, ny) [mm]; NaN beside the sample."""
    u, v = np.meshgrid(x, y, indexing="ij")
    levels = np.arange(0.0, shape.box[2], 0.25)
    last = np.full(u.shape, -1.0)
    for z in levels:
        last = np.where(shape.value(u, v, np.full(u.shape, z)) < 0.0, z, last)
    low, high = last.copy(), last + 0.25
    for _ in range(14):
        middle = 0.5 * (low + high)
        inside = shape.value(u, v, middle) < 0.0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return np.where(last >= 0.0, 0.5 * (low + high), np.nan)


def _mean_width(shape: Shape, z: float, axis: int, step: float = 0.05) -> float:
    """Mean chord along `axis` over the central part of the section's extent across [mm]."""
    across = 1 - axis
    reach = [np.arange(-half, half, step) + 0.5 * step for half in shape.box[:2]]
    place = np.stack(np.meshgrid(reach[axis], reach[across], indexing="ij"), axis=-1)
    points = np.empty((place[..., 0].size, 3))
    points[:, axis], points[:, across], points[:, 2] = (
        place[..., 0].ravel(),
        place[..., 1].ravel(),
        z,
    )
    inside = shares(shape, points, step).reshape(place.shape[:2])
    rows = np.flatnonzero(inside.max(axis=0) > 0.5)
    first, last = reach[across][rows[0]] - 0.5 * step, reach[across][rows[-1]] + 0.5 * step
    core = abs(reach[across] - 0.5 * (first + last)) < 0.5 * CORE * (last - first)
    return float(inside[:, core].sum(axis=0).mean() * step)
