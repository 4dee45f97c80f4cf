"""Geometry of one-point hexahedra: mean gradients, hourglass shapes, lumped mass."""

from dataclasses import dataclass

import numpy as np

from softsample.arrays import Array, Mask
from softsample.errors import MeshError
from softsample.meshing.mesh import HexMesh

CORNERS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1],
     [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=np.float64
)  # fmt: skip
"""Natural coordinates of the corners in VTK order."""

_x, _y, _z = CORNERS.T
HOURGLASS = np.stack([_y * _z, _z * _x, _x * _y, _x * _y * _z])
"""The four displacement patterns that a one-point rule does not see, (4, 8)."""


@dataclass(frozen=True)
class HexGeometry:
    """What the kernels need of each element in its reference configuration.

    Parameters
    ----------
    gradient : (n, 8, 3) float64
        Element means of the shape function gradients [1/m] (uniform strain element).
    hourglass : (n, 4, 3) float64
        ``h_m . X``: part of each hourglass pattern that a linear field carries [m].
    volume : (n,) float64
        Volumes [m3], exact for trilinear elements.
    """

    gradient: Array
    hourglass: Array
    volume: Array

    @property
    def slopes(self) -> Array:
        """Gradients (n, 3, 3) of the three natural coordinates over 8 [1/m], those of the mean."""
        return np.einsum("am,nai->nmi", CORNERS, self.gradient) / 8.0

    @property
    def is_parallelepiped(self) -> Mask:
        """(n,) whether opposite faces are parallel, so that slopes say all, to 1e-9."""
        rest = self.gradient - np.einsum("am,nmi->nai", CORNERS, self.slopes)
        size = np.abs(self.gradient).max(axis=(1, 2))
        flat = np.abs(rest).max(axis=(1, 2)) <= 1e-9 * size
        return np.asarray(flat & (np.abs(self.hourglass).max(axis=(1, 2)) * size <= 1e-9))


def shape_gradients(natural: Array) -> Array:
    """Gradients (8, 3) of the trilinear shape functions at natural coordinates (3,)."""
    one = 1.0 + CORNERS * natural
    return np.stack(
        [CORNERS[:, i] * one[:, (i + 1) % 3] * one[:, (i + 2) % 3] / 8.0 for i in range(3)], axis=1
    )


def hex_geometry(mesh: HexMesh) -> HexGeometry:
    """Mean gradients, hourglass offsets and volumes of all elements.

    The two-point Gauss rule integrates them exactly, since the cofactors of a trilinear map are
    at most quadratic in each coordinate.

    Raises
    ------
    MeshError
        If an element has no positive volume.

    References
    ----------
    D. P. Flanagan, T. Belytschko, Int. J. Numer. Meth. Engng 17 (1981) 679,
    doi:10.1002/nme.1620170504.
    """
    corners = mesh.points[mesh.hexes]
    integral = np.zeros_like(corners)
    volume = np.zeros(len(corners))
    for point in CORNERS / np.sqrt(3.0):
        dN = shape_gradients(point)
        jacobian = np.einsum("nai,aj->nij", corners, dN)
        determinant = np.linalg.det(jacobian)
        integral += np.einsum("aj,nji,n->nai", dN, np.linalg.inv(jacobian), determinant)
        volume += determinant
    if volume.min() <= 0.0:
        raise MeshError(
            f"element {int(volume.argmin())} has volume {volume.min():g} m3; "
            "mesh the sample again with another mesh: element_size_mm"
        )
    gradient = integral / volume[:, None, None]
    return HexGeometry(gradient, np.einsum("ma,nai->nmi", HOURGLASS, corners), volume)


def lumped_mass(mesh: HexMesh, geometry: HexGeometry, density: float) -> Array:
    """Nodal masses (n_nodes,) [kg]: an eighth of each element to each of its corners."""
    share = np.repeat(density * geometry.volume / 8.0, 8)
    mass = np.bincount(mesh.hexes.ravel(), weights=share, minlength=len(mesh.points))
    return np.asarray(mass, dtype=np.float64)
