"""Surfaces and how they are seen: quads or triangles, orthographic views, outlines."""

from dataclasses import dataclass

import numpy as np
from skimage.draw import polygon
from skimage.measure import find_contours

from softsample.arrays import Array, Ids
from softsample.meshing.mesh import HexMesh
from softsample.meshing.surface import level_surface as closed_surface
from softsample.units import MM


@dataclass(frozen=True)
class Surface:
    """Closed surface for drawing, in the sample frame.

    Parameters
    ----------
    points : (n, 3) float64
        Corners [mm].
    faces : (m, 3) or (m, 4) int64
        Triangles or quads, outward by the right-hand rule.
    values : (n,) float64, optional
        Quantity to colour by.
    """

    points: Array
    faces: Ids
    values: Array | None = None


@dataclass(frozen=True)
class View:
    """Orthographic view: what points right and up on the page.

    Parameters
    ----------
    right, up : (3,) tuple of float
        Unit vectors at a right angle; the eye is on the side of `right` x `up`.
    """

    right: tuple[float, float, float]
    up: tuple[float, float, float]

    @property
    def towards_eye(self) -> Array:
        """Unit vector from the object to the eye."""
        return np.cross(self.right, self.up)

    def project(self, points: Array) -> Array:
        """Page coordinates (n, 2) of points (n, 3), same unit."""
        return np.asarray(points @ np.array([self.right, self.up]).T)

    @classmethod
    def from_angles(cls, azimuth_deg: float, elevation_deg: float) -> "View":
        """View from above the horizon; azimuth 0 sees the front (from -y), 90 the side +x."""
        a, e = np.radians([azimuth_deg, elevation_deg])
        right = (np.cos(a), np.sin(a), 0.0)
        up = (-np.sin(a) * np.sin(e), np.cos(a) * np.sin(e), np.cos(e))
        return cls(tuple(map(float, right)), tuple(map(float, up)))  # type: ignore[arg-type]


FRONT = View((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
"""Loading axis upwards, shear direction to the right."""

OBLIQUE = View.from_angles(30.0, 28.0)


def mesh_surface(
    mesh: HexMesh, displacement_mm: Array | None = None, element_values: Array | None = None
) -> Surface:
    """Boundary of a mesh, deformed if a displacement is given.

    Parameters
    ----------
    mesh
        Points [m].
    displacement_mm : (n_nodes, 3), optional
        Displacement [mm].
    element_values : (n_elements,), optional
        Quantity of the elements; nodes get the mean of the elements around them.
    """
    points = mesh.points / MM
    if displacement_mm is not None:
        points = points + displacement_mm
    values = None if element_values is None else nodal_mean(mesh, element_values)
    return Surface(points, mesh.boundary_quads, values)


def nodal_mean(mesh: HexMesh, element_values: Array) -> Array:
    """Mean (n_nodes,) over the elements around each node; NaN at nodes of no element."""
    nodes, count = mesh.hexes.ravel(), len(mesh.points)
    total = np.bincount(nodes, np.repeat(element_values, 8), minlength=count)
    return np.asarray(total / np.maximum(np.bincount(nodes, minlength=count), 1))


def level_surface(distance: Array, origin: Array, spacing: float) -> Surface:
    """Surface of a sample from its signed distance, down to the base plane z = 0.

    Parameters
    ----------
    distance : (nx, ny, nz) float64
        Signed distance [m], negative inside, walls continued below the base.
    origin : (3,) float64
        Position of voxel [0, 0, 0] in the sample frame [m].
    spacing : float
        Grid spacing [m].

    Returns
    -------
    Surface
        Triangles.
    """
    found = closed_surface(distance, origin, spacing)
    return Surface(found.points / MM, found.triangles)


def above_base(distance: Array, origin: Array, spacing: float) -> Array:
    """`distance` with the half-space below the base plane z = 0 cut off."""
    z = origin[2] + spacing * np.arange(distance.shape[2])
    return np.maximum(distance, -z)


def silhouette(surface: Surface, view: View, resolution_mm: float = 0.1) -> Array:
    """Outline (k, 2) of a surface as seen on the page [mm]: the longest contour of its shadow."""
    page = view.project(surface.points)
    low = page.min(axis=0) - 3.0 * resolution_mm
    shape = np.ceil((page.max(axis=0) - low) / resolution_mm).astype(int) + 4
    shadow = np.zeros(shape)
    for corners in ((page - low) / resolution_mm)[surface.faces]:
        shadow[polygon(corners[:, 0], corners[:, 1], shape)] = 1.0
    outline = max(find_contours(shadow, 0.5), key=len)
    return np.asarray(low + resolution_mm * outline)
