"""The same mesh on a boundary that lies a little further in or out."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve

from softsample.arrays import Array, Mask
from softsample.meshing.levelset import LevelSet
from softsample.meshing.mesh import EDGES, HexMesh


def shifted(mesh: HexMesh, surface: LevelSet, sigma: LevelSet, times: float) -> HexMesh:
    """Move the surface of a mesh along its normals by a multiple of a length that varies.

    Against a new mesh of the moved boundary nothing else changes, so that small differences of
    forces come out clean. Nodes inside follow as a harmonic field on the graph of the edges; nodes
    of the base stay in its plane.

    Parameters
    ----------
    mesh : HexMesh
        Mesh of the surface.
    surface : LevelSet
        Signed distance to it [m].
    sigma : LevelSet
        The length [m], a field on a grid.
    times : float
        Multiple; positive moves outward.
    """
    base = np.zeros(len(mesh.points), bool)
    base[mesh.bottom] = True
    skin = np.unique(mesh.boundary_quads[~base[mesh.boundary_quads].all(axis=1)])
    here = mesh.points[skin]
    level = surface(here) + times * sigma(here)
    way = np.zeros_like(mesh.points)
    way[skin] = surface.project(here, base[skin], level) - here
    for axis in range(3):
        known = base.copy() if axis == 2 else np.zeros_like(base)
        known[skin] = True
        way[:, axis] = _harmonic(mesh, way[:, axis], known)
    return HexMesh(mesh.points + way, mesh.hexes)


def _harmonic(mesh: HexMesh, values: Array, known: Mask) -> Array:
    """Values whose unknown ones are the means of their neighbours along the edges."""
    ends = np.unique(np.sort(mesh.hexes[:, EDGES].reshape(-1, 2), axis=1), axis=0)
    n = len(mesh.points)
    ones = np.ones(len(ends))
    graph = coo_array((ones, (ends[:, 0], ends[:, 1])), shape=(n, n)).tocsr()
    graph = graph + graph.T
    free = np.flatnonzero(~known)
    degree = coo_array((graph.sum(axis=1)[free], (np.arange(len(free)),) * 2))
    full = values.copy()
    full[free] = spsolve(
        (degree - graph[free][:, free]).tocsc(), graph[free] @ np.where(known, values, 0.0)
    )
    return full
