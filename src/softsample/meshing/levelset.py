"""Smooth signed distance to the surface of a sample: values, gradients, projection, volume."""

from dataclasses import dataclass
from functools import cached_property

import numba
import numpy as np
from scipy.ndimage import spline_filter

from softsample.arrays import Array, Mask
from softsample.errors import MeshError


@dataclass(frozen=True, eq=False)
class LevelSet:
    """Cubic B-spline through a signed distance grid; the solid is ``distance < 0`` and ``z > 0``.

    Parameters
    ----------
    distance : (nx, ny, nz) float
        Signed distance [m] at the grid points, negative inside.
    origin : (3,) float
        Position [m] of grid point ``[0, 0, 0]`` in the sample frame.
    spacing : float
        Grid spacing [m], the same along the three axes of the frame.
    """

    distance: Array
    origin: Array
    spacing: float

    def __post_init__(self) -> None:
        distance = np.asarray(self.distance, dtype=np.float64)
        origin = np.asarray(self.origin, dtype=np.float64)
        if distance.ndim != 3 or min(distance.shape) < 4 or origin.shape != (3,):
            raise MeshError(
                f"signed distance has shape {distance.shape} and origin {origin.shape}; "
                "expected a three-dimensional grid of at least 4 points a side and (3,)"
            )
        if not np.all(np.isfinite(distance)) or not self.spacing > 0.0:
            raise MeshError(
                f"signed distance holds {np.sum(~np.isfinite(distance))} values that are no "
                f"numbers, spacing {self.spacing} m: check the segmentation"
            )
        object.__setattr__(self, "distance", distance)
        object.__setattr__(self, "origin", origin)

    @cached_property
    def _coefficients(self) -> Array:
        return np.ascontiguousarray(spline_filter(self.distance, order=3, mode="mirror"))

    def __call__(self, points: Array) -> Array:
        """Signed distance [m] at `points` (n, 3) [m]; outside the grid, its nearest value."""
        return self.with_gradient(points)[0]

    def with_gradient(self, points: Array) -> tuple[Array, Array]:
        """Signed distance (n,) [m] and its gradient (n, 3) at `points` (n, 3) [m]."""
        position = (np.ascontiguousarray(points, dtype=np.float64) - self.origin) / self.spacing
        value, gradient = _spline(self._coefficients, position)
        return value, gradient / self.spacing

    def project(
        self, points: Array, in_plane: Mask, level: Array | float = 0.0, steps: int = 8
    ) -> Array:
        """Move `points` along the gradient onto a level set.

        Parameters
        ----------
        points : (n, 3) float64
            Positions [m] near the surface.
        in_plane : (n,) bool
            Points that keep their height and end on the contour in their plane.
        level : (n,) float64 or float
            Signed distance [m] that each point ends at; 0 is the surface.
        steps : int
            Newton steps; each is at most one grid spacing long.
        """
        moved = np.array(points, dtype=np.float64)
        for _ in range(steps):
            value, gradient = self.with_gradient(moved)
            gradient[in_plane, 2] = 0.0
            step = (value - level) / np.maximum(np.einsum("ij,ij->i", gradient, gradient), 0.05)
            step = np.clip(step, -self.spacing, self.spacing)
            moved -= step[:, None] * gradient
        return moved

    @cached_property
    def volume(self) -> float:
        """Volume [m3] of the solid above the base plane, midpoint rule on cells of the grid."""
        low, high = self.inside_box
        cell = 0.5 * self.spacing
        axes = [np.arange(low[a] - 2 * cell, high[a] + 2.5 * cell, cell) for a in (0, 1)]
        height = (np.arange(int(np.ceil(high[2] / cell)) + 2) + 0.5) * cell
        plane = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        total = 0.0
        for z in height:
            value = self(np.column_stack([plane, np.full(len(plane), z)]))
            total += float(np.clip(0.5 - value / cell, 0.0, 1.0).sum())
        return total * cell**3

    @cached_property
    def inside_box(self) -> tuple[Array, Array]:
        """Lowest and highest corner [m] of the box that holds the solid above the base plane."""
        first = max(int(np.ceil(-self.origin[2] / self.spacing - 1e-9)), 0)
        inside = np.argwhere(self.distance[:, :, first:] < 0.0) + np.array([0, 0, first])
        if len(inside) == 0:
            raise MeshError(
                "the signed distance is nowhere negative above the base plane z = 0: "
                "check the sign, the unit (m) and the grid origin"
            )
        low, high = inside.min(axis=0), inside.max(axis=0)
        if np.any(low[:2] == 0) or np.any(high == np.array(self.distance.shape) - 1):
            raise MeshError(
                "the sample touches the border of the signed distance grid: "
                "pad the grid, or image the whole sample"
            )
        return self.origin + low * self.spacing, self.origin + high * self.spacing

    @cached_property
    def steepest(self) -> tuple[float, Array]:
        """Largest gradient within 4 spacings of the surface above the base; its place (3,) [m].

        About 1 for a distance; much more where something torn or misplaced is in the grid.
        """
        slopes = np.gradient(self.distance, self.spacing)
        slope = np.sqrt(slopes[0] ** 2 + slopes[1] ** 2 + slopes[2] ** 2)
        slope[np.abs(self.distance) > 4.0 * self.spacing] = 0.0
        height = self.origin[2] + self.spacing * np.arange(slope.shape[2])
        slope[:, :, height < 0.0] = 0.0  # walls go on below it, as straight as they can
        place = np.unravel_index(int(np.argmax(slope)), slope.shape)
        return float(slope[place]), self.origin + self.spacing * np.array(place)

    @cached_property
    def highest_point(self) -> Array:
        """(3,) highest point [m] of the surface: the highest grid column, then refined.

        None higher than that column is: the spline overshoots at sharp edges.
        """
        _ = self.inside_box  # refuses a surface that leaves the grid
        point = highest_point(self.distance, self.origin, self.spacing)
        most, reach = point[2], self.spacing
        for _ in range(4):
            offset = np.linspace(-reach, reach, 11)
            x, y = (point[a] + grid for a, grid in enumerate(np.meshgrid(offset, offset)))
            heights = self._crossing(x.ravel(), y.ravel(), point[2], 2.0 * self.spacing)
            top = int(np.argmax(heights))
            point = np.array([x.flat[top], y.flat[top], heights[top]])
            reach *= 0.2
        return np.array([*point[:2], min(point[2], most)])

    def _crossing(self, x: Array, y: Array, height: float, reach: float) -> Array:
        """Height [m] within `height` +- `reach` where columns at `x`, `y` (n,) leave the solid."""
        lower, upper = np.full(len(x), height - reach), np.full(len(x), height + reach)
        for _ in range(25):
            middle = 0.5 * (lower + upper)
            inside = self(np.column_stack([x, y, middle])) < 0.0
            lower, upper = np.where(inside, middle, lower), np.where(inside, upper, middle)
        return 0.5 * (lower + upper)


def column_heights(distance: Array, origin: Array, spacing: float) -> Array:
    """(nx, ny) height [m] of the uppermost crossing of each grid column; lowest if none.

    The parameters are those of `LevelSet`; no column may be inside in its last layer.
    """
    inside = distance < 0.0
    last = inside.shape[2] - 1 - np.argmax(inside[:, :, ::-1], axis=2)
    last = np.where(inside.any(axis=2), last, 0)[..., None]
    below = np.take_along_axis(distance, last, axis=2)[..., 0]
    above = np.take_along_axis(distance, last + 1, axis=2)[..., 0]
    part = np.where(below < 0.0, below / np.where(below < 0.0, below - above, 1.0), 0.0)
    return np.asarray(origin[2] + (last[..., 0] + part) * spacing)


def highest_point(distance: Array, origin: Array, spacing: float) -> Array:
    """Highest point of the surface, (3,) [m]: linear along the columns of the grid."""
    height = column_heights(distance, origin, spacing)
    best = np.unravel_index(int(np.argmax(height)), height.shape)
    return np.array([*(origin[:2] + spacing * np.array(best)), height[best]])


@numba.njit(cache=True)
def _spline(coefficients: Array, position: Array) -> tuple[Array, Array]:
    """Value and gradient of a cubic B-spline at `position` in grid units, clamped to the grid."""
    n = position.shape[0]
    value = np.zeros(n)
    gradient = np.zeros((n, 3))
    weight = np.empty((3, 4))
    slope = np.empty((3, 4))
    index = np.empty((3, 4), dtype=np.int64)
    for p in range(n):
        for a in range(3):
            size = coefficients.shape[a]
            x = min(max(position[p, a], 0.0), size - 1.0)
            cell = min(int(x), size - 2)
            t = x - cell
            s = 1.0 - t
            weight[a, 0] = s * s * s / 6.0
            weight[a, 1] = 2.0 / 3.0 - t * t + 0.5 * t * t * t
            weight[a, 2] = 2.0 / 3.0 - s * s + 0.5 * s * s * s
            weight[a, 3] = t * t * t / 6.0
            slope[a, 0] = -0.5 * s * s
            slope[a, 1] = -2.0 * t + 1.5 * t * t
            slope[a, 2] = 2.0 * s - 1.5 * s * s
            slope[a, 3] = 0.5 * t * t
            for m in range(4):
                i = abs(cell - 1 + m)
                index[a, m] = i if i < size else 2 * size - 2 - i
        for i in range(4):
            for j in range(4):
                line, rise = 0.0, 0.0
                for k in range(4):
                    c = coefficients[index[0, i], index[1, j], index[2, k]]
                    line += weight[2, k] * c
                    rise += slope[2, k] * c
                value[p] += weight[0, i] * weight[1, j] * line
                gradient[p, 0] += slope[0, i] * weight[1, j] * line
                gradient[p, 1] += weight[0, i] * slope[1, j] * line
                gradient[p, 2] += weight[0, i] * weight[1, j] * rise
    return value, gradient
