"""Signed distance on a grid: exact near the surface, carried on below the base."""

import numba
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from scipy.sparse.linalg import spsolve

from softsample.arrays import Array, Ids, Mask
from softsample.imaging.frame import Surface

BAND = 7.0
"""Distance up to which the nearest triangle is searched for, in grid spacings."""

SEARCHES = 6
"""Blocks of 27 cells searched for the nearest triangle, one after the other, at most."""


def signed_distance(inside: Mask, surface: Surface, origin: Array, spacing: float) -> Array:
    """Signed distance to a triangulated surface, negative inside.

    Parameters
    ----------
    inside : (nx, ny, nz) bool
        Grid points inside the surface.
    surface : Surface
        Triangles of about one grid spacing or smaller [m], within the grid.
    origin : (3,) float64
        Position of grid point [0, 0, 0] [m].
    spacing : float
        Grid spacing [m].
    """
    corners = (surface.corners - origin) / spacing
    places = tuple(np.rint(corners.mean(axis=1)).astype(np.int64).T)
    cell = np.ravel_multi_index(places, inside.shape, mode="clip")
    order = np.argsort(cell, kind="stable")
    first = np.searchsorted(cell[order], np.arange(inside.size + 1))
    empty = (np.diff(first) == 0).reshape(inside.shape)
    start = ndimage.distance_transform_edt(empty, return_distances=False, return_indices=True)
    distance = spacing * _distance(start, corners[order], first)
    return np.asarray(np.where(inside, -distance, distance), dtype=np.float64)


@numba.njit(cache=True)
def _distance(start: NDArray[np.int32], corners: Array, first: Ids) -> Array:
    """Distance (nx, ny, nz) of the grid points to triangles, in grid spacings.

    The search begins around the nearest cell that holds a triangle, `start` (3, nx, ny, nz), and
    goes on around the point found for as long as that comes nearer. The triangles `corners`
    (n, 3, 3) are sorted: those of cell c are ``first[c]`` to ``first[c + 1]``.
    """
    nx, ny, nz = start.shape[1:]
    distance = np.empty((nx, ny, nz))
    for i, j, k in np.ndindex(nx, ny, nz):
        a, b, c = start[0, i, j, k], start[1, i, j, k], start[2, i, j, k]
        x, y, z = 0.0, 0.0, 0.0
        best = np.inf
        around = 1 if (a - i) ** 2 + (b - j) ** 2 + (c - k) ** 2 < BAND**2 else 0
        for _ in range(SEARCHES):
            for u in range(max(a - around, 0), min(a + around + 1, nx)):
                for v in range(max(b - around, 0), min(b + around + 1, ny)):
                    row = (u * ny + v) * nz
                    last = first[row + min(c + around + 1, nz)]
                    for t in range(first[row + max(c - around, 0)], last):
                        p, q, r = _nearest_point(corners[t], i, j, k)
                        gap = (p - i) ** 2 + (q - j) ** 2 + (r - k) ** 2
                        if gap < best:
                            best, x, y, z = gap, p, q, r
            if around == 0 or (a == round(x) and b == round(y) and c == round(z)):
                break
            a, b, c = round(x), round(y), round(z)
        distance[i, j, k] = np.sqrt(best)
    return distance


@numba.njit(cache=True)
def _nearest_point(triangle: Array, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Point of a triangle (3, 3) nearest to (x, y, z)."""
    a, b, c = triangle
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    px, py, pz = x - a[0], y - a[1], z - a[2]
    uu, vv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz
    uv = ux * vx + uy * vy + uz * vz
    pu, pv = px * ux + py * uy + pz * uz, px * vx + py * vy + pz * vz
    area = uu * vv - uv * uv  # squared, of the parallelogram
    s, t = vv * pu - uv * pv, uu * pv - uv * pu
    if area > 0.0 and s >= 0.0 and t >= 0.0 and s + t <= area:
        s, t = s / area, t / area
    else:  # beyond an edge: along u, along v, or from one to the other
        least = np.inf
        on_u, on_v = _within(pu, uu), _within(pv, vv)
        across = _within(pv - pu + uu - uv, uu + vv - 2.0 * uv)
        for m, n in ((on_u, 0.0), (0.0, on_v), (1.0 - across, across)):
            gap = m * m * uu + n * n * vv + 2.0 * (m * n * uv - m * pu - n * pv)
            if gap < least:
                least, s, t = gap, m, n
    return a[0] + s * ux + t * vx, a[1] + s * uy + t * vy, a[2] + s * uz + t * vz


@numba.njit(cache=True)
def _within(along: float, whole: float) -> float:
    """Share of an edge at which a point lies beside it, kept between its ends."""
    return min(max(along / max(whole, 1e-300), 0.0), 1.0)


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
