"""Signed distance on a grid: exact near the surface, carried on below the base."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from scipy.sparse.linalg import spsolve
from scipy.spatial import cKDTree

from softsample.imaging.frame import Surface

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

CANDIDATES = 6
"""Triangles tried for each grid point: those with the nearest centres."""


def signed_distance(
    inside: Mask, surface: Surface, origin: Array, spacing: float, band: float
) -> Array:
    """Signed distance to a triangulated surface, negative inside.

    Parameters
    ----------
    inside : (nx, ny, nz) bool
        Grid points inside the surface.
    surface : Surface
        Triangles of about one grid spacing or smaller [m].
    origin : (3,) float64
        Position of grid point [0, 0, 0] [m].
    spacing : float
        Grid spacing [m].
    band : float
        Exact up to this distance [m]; beyond, correct to about a spacing.
    """
    outer = ndimage.distance_transform_edt(~inside)
    inner = ndimage.distance_transform_edt(inside)
    rough = np.where(inside, inner, outer) * spacing
    near = rough < band + spacing
    # Walls leave the grid through its lower face: beyond the band count from the band's edge.
    away, nearest = ndimage.distance_transform_edt(~near, sampling=spacing, return_indices=True)
    distance = np.zeros(inside.shape)
    distance[near] = unsigned_distance(origin + spacing * np.argwhere(near), surface)
    distance = np.where(near, distance, away + distance[tuple(nearest)])
    return np.asarray(np.where(inside, -distance, distance), dtype=np.float64)


def unsigned_distance(points: Array, surface: Surface) -> Array:
    """Distance of points (n, 3) [m] to the nearest of the triangles with the nearest centres."""
    count = min(CANDIDATES, len(surface.corners))
    _, candidates = cKDTree(surface.centres).query(points, k=count)
    candidates = candidates.reshape(len(points), count)
    best = np.full(len(points), np.inf)
    for column in candidates.T:
        best = np.minimum(best, _squared_to_triangle(points, surface.corners[column]))
    return np.sqrt(best)


def _squared_to_triangle(points: Array, corners: Array) -> Array:
    """Squared distance of each point (n, 3) to its own triangle (n, 3, 3)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    size = np.maximum(_dot(normal, normal), 1e-300)
    height = _dot(points - a, normal)
    over = np.ones(len(points), dtype=bool)
    squared = np.full(len(points), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        edge, offset = end - start, points - start
        over &= _dot(np.cross(edge, offset), normal) >= 0.0
        share = np.clip(_dot(offset, edge) / np.maximum(_dot(edge, edge), 1e-300), 0.0, 1.0)
        gap = offset - share[:, None] * edge
        squared = np.minimum(squared, _dot(gap, gap))
    return np.where(over & (size > 1e-300), height**2 / size, squared)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", a, b))


def fill_smoothly(distance: Array, unknown: Mask) -> Array:
    """Replace unknown values by the harmonic continuation of their surroundings.

    A plane wall is continued exactly, since its distance is linear.
    """
    if not unknown.any():
        return distance
    index = -np.ones(distance.shape, dtype=np.int64)
    index[unknown] = np.arange(np.count_nonzero(unknown))
    places = np.argwhere(unknown)
    rows, columns, right = [], [], np.zeros(len(places))
    degree = np.zeros(len(places))
    for axis in range(3):
        for step in (-1, 1):
            neighbour = places.copy()
            neighbour[:, axis] += step
            valid = (neighbour[:, axis] >= 0) & (neighbour[:, axis] < distance.shape[axis])
            at = tuple(neighbour[valid].T)
            degree[valid] += 1.0
            column, row = index[at], np.flatnonzero(valid)
            rows.append(row[column >= 0])
            columns.append(column[column >= 0])
            np.add.at(right, row[column < 0], distance[at][column < 0])
    row, column = np.concatenate(rows), np.concatenate(columns)
    links = sparse.coo_matrix((-np.ones(len(row)), (row, column)), shape=(len(places),) * 2)
    filled = distance.copy()
    filled[unknown] = spsolve((links + sparse.diags(degree)).tocsc(), right)
    return filled


def continue_below(distance: Array, first: int, layers: int, blur: float) -> Array:
    """Carry walls on below grid layer `first` with the slope of the `layers` above it.

    Parameters
    ----------
    distance : (nx, ny, nz) float64
        Distance to the walls; only layers from `first` on are read.
    first : int
        Lowest layer that is trusted.
    layers : int
        Layers above `first` that give the slope (least squares).
    blur : float
        Smoothing of the slope across the layers, in grid spacings.
    """
    height = np.arange(layers + 1, dtype=np.float64)
    weight = (height - height.mean()) / np.sum((height - height.mean()) ** 2)
    slope = distance[:, :, first : first + layers + 1] @ weight
    slope = ndimage.gaussian_filter(slope, blur)
    below = np.arange(-first, 0, dtype=np.float64)
    continued = distance.copy()
    continued[:, :, :first] = distance[:, :, first, None] + slope[:, :, None] * below
    return continued


def volume_above_base(distance: Array, origin: Array, spacing: float) -> float:
    """Volume inside the surface and above z = 0 [m3]; a grid layer must lie at z = 0."""
    base = round(float(-origin[2] / spacing))
    share = np.clip(0.5 - distance[:, :, base:] / spacing, 0.0, 1.0)
    layers = share.sum(axis=(0, 1)) * spacing**3
    return float(layers.sum() - 0.5 * layers[0])


def base_centroid(distance: Array, origin: Array, spacing: float) -> Array:
    """Centroid of the section at z = 0, (3,) [m]."""
    base = round(float(-origin[2] / spacing))
    share = np.clip(0.5 - distance[:, :, base] / spacing, 0.0, 1.0)
    x = origin[0] + spacing * np.arange(share.shape[0])
    y = origin[1] + spacing * np.arange(share.shape[1])
    return np.array([x @ share.sum(axis=1), y @ share.sum(axis=0), 0.0]) / share.sum()


def highest_point(distance: Array, origin: Array, spacing: float) -> Array:
    """Highest point of the surface, (3,) [m]: linear along the columns of the grid."""
    inside = distance < 0.0
    top = distance.shape[2] - 1 - np.argmax(inside[:, :, ::-1], axis=2)
    i, j = np.nonzero(inside.any(axis=2))
    k = np.minimum(top[i, j], distance.shape[2] - 2)
    lower, upper = distance[i, j, k], distance[i, j, k + 1]
    height = k + lower / (lower - upper)
    best = int(np.argmax(height))
    return np.asarray(origin + spacing * np.array([i[best], j[best], height[best]]))
