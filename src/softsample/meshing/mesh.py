"""The hexahedral mesh that the mesher makes and the solver moves."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from softsample.arrays import Array, Ids

EDGES = np.array(
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]]
)
"""Corners at the ends of the twelve edges of a hexahedron in VTK order."""

FACES = np.array(
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
)
"""Corners of the six faces of a hexahedron in VTK order, outward by the right-hand rule."""

CORNERS = np.array(
    [
        [0, 1, 3, 4], [1, 2, 0, 5], [2, 3, 1, 6], [3, 0, 2, 7],
        [4, 7, 5, 0], [5, 4, 6, 1], [6, 5, 7, 2], [7, 6, 4, 3],
    ]
)  # fmt: skip
"""Each corner of a hexahedron in VTK order with its three neighbours, right-handed."""


def face_vectors(points: Array, quads: Ids) -> Array:
    """(n, 3) normals times area of the faces `quads` (n, 4) between `points` (n_nodes, 3)."""
    a, b, c, d = points[quads].transpose(1, 0, 2)
    return np.asarray(0.5 * np.cross(c - a, d - b))


@dataclass(frozen=True)
class HexMesh:
    """Eight-node hexahedra in the sample frame.

    Parameters
    ----------
    points : (n_nodes, 3) float64
        Node positions [m], base plane at z = 0, loading axis +z.
    hexes : (n_elements, 8) int64
        Corner nodes in VTK order (four of the lower face counter-clockwise seen from inside,
        then the four above them).
    """

    points: Array
    hexes: Ids

    @cached_property
    def _boundary_faces(self) -> Ids:
        """(n_quads,) faces that belong to one element only, counted element by element."""
        quads = np.sort(self.hexes[:, FACES].reshape(-1, 4), axis=1)
        _, first, count = np.unique(quads, axis=0, return_index=True, return_counts=True)
        return np.sort(first[count == 1])

    @cached_property
    def boundary_quads(self) -> Ids:
        """(n_quads, 4) those faces, normals outward."""
        return self.hexes[:, FACES].reshape(-1, 4)[self._boundary_faces]

    @property
    def boundary_owners(self) -> Ids:
        """(n_quads,) element that each of `boundary_quads` belongs to."""
        return self._boundary_faces // len(FACES)

    def quads_among(self, nodes: Ids) -> Ids:
        """(n_quads, 4) places of the corners of `boundary_quads` in `nodes` (n,), -1 for others."""
        place = np.full(len(self.points), -1)
        place[nodes] = np.arange(len(nodes))
        return place[self.boundary_quads]

    @cached_property
    def boundary(self) -> Ids:
        """Sorted ids of the nodes on the surface."""
        return np.unique(self.boundary_quads)

    @cached_property
    def edge_length(self) -> float:
        """Typical element edge [m]: that of cubes with the elements' median diagonal."""
        corners = self.points[self.hexes]
        diagonal = np.linalg.norm(corners[:, 6] - corners[:, 0], axis=1)
        return float(np.median(diagonal) / np.sqrt(3.0))

    @cached_property
    def bottom(self) -> Ids:
        """Sorted ids of the nodes on the base plane z = 0 (glued to the fixed platen)."""
        tolerance = 1e-6 * self.edge_length
        return self.boundary[np.abs(self.points[self.boundary, 2]) <= tolerance]

    @cached_property
    def highest(self) -> float:
        """Height of the highest node above the base plane [m]."""
        return float(self.points[:, 2].max())

    def glued(self, depth: float) -> Ids:
        """Sorted ids of surface nodes that a platen touches when lowered by `depth` [m].

        The pre-load rule of the protocol: the platen goes `depth` below the highest point and
        glues what it meets, side nodes included; no deformation is considered.
        """
        # ASSUME: the pre-load bonds what it would pass if the sample did not yield; `bond: rule:
        # contact` simulates it. The paper found the nodes in its videos.
        height = self.points[self.boundary, 2]
        return self.boundary[height >= self.highest - depth - 1e-6 * self.edge_length]
