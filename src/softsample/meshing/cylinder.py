"""Mesh of the idealised round sample: a cylinder with flat, parallel ends."""

import numpy as np

from softsample.arrays import Array, Ids
from softsample.errors import MeshError
from softsample.meshing.mesh import HexMesh

CORE = 0.7
"""Distance of the inner square's corners from the axis, in radii; it evens out the elements."""

BULGE = np.tan(np.radians(15.0))
"""Roundness of the inner square, 0 straight to 1 a circle; here its corners are of 120 degrees,
so that the three elements that meet there have equal angles."""


def mesh_cylinder(diameter: float, height: float, element_size: float) -> HexMesh:
    """Hexahedra in a cylinder: an inner square with bulging sides and rings around it (O-grid).

    Parameters
    ----------
    diameter, height : float
        Of the cylinder [m], both > 0.
    element_size : float
        Wanted edge of the elements [m].

    Returns
    -------
    HexMesh
        Points [m], axis z, origin at the centre of the base; layers of nodes are flat. A section
        is a regular polygon of k corners with the area of the circle: the nodes of the wall lie
        outside it by ``pi^2 / (3 k^2)`` of the radius, the middles of the sides inside it by half
        as much.

    Raises
    ------
    MeshError
        If a length is no positive number or too short for the elements.

    Notes
    -----
    Verified in ``tests/unit/test_meshing_cylinder.py``.
    """
    lengths = np.array([diameter, height, element_size], dtype=np.float64)
    if not (np.all(np.isfinite(lengths)) and np.all(lengths > 0.0)):
        raise MeshError(
            f"cylinder of diameter {diameter} m and height {height} m with elements of "
            f"{element_size} m: all must be positive numbers; check the measured cylinder"
        )
    radius = 0.5 * diameter
    middle = CORE * ((1.0 - BULGE) * np.sqrt(0.5) + BULGE)  # of a side, from the axis, in radii
    side = 0.5 * (np.sqrt(2.0) * CORE + 0.5 * np.pi) * radius  # mean of inner side and arc
    wall = (1.0 - 0.5 * (CORE + middle)) * radius  # mean width of the rings
    parts = np.floor(np.array([side, wall, height]) / element_size + 0.5).astype(np.int64)
    if np.any(parts < 1):
        raise MeshError(
            f"cylinder of diameter {1e3 * diameter:.3g} mm and height {1e3 * height:.3g} mm is "
            f"too small for elements of {1e3 * element_size:.3g} mm: choose a smaller mesh "
            "element size"
        )
    step = 0.5 * np.pi / parts[0]  # angle between neighbouring nodes of the wall
    outward = np.sqrt(step / np.sin(step))
    plane, quads = _disc(outward * radius, int(parts[0]), int(parts[1]))
    return extruded(plane, quads, np.linspace(0.0, height, parts[2] + 1))


def _disc(radius: float, across: int, rings: int) -> tuple[Array, Ids]:
    """Points (n, 2) [m] and quads (m, 4), counter-clockwise, of a disc about the origin."""
    u, v = np.meshgrid(*[np.linspace(-1.0, 1.0, across + 1)] * 2, indexing="ij")
    straight = np.sqrt(0.5) * np.stack([u, v], axis=-1)
    round_ = np.stack([u * np.sqrt(1.0 - 0.5 * v**2), v * np.sqrt(1.0 - 0.5 * u**2)], axis=-1)
    square = CORE * radius * ((1.0 - BULGE) * straight + BULGE * round_)
    node = np.arange((across + 1) ** 2).reshape(across + 1, across + 1)
    border = np.concatenate([node[:-1, 0], node[-1, :-1], node[:0:-1, -1], node[0, :0:-1]])
    angle = 0.5 * np.pi * (np.arange(4 * across) / across - 1.5)  # from the corner (-1, -1) on
    circle = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    square = square.reshape(-1, 2)
    part = np.arange(1, rings + 1)[:, None, None] / rings
    around = (1.0 - part) * square[border] + part * circle
    ring = np.vstack([border, node.size + np.arange(around[..., 0].size).reshape(rings, -1)])
    ring = np.column_stack([ring, ring[:, 0]])
    points = np.concatenate([square, around.reshape(-1, 2)])
    return points, np.concatenate([_quads_of(node), _quads_of(ring)])


def _quads_of(grid: Ids) -> Ids:
    """Quads (m, 4) between the nodes of a grid."""
    corners = [grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]]
    return np.stack(corners, axis=-1).reshape(-1, 4)


def disc_of(rings: Array, near: float) -> tuple[Array, Ids]:
    """Points (n, 2) [m] and quads (m, 4) of a disc with rings at given radii.

    Parameters
    ----------
    rings : (n,) float64
        Ascending radii [m] from 0 on; those up to `near` are those of an inner disc of square
        core, the others are circles around it.
    near : float
        Radius of the inner disc [m].
    """
    inside = int(np.searchsorted(rings, near * (1.0 + 1e-9))) - 1
    across = 2 * max(1, round(0.6 * inside))  # even: a node lies in the middle
    core = max(1, inside - across // 2)
    plane, quads = _disc(near, across, core)
    wall = np.arange(len(plane) - 4 * across, len(plane))  # the last ring of the inner disc
    angle = np.arctan2(plane[wall, 1], plane[wall, 0])
    circles = rings[inside + 1 :, None, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    ids = np.vstack([wall, len(plane) + np.arange(circles[..., 0].size).reshape(-1, len(wall))])
    ids = np.column_stack([ids, ids[:, 0]])
    points = np.concatenate([plane, circles.reshape(-1, 2)])
    return points, np.concatenate([quads, _quads_of(ids)])


def extruded(plane: Array, quads: Ids, heights: Array) -> HexMesh:
    """Layers of hexahedra over quads (m, 4) of points `plane` (n, 2) [m], at `heights` [m]."""
    points = np.column_stack([np.tile(plane, (len(heights), 1)), np.repeat(heights, len(plane))])
    lower = quads + len(plane) * np.arange(len(heights) - 1)[:, None, None]
    hexes = np.concatenate([lower, lower + len(plane)], axis=-1).reshape(-1, 8)
    return HexMesh(points, hexes)
