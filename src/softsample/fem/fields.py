"""Strain and contact on a deformed mesh."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsample.arrays import Array
from softsample.fem.element import hex_geometry
from softsample.fem.motion import PLATEN
from softsample.meshing.mesh import HexMesh, face_vectors

FLAT = np.cos(np.radians(30.0))
"""Faces that are held in part count as touching while they are this flat to the platen."""

CONTACT = ("contact_area_m2", "mean_contact_pressure_pa", "max_contact_pressure_pa")
"""Numbers of a contact report."""


@dataclass(frozen=True)
class Snapshot:
    """State of a run at one instant.

    Parameters
    ----------
    travel : float
        Travel of the moving platen along its direction [m].
    displacement : (n_nodes, 3) float64
        Nodal displacements [m].
    held : (n_nodes,) int8
        What holds each node (FREE, BASE, PLATEN).
    contact_force : (n_nodes, 3) float64
        Force of the moving platen on each node [N], of the time step that led here.
    """

    travel: float
    displacement: Array
    held: NDArray[np.int8]
    contact_force: Array


def deformation_gradients(mesh: HexMesh, displacement: Array) -> Array:
    """Element means of F (n_elements, 3, 3) for nodal displacements (n_nodes, 3) [m]."""
    gradient = hex_geometry(mesh).gradient
    return np.eye(3) + np.einsum("nai,naj->nij", displacement[mesh.hexes], gradient)


def principal_hencky_strains(mesh: HexMesh, displacement: Array) -> Array:
    """Principal logarithmic strains ln(lambda) of each element (n_elements, 3), ascending."""
    F = deformation_gradients(mesh, displacement)
    return np.asarray(0.5 * np.log(np.linalg.eigvalsh(np.swapaxes(F, 1, 2) @ F)))


def contact_report(mesh: HexMesh, snapshot: Snapshot) -> dict[str, float]:
    """Area and pressure of contact with the moving platen.

    Each corner of a deformed boundary face stands for a quarter of the face's area, projected on
    the platen; those of nodes that the platen holds are summed. A face with free corners counts
    only while its normal is within 30 degrees of the platen's, so that walls below the edge of a
    flat top do not. Where contact ends within a face, the area is known to half that face.

    Returns
    -------
    dict
        `contact_area_m2`; `mean_contact_pressure_pa`, total normal force over area;
        `max_contact_pressure_pa`, the largest nodal normal force over the node's part of the
        area. Pressure is positive, pull is negative; all are zero without contact.
    """
    area = _touching_area(mesh, snapshot)
    touching = area > 0.0
    if not touching.any():
        return {name: 0.0 for name in CONTACT}
    pressing = -snapshot.contact_force[:, 2]
    total = area.sum()
    values = (total, pressing.sum() / total, np.max(pressing[touching] / area[touching]))
    return {name: float(value) for name, value in zip(CONTACT, values, strict=True)}


def _touching_area(mesh: HexMesh, snapshot: Snapshot) -> Array:
    """Part of the contact area that belongs to each node (n_nodes,) [m2]."""
    quads = mesh.boundary_quads
    normal = face_vectors(mesh.points + snapshot.displacement, quads)
    held = snapshot.held[quads] == PLATEN
    flat = normal[:, 2] > FLAT * np.linalg.norm(normal, axis=1)
    projected = np.where(flat | held.all(axis=1), np.maximum(normal[:, 2], 0.0), 0.0)
    share = 0.25 * projected[:, None] * held
    sums = np.bincount(quads.ravel(), weights=share.ravel(), minlength=len(mesh.points))
    return np.asarray(sums, dtype=np.float64)
