"""Topology of the mesh: a castellated core of grid cells and one buffer layer around it."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from softsample.arrays import Array, Mask
from softsample.errors import MeshError
from softsample.meshing.mesh import HexMesh

# The eight cells around a node, numbered by the bits (x, y, z) of their offset.
OFFSETS = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)])


def _torn_patterns() -> Mask:
    """(256,) which occupations of the eight cells around a node make a non-manifold surface.

    That is where those inside, or those outside, do not hang together by faces.
    """
    blocks = (np.arange(256)[:, None] >> np.arange(8) & 1).reshape(-1, 2, 2, 2)
    return np.array([max(label(block)[1], label(1 - block)[1]) > 1 for block in blocks])


TORN = _torn_patterns()


def _with_mirror(cells: Mask) -> Mask:
    """Cells with an empty frame, but the lowest layer repeated below the base plane."""
    framed = np.pad(cells, 1)
    framed[:, :, 0] = framed[:, :, 1]
    return framed


def _patterns(cells: Mask) -> NDArray[np.int64]:
    """(nx + 1, ny + 1, nz + 1) occupation of the eight cells around each node, as bits."""
    framed = _with_mirror(cells).astype(np.int64)
    nx, ny, nz = cells.shape
    total = np.zeros((nx + 1, ny + 1, nz + 1), dtype=np.int64)
    for bit, (i, j, k) in enumerate(OFFSETS):
        total |= framed[i : i + nx + 1, j : j + ny + 1, k : k + nz + 1] << bit
    return total


def _neighbours(cells: Mask) -> NDArray[np.int64]:
    """(6, nx, ny, nz) occupation of the face neighbours in the order -x +x -y +y -z +z."""
    framed = _with_mirror(cells)
    centre = slice(1, -1)
    shifted = []
    for axis in range(3):
        for side in (slice(0, -2), slice(2, None)):
            window = [centre, centre, centre]
            window[axis] = side
            shifted.append(framed[tuple(window)])
    return np.array(shifted, dtype=np.int64)


def clean_core(cells: Mask, depth: Array, floor: float) -> Mask:
    """Make the surface of a set of grid cells manifold and free of spikes and pits.

    Parameters
    ----------
    cells : (nx, ny, nz) bool
        Cells of the core; layer 0 stands on the base plane.
    depth : (nx, ny, nz) float64
        Depth of the cell centres below the surface [m], positive inside.
    floor : float
        Least depth [m] that a cell needs to be added in a pit.

    Returns
    -------
    (nx, ny, nz) bool
        The largest connected set of cells without nodes or edges at which it only touches
        itself, without cells that stick out (exposed on opposite sides or on four or more).
    """
    cells = cells.copy()
    for _ in range(3):
        pit = ~cells & (_neighbours(cells).sum(axis=0) >= 4) & (depth > floor)
        cells |= pit
    while True:
        before = int(cells.sum())
        _remove_spikes(cells)
        _remove_tears(cells, depth)
        if int(cells.sum()) == before:
            break
    parts, count = label(cells)
    if count > 1:
        cells = parts == 1 + int(np.argmax(np.bincount(parts.ravel())[1:]))
    return cells


def _remove_spikes(cells: Mask) -> None:
    """Take away cells with four free faces or with free faces on opposite sides, in place."""
    while True:
        free = 1 - _neighbours(cells)
        opposite = (free[0::2] & free[1::2]).any(axis=0)
        spike = cells & (opposite | (free.sum(axis=0) >= 4))
        if not spike.any():
            return
        cells[spike] = False


def _remove_tears(cells: Mask, depth: Array) -> None:
    """Take the shallowest cell away at every node where the surface is not manifold, in place."""
    while True:
        torn = np.argwhere(TORN[_patterns(cells)])
        if len(torn) == 0:
            return
        around = torn[:, None, :] + OFFSETS[None] - 1
        around[:, :, 2] = np.maximum(around[:, :, 2], 0)
        inside = np.all((around >= 0) & (around < cells.shape), axis=2)
        i, j, k = np.where(inside[..., None], around, 0).transpose(2, 0, 1)
        height = np.where(inside & cells[i, j, k], depth[i, j, k], np.inf)
        pick = around[np.arange(len(torn)), np.argmin(height, axis=1)]
        cells[tuple(pick.T)] = False


def core_cells(
    depth_at: Callable[[Array], Array], low: Array, high: Array, size: float, core_depth: float
) -> tuple[Mask, Array]:
    """Grid cells far enough inside the solid, and the corner [m] of the grid.

    Parameters
    ----------
    depth_at : callable
        Depth [m] below the surface at points (n, 3) [m], positive inside.
    low, high : (3,) float64
        Box [m] around the solid; the lowest layer of cells stands on z = 0.
    size : float
        Edge [m] of the cells.
    core_depth : float
        Depth of a cell's centre, in cells, from which on it belongs to the core.

    Returns
    -------
    cells : (nx, ny, nz) bool
    corner : (3,) float64

    Raises
    ------
    MeshError
        If fewer than two layers of cells fit into the solid, or none stands on the base.
    """
    count = np.ceil((high - low) / size).astype(np.int64) + 2
    count[2] = int(np.ceil(high[2] / size)) + 1
    corner = 0.5 * (low + high) - 0.5 * count * size
    corner[2] = 0.0
    axes = [corner[a] + (np.arange(count[a]) + 0.5) * size for a in range(3)]
    centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    depth = depth_at(centres).reshape(count)
    cells = clean_core(depth > core_depth * size, depth, 0.7 * core_depth * size)
    extent = np.ptp(np.argwhere(cells), axis=0) + 1 if cells.any() else np.zeros(3, dtype=int)
    if extent.min() < 2:
        raise MeshError(
            f"elements of {1e3 * size:.3g} mm are too coarse: only {extent[0]} x {extent[1]} x "
            f"{extent[2]} whole cells fit into the sample; choose a smaller mesh element size"
        )
    if not cells[:, :, 0].any():
        raise MeshError(
            "the sample does not reach down to the base plane z = 0: "
            "check the base plane of the segmentation"
        )
    return cells, corner


def castellated_mesh(cells: Mask, corner: Array, size: float) -> HexMesh:
    """Hexahedra of the occupied grid cells; `corner` [m] of the grid, `size` [m] of a cell."""
    nodes = np.array(cells.shape) + 1
    cell = np.argwhere(cells)
    order = np.array([0, 1, 3, 2, 4, 5, 7, 6])
    corners = cell[:, None, :] + OFFSETS[order][None]
    flat = np.ravel_multi_index(tuple(corners.transpose(2, 0, 1)), tuple(nodes))
    used, hexes = np.unique(flat, return_inverse=True)
    points = corner + size * np.stack(np.unravel_index(used, tuple(nodes)), axis=-1)
    return HexMesh(points, hexes.reshape(-1, 8).astype(np.int64))


def add_buffer(core: HexMesh) -> tuple[HexMesh, NDArray[np.int64]]:
    """Put one layer of elements on the sides and the top of a core that stands on z = 0.

    Parameters
    ----------
    core : HexMesh
        Mesh with a manifold surface and a flat base.

    Returns
    -------
    mesh : HexMesh
        Core nodes first, then one outer node for every surface node of the core, at the same
        place, so that the new elements have no volume yet.
    inner : (n_outer,) int64
        Core node under each outer node.
    """
    quads = core.boundary_quads
    quads = quads[~np.all(core.points[quads, 2] == 0.0, axis=1)]
    inner, local = np.unique(quads, return_inverse=True)
    outer = local.reshape(-1, 4) + len(core.points)
    hexes = np.concatenate([core.hexes, np.concatenate([quads, outer], axis=1)])
    return HexMesh(np.concatenate([core.points, core.points[inner]]), hexes), inner
