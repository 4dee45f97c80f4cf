"""A sample and its cuboid with features of the shape switched on and off, as maps of their nodes.

Three features tell a real sample from its cuboid: the relief of the top (late contact, or glue that
holds a part only), the areas of its sections (a top smaller than the base), and the outline of
the sections. `docs/geometry_effects.md` has the definitions.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from scipy.interpolate import RBFInterpolator

from softsample.arrays import Array, Ids
from softsample.errors import MeshError
from softsample.meshing.bond import top_quads
from softsample.meshing.mesh import HexMesh
from softsample.meshing.sample import mesh_ideal, mesh_real
from softsample.shapes import IdealShape, element_size
from softsample.units import MM

HeightMap = Callable[[Array], Array]
"""Heights (n,) [m] at places (n, 2) [m]."""

PROFILE = 201
"""Heights at which the sections of a sample are measured."""


def section_areas(mesh: HexMesh, heights: Array) -> Array:
    """Areas (n,) [m2] of the sections of a mesh just below `heights` (n,) [m].

    A section is the projection of the closed surface above it: triangles are cut by its plane.
    """
    quads = mesh.boundary_quads
    triangles = mesh.points[np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    low, middle, high = np.sort(triangles[:, :, 2], axis=1).T
    areas = []
    for height in np.atleast_1d(heights) - 1e-6 * mesh.highest:
        with np.errstate(divide="ignore", invalid="ignore"):
            upper = (high - height) ** 2 / ((high - low) * (high - middle))
            lower = 1.0 - (height - low) ** 2 / ((middle - low) * (high - low))
        above = np.select([height < low, height < middle, height < high], [1.0, lower, upper])
        areas.append(0.5 * float(above @ normal[:, 2]))
    return np.array(areas)


@dataclass(frozen=True, eq=False)
class Shape:
    """A real sample beside its cuboid.

    Parameters
    ----------
    real, cuboid : HexMesh
        Their meshes; that of a round sample's cylinder stands in the place of the cuboid's.
    ideal : IdealShape
        The cuboid, or the cylinder.
    normal_deg : float
        The top is the surface within this angle of vertical in the upper half [degrees].
    """

    real: HexMesh
    cuboid: HexMesh
    ideal: IdealShape
    normal_deg: float

    @classmethod
    def of(
        cls,
        distance: tuple[Array, Array, float],
        ideal: IdealShape,
        mesh: Mapping[str, Any],
        element_size_mm: float,
        preload: float,
        normal_deg: float,
    ) -> Self:
        """From a segmented sample.

        Parameters
        ----------
        distance : tuple
            As `softsample.io.read_distance` returns it.
        mesh : mapping
            Section `mesh` of the config.
        element_size_mm : float
            Edge of the elements [mm], where the study's mesh has its own; as much coarser where
            that mesh is finer or coarser for the size of the sample.
        preload : float
            Depth of the glue [m].
        normal_deg : float
            As of the class.
        """
        usual = mesh["element_size_mm"]
        own = element_size(ideal, MM * usual, mesh["elements_across"])
        size = element_size_mm / usual * own
        shift = MM * mesh["boundary_shift_mm"]
        real = mesh_real(*distance, size, preload, boundary_shift=shift)
        return cls(real.mesh, mesh_ideal(ideal, size).mesh, ideal, normal_deg)

    @cached_property
    def top(self) -> Ids:
        """Sorted ids of the nodes of the real sample's top."""
        nodes = np.unique(top_quads(self.real, self.normal_deg))
        if len(nodes) < 4:
            raise MeshError(
                f"the top has {len(nodes)} nodes within {self.normal_deg:g} degrees of vertical: "
                "look at the mesh, or raise measurement: top_normal_deg"
            )
        return nodes

    @cached_property
    def relief(self) -> HeightMap:
        """Height of the real top over any place: the thin-plate spline through its nodes.

        J. Duchon, in: Constructive theory of functions of several variables, Lecture Notes in
        Mathematics 571 (1977) 85, doi:10.1007/BFb0086566.
        """
        nodes = self.real.points[self.top]
        spline = RBFInterpolator(MM**-1 * nodes[:, :2], nodes[:, 2], kernel="thin_plate_spline")
        return lambda at: np.asarray(spline(MM**-1 * at))

    @cached_property
    def plane(self) -> HeightMap:
        """Plane through the real top (least squares over its nodes): the tilt of the relief."""
        places, heights = self.real.points[self.top, :2], self.real.points[self.top, 2]
        columns = np.column_stack([places, np.ones(len(places))])
        slopes = np.linalg.lstsq(columns, heights, rcond=None)[0]
        return lambda at: np.asarray(at @ slopes[:2] + slopes[2])

    def flat(self, at: Array) -> Array:
        """Height of the cuboid's top."""
        return np.full(len(at), self.ideal.height)

    def scaled_relief(self, factor: float) -> HeightMap:
        """The relief with its deviations from the cuboid's height multiplied."""
        return lambda at: self.ideal.height + factor * (self.relief(at) - self.ideal.height)

    def without_tilt(self, at: Array) -> Array:
        """The relief about its plane, at the cuboid's height."""
        return self.ideal.height + self.relief(at) - self.plane(at)

    def tilt_alone(self, at: Array) -> Array:
        """The plane, at the cuboid's height in the mean over the top."""
        mean = self.plane(self.real.points[self.top, :2]).mean()
        return self.ideal.height + self.plane(at) - mean

    @cached_property
    def levelled(self) -> HexMesh:
        """The real sample with its whole top at the cuboid's height."""
        points = stretched(self.real, self.relief, self.flat).points
        points[:, 2] = np.minimum(points[:, 2], self.ideal.height)
        return HexMesh(points, self.real.hexes)

    @cached_property
    def tapered(self) -> HexMesh:
        """The cuboid with sections as large as those of the levelled sample."""
        points = self.cuboid.points.copy()
        levels = np.linspace(0.0, self.ideal.height, PROFILE)[1:]
        ratio = section_areas(self.levelled, levels) / self.ideal.area
        points[:, :2] *= np.sqrt(np.interp(points[:, 2], levels, ratio))[:, None]
        return HexMesh(points, self.cuboid.hexes)

    @property
    def cuboid_with_relief(self) -> HexMesh:
        """The cuboid with the relief of the real top."""
        return stretched(self.cuboid, self.flat, self.relief)

    def with_top(self, heights: HeightMap) -> HexMesh:
        """The real sample with another relief."""
        return stretched(self.real, self.relief, heights)


def stretched(mesh: HexMesh, old: HeightMap, new: HeightMap) -> HexMesh:
    """A mesh whose columns are stretched from one height of the top to another."""
    points = mesh.points.copy()
    points[:, 2] *= new(points[:, :2]) / old(points[:, :2])
    return HexMesh(points, mesh.hexes)
