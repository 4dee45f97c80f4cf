"""Sample frame: base plane, direction of the walls, rigid maps between sample and world."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import ndimage
from scipy.spatial import ConvexHull
from skimage.measure import marching_cubes

from softsample.arrays import Array, Mask
from softsample.errors import SegmentationError

BASE_CONE_DEG = 35.0
"""Faces whose normal is this close to straight down may belong to the base."""

MOST_TURN_DEG = 10.0
"""Angle of walls to the shear axis from which on it is told: as the largest tilt of a base."""


@dataclass(frozen=True)
class Surface:
    """Triangulated surface.

    Attributes
    ----------
    corners : (n, 3, 3) float64
        Corners of the triangles [m].
    """

    corners: Array

    @property
    def centres(self) -> Array:
        """Centres of the triangles, (n, 3) [m]."""
        return np.asarray(self.corners.mean(axis=1))

    @property
    def area_vectors(self) -> Array:
        """Outward normals times area, (n, 3) [m2]."""
        edge1 = self.corners[:, 1] - self.corners[:, 0]
        edge2 = self.corners[:, 2] - self.corners[:, 0]
        return np.asarray(0.5 * np.cross(edge1, edge2))

    def where(self, chosen: Mask) -> "Surface":
        """The part of the surface whose triangles are `chosen`, (n,)."""
        return Surface(self.corners[chosen])


def iso_surface(field: Array, level: float, affine: Array) -> Surface:
    """Surface ``field == level``, normals pointing to smaller values of the field.

    Parameters
    ----------
    field : (nx, ny, nz) float64
        Values on a grid.
    level : float
        Value on the surface.
    affine : (4, 4) float64
        From grid index to position [m]; may be oblique, anisotropic or left-handed.
    """
    points, faces, _, _ = marching_cubes(field, level, gradient_direction="ascent")
    points = points.astype(np.float64) @ affine[:3, :3].T + affine[:3, 3]
    corners = points[faces]
    if np.linalg.det(affine[:3, :3]) < 0.0:
        corners = corners[:, ::-1]
    return Surface(np.ascontiguousarray(corners))


def fit_base(surface: Surface, up: Array, max_tilt: float) -> tuple[Array, Array, float]:
    """Plane of the flat base.

    Parameters
    ----------
    surface : Surface
        Closed surface of the sample [m], world.
    up : (3,) float64
        Nominal loading axis, unit vector.
    max_tilt : float
        Largest angle between the base normal and `up` that is accepted [rad].

    Returns
    -------
    point : (3,) float64
        A point of the plane [m].
    normal : (3,) float64
        Unit normal, into the sample.
    spread : float
        Robust standard deviation of the base's distances from the plane [m].

    Raises
    ------
    SegmentationError
        If no flat base is seen or its tilt is too large.
    """
    vectors, centres = surface.area_vectors, surface.centres
    area = np.linalg.norm(vectors, axis=1)
    down = -vectors @ up > np.cos(np.radians(BASE_CONE_DEG)) * area
    down &= area > 0.0
    if np.count_nonzero(down) < 50:
        raise SegmentationError(
            "no flat base was found at the lower end of the loading axis; give an image of the"
            " sample bonded to its platen, and a loading_axis that points from there upward"
        )
    points, weight = centres[down], area[down]
    # Overhangs of the walls also look down: start from the widest level, the base.
    height = points @ up
    start = _weighted_median(height, weight)
    extent = float(np.max(np.ptp(points @ _across(up), axis=0)))
    near = np.abs(height - start) < 1e-3 + 0.5 * np.tan(max_tilt) * extent
    point, normal, spread = _robust_plane(points[near], weight[near], up)
    tilt = float(np.arccos(np.clip(normal @ up, -1.0, 1.0)))
    if tilt > max_tilt:
        raise SegmentationError(
            f"base is tilted by {np.degrees(tilt):.1f} degrees from the loading axis, at most"
            f" {np.degrees(max_tilt):.0f} are taken out; raise segmentation.max_tilt_deg, or turn"
            " the image"
        )
    return point, normal, spread


def base_share(surface: Surface, point: Array, normal: Array, reach: float, rim: float) -> float:
    """Share of the underside that lies within `reach` [m] of a plane, both projected on it.

    The underside is what looks down in the lower half of the surface, without its rim [m], which
    voxels and smoothing round. On a platen all of it is base; a sample without one has an underside
    as uneven as its top.
    """
    height, down = (surface.centres - point) @ normal, -surface.area_vectors @ normal
    under = (down > 0.0) & (height < 0.5 * height.max())
    places = surface.centres @ _across(normal)
    walls = ConvexHull(places[under]).equations
    inside = -(places @ walls[:, :2].T + walls[:, 2]).max(axis=1) > rim
    inner = under & inside if (under & inside).any() else under
    return float(down[inner & (np.abs(height) < reach)].sum() / down[inner].sum())


def _across(axis: Array) -> Array:
    """Two unit vectors normal to an axis and to each other, (3, 2)."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = np.cross(axis, helper)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first)], axis=1)


def _weighted_median(values: Array, weight: Array) -> float:
    order = np.argsort(values)
    total = np.cumsum(weight[order])
    return float(values[order][np.searchsorted(total, 0.5 * total[-1])])


def _robust_plane(points: Array, weight: Array, up: Array) -> tuple[Array, Array, float]:
    """Plane by Tukey's biweight; the rim, where meniscus and walls pull, loses its weight."""
    trust = np.ones(len(points))
    spread = np.inf
    for _ in range(30):
        w = weight * trust
        middle = (w[:, None] * points).sum(axis=0) / w.sum()
        offset = points - middle
        normal = np.linalg.eigh((w[:, None] * offset).T @ offset)[1][:, 0]
        normal = normal * np.sign(normal @ up)
        residual = offset @ normal
        residual = residual - _weighted_median(residual, w)
        spread = max(1.4826 * _weighted_median(np.abs(residual), w), 1e-6)
        trust = np.maximum(1.0 - (residual / (4.685 * spread)) ** 2, 0.0) ** 2
    return middle, normal, float(spread)


def wall_direction(surface: Surface, normal: Array, shear: Array) -> Array:
    """Unit vector in the base plane, along the walls' normal nearest to the shear axis.

    The walls of a cuboid look in four directions: their angles are averaged modulo 90 degrees.
    A round sample has no preferred direction and takes the shear axis itself.
    """
    x = shear - (shear @ normal) * normal
    x /= np.linalg.norm(x)
    y = np.cross(normal, x)
    vectors = surface.area_vectors
    area = np.linalg.norm(vectors, axis=1)
    wall = (np.abs(vectors @ normal) < 0.35 * area) & (area > 0.0)
    angle = np.arctan2(vectors[wall] @ y, vectors[wall] @ x)
    if area[wall].sum() == 0.0:
        return x
    moment = np.sum(area[wall] * np.exp(4j * angle)) / area[wall].sum()
    turn = np.angle(moment) / 4.0 if abs(moment) > 0.1 else 0.0
    return np.asarray(np.cos(turn) * x + np.sin(turn) * y)


def told_turn(x: Array, shear: Array) -> tuple[str, ...]:
    """What to say of walls `x` that are not along the shear axis: the sample is sheared along x."""
    turn = float(np.degrees(np.arccos(np.clip(x @ shear, -1.0, 1.0))))
    told = f"turned by {turn:.0f} degrees from the shear axis: shear is along its wall"
    return (told,) if turn > MOST_TURN_DEG else ()


def rigid(x: Array, normal: Array, origin: Array) -> Array:
    """Map (4, 4) from the sample frame (x, normal cross x, normal; origin) to world [m]."""
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = x, np.cross(normal, x), normal
    matrix[:3, 3] = origin
    return matrix


def grid_affine(origin: Array, spacing: float) -> Array:
    """Map (4, 4) from grid index to position, axes along the frame [m]."""
    affine = np.diag([spacing, spacing, spacing, 1.0])
    affine[:3, 3] = origin
    return affine


def sampled(
    field: Array,
    to_index: Array,
    shape: tuple[int, ...],
    order: Literal[1, 3],
    outside: float = 0.0,
) -> Array:
    """Values of a field on another grid of `shape`, whose indices `to_index` (4, 4) maps."""
    matrix, offset = to_index[:3, :3], to_index[:3, 3]
    return np.asarray(
        ndimage.affine_transform(field, matrix, offset, shape, order=order, cval=outside)
    )


def values_at(field: Array, grid: Array, points: Array) -> Array:
    """Values of a field at the grid points nearest to `points` (n, 3), (n,)."""
    inverse = np.linalg.inv(grid)
    index = np.rint(points @ inverse[:3, :3].T + inverse[:3, 3]).astype(np.int64)
    index = np.clip(index, 0, np.array(field.shape) - 1)
    return np.asarray(field[tuple(index.T)])
