"""Meshes of idealised samples that are fine where an indenter meets them."""

import numpy as np

from softsample.arrays import Array
from softsample.errors import MeshError
from softsample.meshing.cuboid import grid_of
from softsample.meshing.cylinder import disc_of, extruded
from softsample.meshing.mesh import HexMesh
from softsample.shapes import IdealShape

GROWTH = 1.2
"""Largest ratio of neighbouring elements."""


def graded_hexes(shape: IdealShape, fine: float, near: float, coarse: float) -> HexMesh:
    """Hexahedra that are fine around the middle of the top and grow away from it.

    Parameters
    ----------
    shape : IdealShape
        Cuboid or cylinder.
    fine : float
        Edge of the elements around the middle of the top [m].
    near : float
        Distance from it [m], sideways and down, up to which they are fine; a line of nodes lies
        there.
    coarse : float
        Largest edge of the elements [m].

    Returns
    -------
    HexMesh
        Points [m], base plane z = 0, origin at the centre of the base.

    Raises
    ------
    MeshError
        If the lengths do not ascend, or what is near leaves the sample.
    """
    half = 0.5 * min(shape.length, shape.width)
    if not 0.0 < fine <= coarse:
        raise MeshError(f"elements of {1e3 * fine:g} to {1e3 * coarse:g} mm: give ascending edges")
    if not fine <= near < 0.9 * half:
        raise MeshError(
            f"the indented part of {1e3 * near:.3g} mm is no part of a sample of half width "
            f"{1e3 * half:.3g} mm; check the radius of the indenter"
        )
    down = graded(shape.height, fine, min(near, 0.5 * shape.height), coarse)
    z = shape.height - down[::-1]
    if shape.kind == "cylinder":
        rings = graded(half, fine, near, coarse)
        return extruded(*disc_of(rings, near), z)
    x, y = (graded(0.5 * e, fine, near, coarse) for e in (shape.length, shape.width))
    return grid_of(np.concatenate([-x[:0:-1], x]), np.concatenate([-y[:0:-1], y]), z)


def graded(length: float, fine: float, near: float, coarse: float) -> Array:
    """Ascending coordinates (n,) [m] from 0 to `length`: even up to `near`, growing beyond it."""
    first = np.linspace(0.0, near, max(1, round(near / fine)) + 1)
    steps: list[float] = []
    size = float(first[1])
    while sum(steps) < length - near:
        size = min(GROWTH * size, coarse)
        steps.append(size)
    grown = np.array(steps) * (length - near) / sum(steps)
    return np.concatenate([first, near + np.cumsum(grown)])
