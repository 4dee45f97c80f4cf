"""Strain fields of a deformed mesh."""

import numpy as np
from numpy.typing import NDArray

from softsample.fem.element import hex_geometry
from softsample.meshing.mesh import HexMesh

Array = NDArray[np.float64]


def deformation_gradients(mesh: HexMesh, displacement: Array) -> Array:
    """Element means of F (n_elements, 3, 3) for nodal displacements (n_nodes, 3) [m]."""
    gradient = hex_geometry(mesh).gradient
    return np.eye(3) + np.einsum("nai,naj->nij", displacement[mesh.hexes], gradient)


def max_principal_hencky_strain(mesh: HexMesh, displacement: Array) -> Array:
    """Largest principal logarithmic strain ln(lambda_max) of each element (n_elements,)."""
    F = deformation_gradients(mesh, displacement)
    return np.asarray(0.5 * np.log(np.linalg.eigvalsh(np.swapaxes(F, 1, 2) @ F)[:, -1]))
