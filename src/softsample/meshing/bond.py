"""Which part of the top is glued: by a mask from the image, or peeled off from one side."""

import numpy as np
from numpy.typing import ArrayLike

from softsample.arrays import Array, Ids
from softsample.errors import InputError, MeshError
from softsample.meshing.marks import MarkedImage
from softsample.meshing.mesh import HexMesh, face_vectors


def bonded_nodes(mesh: HexMesh, mask: MarkedImage) -> Ids:
    """Nodes of the top surface that a mask marks as glued; the pre-load rule does not count.

    Parameters
    ----------
    mesh : HexMesh
        Mesh in the sample frame.
    mask : MarkedImage
        Not zero where the top is glued; only the voxels nearest to nodes of the top are asked,
        so that it may reach into the sample and out of it.

    Returns
    -------
    (n,) int64
        Sorted ids, from the corners of faces in the upper half of the mesh that look more up
        than sideways.

    Raises
    ------
    InputError
        If the mask marks none of these.
    """
    nodes = np.unique(top_quads(mesh, 45.0))
    glued = nodes[mask.at(mesh.points[nodes]) != 0]
    if len(glued) == 0:
        low, high = (1e3 * f(mesh.points[nodes, 2]) for f in (np.min, np.max))
        raise InputError(
            f"{mask.source}: marks no node of the top surface ({len(nodes)} nodes {low:.1f} to "
            f"{high:.1f} mm above the base); mark a layer of voxels on both sides of the bonded "
            "surface, in the world frame of the sample's image, or leave bond_mask empty"
        )
    return glued


def partial_bond(mesh: HexMesh, glued: Ids, fraction: float, direction: ArrayLike) -> Ids:
    """Glued nodes that are left when the top is peeled off from one side up to a straight line.

    Parameters
    ----------
    mesh : HexMesh
        Mesh in the sample frame.
    glued : (n,) int64
        Nodes glued before, such as ``mesh.glued(depth)``.
    fraction : float
        Part of the glued area, projected on the base, that stays glued; above 0, at most 1.
    direction : (2,) array
        In which the peeling goes on, in the x-y plane; the far side stays glued.

    Returns
    -------
    (m,) int64
        Sorted ids. A node stands for a quarter of each glued face at it; the line passes where
        the nodes beyond it come nearest to `fraction`, to half a row of elements.

    Raises
    ------
    MeshError
        If `fraction` or `direction` is none, or the glued nodes hold no face.
    """
    way = np.asarray(direction, dtype=np.float64)
    if not 0.0 < fraction <= 1.0:
        raise MeshError(f"bonded fraction is {fraction}: give a number above 0, at most 1")
    if way.shape != (2,) or not np.all(np.isfinite(way)) or not way.any():
        raise MeshError(f"direction of peeling is {way.tolist()}: give (x, y), not both 0")
    area = bonded_area(mesh, glued)
    if not area.sum() > 0.0:
        raise MeshError("the bonded nodes hold no upward face: give the bonded nodes of a top")
    # Places are rounded so that a row of a regular mesh stays whole.
    place = np.rint(mesh.points[glued, :2] @ (way / np.linalg.norm(way)) / mesh.edge_length * 1e6)
    lines, row = np.unique(place, return_inverse=True)
    beyond = np.cumsum(np.bincount(row.ravel(), area)[::-1])[::-1] / area.sum()
    line = lines[np.argmin(np.abs(beyond - fraction))]
    return glued[place >= line]


def bonded_area(mesh: HexMesh, glued: Ids) -> Array:
    """(n,) area [m2], projected on the base, of the upward faces between the `glued` nodes (n,).

    Each face gives a quarter to each of its corners; faces with other corners too do not count.
    """
    corners = mesh.quads_among(glued)
    area = face_vectors(mesh.points, mesh.boundary_quads)[:, 2]
    whole = np.all(corners >= 0, axis=1) & (area > 0.0)
    shares = np.repeat(0.25 * area[whole], 4)
    return np.bincount(corners[whole].ravel(), shares, len(glued)).astype(np.float64)


def top_quads(mesh: HexMesh, normal_deg: float) -> Ids:
    """(n, 4) faces of the upper half whose normals are within `normal_deg` of vertical."""
    normal = face_vectors(mesh.points, mesh.boundary_quads)
    steep = normal[:, 2] > np.cos(np.radians(normal_deg)) * np.linalg.norm(normal, axis=1)
    middle = mesh.points[mesh.boundary_quads, 2].mean(axis=1)
    return mesh.boundary_quads[steep & (middle > 0.5 * mesh.highest)]
