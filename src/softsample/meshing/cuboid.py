"""Mesh of the idealised sample: a cuboid with flat, parallel faces."""

import numpy as np

from softsample.errors import MeshError
from softsample.meshing.mesh import HexMesh


def mesh_cuboid(length: float, width: float, height: float, element_size: float) -> HexMesh:
    """Regular hexahedra in a cuboid, the origin at the centre of its base.

    Parameters
    ----------
    length, width, height : float
        Edges [m] along x, y and z, all > 0.
    element_size : float
        Wanted edge of the elements [m]; each edge of the cuboid is divided into
        ``floor(edge / element_size + 0.5)`` parts.

    Returns
    -------
    HexMesh
        Points [m], base plane z = 0, numbered with x fastest.

    Raises
    ------
    MeshError
        If an edge is no positive number or shorter than half an element.
    """
    edges = np.array([length, width, height], dtype=np.float64)
    if not (np.all(np.isfinite(edges)) and np.all(edges > 0.0) and element_size > 0.0):
        raise MeshError(
            f"cuboid of {length} x {width} x {height} m with elements of {element_size} m: "
            "all must be positive numbers; check the measured cuboid"
        )
    parts = np.floor(edges / element_size + 0.5).astype(np.int64)
    if np.any(parts < 1):
        raise MeshError(
            f"cuboid edge of {1e3 * edges.min():.3g} mm is shorter than half an element of "
            f"{1e3 * element_size:.3g} mm: choose a smaller mesh element size"
        )
    x, y, z = (np.linspace(0.0, e, n + 1) for e, n in zip(edges, parts, strict=True))
    return grid_of(x - 0.5 * length, y - 0.5 * width, z)


def grid_of(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> HexMesh:
    """Hexahedra between ascending coordinates (n,) [m] along three axes, x fastest."""
    parts = np.array([len(x), len(y), len(z)]) - 1
    grid = np.meshgrid(z, y, x, indexing="ij")
    points = np.stack(grid[::-1], axis=-1).reshape(-1, 3)
    node = np.arange(len(points)).reshape(parts[::-1] + 1)
    lower = [node[:-1, :-1, :-1], node[:-1, :-1, 1:], node[:-1, 1:, 1:], node[:-1, 1:, :-1]]
    upper = [node[1:, :-1, :-1], node[1:, :-1, 1:], node[1:, 1:, 1:], node[1:, 1:, :-1]]
    hexes = np.stack(lower + upper, axis=-1).reshape(-1, 8)
    return HexMesh(points, hexes.astype(np.int64))
