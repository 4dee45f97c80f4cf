"""What holds the sample: the glued base, a glued or a touching moving platen."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsample.fem.kernels import BASE, FREE, PLATEN
from softsample.meshing.mesh import HexMesh
from softsample.protocol import DIRECTIONS


@dataclass(frozen=True)
class ContactSettings:
    """Rules of contact with the rigid, rough (no-slip) platens; mirrors config `contact:`.

    Parameters
    ----------
    release : bool
        Whether a node lets go of a platen that would have to pull on it.
    side_walls : bool
        Whether nodes of the side walls can touch the moving platen; if not, only nodes of
        faces that look up (normal z above 0.2) can.
    base_platen : bool
        Whether nodes of the side walls can fold onto the base platen.
    """

    release: bool = True
    side_walls: bool = True
    base_platen: bool = True


@dataclass(frozen=True)
class Boundary:
    """Boundary conditions of one test.

    Parameters
    ----------
    held : (n_nodes,) int8
        FREE, BASE or PLATEN at the start.
    candidates : (m,) int32
        Free nodes that may touch a platen.
    planes : (2, 4) float64
        Base and moving platen: unit normal from the sample into the platen, offset [m].
    direction : (3,) float64
        Unit vector of the moving platen's travel.
    release : bool
        Whether touching nodes can let go.
    """

    held: NDArray[np.int8]
    candidates: NDArray[np.int32]
    planes: NDArray[np.float64]
    direction: NDArray[np.float64]
    release: bool = False

    @property
    def glued(self) -> NDArray[np.int32]:
        """Nodes held from the start."""
        return np.flatnonzero(self.held != FREE).astype(np.int32)


def _held(mesh: HexMesh, glued: NDArray[np.int64]) -> NDArray[np.int8]:
    held = np.full(len(mesh.points), FREE, dtype=np.int8)
    held[glued] = PLATEN
    held[mesh.bottom] = BASE
    return held


def mode_boundary(
    mesh: HexMesh, mode: str, glued: NDArray[np.int64], contact: ContactSettings
) -> Boundary:
    """Boundary conditions of a test mode: glued top, or a platen that meets the highest node."""
    if mode == "compression":
        return platen_boundary(mesh, contact)
    return glued_boundary(mesh, mode, glued)


def glued_boundary(mesh: HexMesh, mode: str, glued: NDArray[np.int64]) -> Boundary:
    """Base fixed, `glued` nodes moved rigidly: tension and shear tests."""
    nowhere = np.array([[0.0, 0.0, -1.0, np.inf], [0.0, 0.0, 1.0, np.inf]])
    return Boundary(
        _held(mesh, glued),
        np.empty(0, dtype=np.int32),
        nowhere,
        np.array(DIRECTIONS[mode]),
    )


def platen_boundary(
    mesh: HexMesh, contact: ContactSettings, start: float | None = None
) -> Boundary:
    """Base fixed, a rigid flat platen coming down from height `start` [m]: compression tests.

    By default the platen starts at the highest node. Nodes it starts on stick from the first step.
    """
    start = mesh.highest if start is None else start
    held = _held(mesh, np.empty(0, dtype=np.int64))
    touchable = mesh.boundary if contact.side_walls else _upward_nodes(mesh)
    candidates = touchable[held[touchable] == FREE].astype(np.int32)
    base_offset = 0.0 if contact.base_platen else np.inf
    planes = np.array([[0.0, 0.0, -1.0, base_offset], [0.0, 0.0, 1.0, start]])
    return Boundary(held, candidates, planes, np.array(DIRECTIONS["compression"]), contact.release)


def _upward_nodes(mesh: HexMesh, cosine: float = 0.2) -> NDArray[np.int64]:
    """Nodes of boundary faces whose unit normal has a z component above `cosine`."""
    corners = mesh.points[mesh.boundary_quads]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    up = normal[:, 2] > cosine * np.linalg.norm(normal, axis=1)
    return np.unique(mesh.boundary_quads[up])
