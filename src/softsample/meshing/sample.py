"""The mesh of one sample, real or idealised, with what its file and its report hold."""

from dataclasses import dataclass
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsample.arrays import Array, Ids
from softsample.meshing.bond import bonded_nodes
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.cylinder import mesh_cylinder
from softsample.meshing.graded import graded_hexes
from softsample.meshing.hexahedral import mesh_solid
from softsample.meshing.levelset import LevelSet
from softsample.meshing.marks import MarkedImage
from softsample.meshing.mesh import HexMesh
from softsample.meshing.quality import quality_report, scaled_jacobian
from softsample.meshing.regions import element_regions
from softsample.shapes import ALONG_RADIUS, IdealShape, Indenter

REACH = 0.6
"""Radius of contact with a ball, in radii of it, up to which elements are fine."""

LEAST_ACROSS = 8
"""Elements along the shortest extent of an indented sample, at least, away from the indenter."""


@dataclass(frozen=True, eq=False)
class SampleMesh:
    """A mesh, its fields and its quality report (millimetres, as in the files)."""

    mesh: HexMesh
    point_data: dict[str, NDArray[np.uint8]]
    cell_data: dict[str, NDArray[Any]]
    report: dict[str, float | int]


def mesh_real(
    distance: Array,
    origin: Array,
    spacing: float,
    element_size: float,
    preload: float,
    *,
    boundary_shift: float | Array = 0.0,
    bond_mask: MarkedImage | None = None,
    labels: MarkedImage | None = None,
) -> SampleMesh:
    """Mesh a segmented sample.

    Parameters
    ----------
    distance, origin, spacing, element_size
        As of `mesh_solid`.
    preload : float
        Way [m] of the platen below the highest point that decides which nodes are glued.
    boundary_shift : float or array of the shape of `distance`
        The surface is moved outward by this along its normal [m], inward if negative; the base
        stays the plane z = 0.
    bond_mask : MarkedImage, optional
        Not zero where the top surface is glued, in place of the pre-load rule.
    labels : MarkedImage, optional
        Regions of different stiffness.

    Returns
    -------
    SampleMesh
        With the node flags ``bottom`` and ``glued`` and, if there are labels, the element data
        ``region``.

    Raises
    ------
    MeshError
        If no valid mesh comes out; the message names the cure.
    InputError
        If an image marks nothing of the sample.
    """
    start = process_time()
    distance = distance - boundary_shift
    mesh = mesh_solid(distance, origin, spacing, element_size)
    seconds = process_time() - start
    surface = LevelSet(distance, origin, spacing)
    report = quality_report(mesh, element_size, surface.volume, surface)
    glued = bonded_nodes(mesh, bond_mask) if bond_mask else mesh.glued(preload)
    regions = {"region": element_regions(mesh, labels)} if labels else {}
    return _with_fields(mesh, glued, report, seconds, regions)


def mesh_ideal(
    shape: IdealShape, element_size: float, indenter: Indenter | None = None, coarser: float = 1.0
) -> SampleMesh:
    """Mesh an idealised sample; glued is its top face.

    Parameters
    ----------
    element_size : float
        Wanted edge of the elements [m].
    indenter : Indenter, optional
        What the sample is indented with; elements are finer below it.
    coarser : float
        What the wanted edge is of that of the study's mesh, which has `ALONG_RADIUS` elements
        along the radius of the indenter.

    Raises
    ------
    MeshError
        If the shape is too small for such elements, or for the indenter.
    """
    start = process_time()
    mesh = ideal_hexes(shape, element_size, indenter, coarser)
    seconds = process_time() - start
    report = quality_report(mesh, element_size, shape.volume)
    return _with_fields(mesh, mesh.glued(0.0), report, seconds)


def indented_hexes(
    shape: IdealShape, element_size: float, indenter: Indenter, coarser: float = 1.0
) -> HexMesh:
    """Hexahedra that are fine below an indenter; parameters and errors as of `mesh_ideal`.

    They are fine as far as a ball may reach, or up to the edge of a punch: its outermost nodes
    stand for half an element beyond them.
    """
    fine = min(element_size, coarser * indenter.radius / ALONG_RADIUS)
    near = REACH * indenter.radius if indenter.kind == "sphere" else indenter.radius - 0.5 * fine
    coarse = max(element_size, shape.smallest / LEAST_ACROSS)
    return graded_hexes(shape, fine, near, coarse)


def ideal_hexes(
    shape: IdealShape, element_size: float, indenter: Indenter | None = None, coarser: float = 1.0
) -> HexMesh:
    """Hexahedra of an idealised sample; parameters and errors as of `mesh_ideal`."""
    if indenter:
        return indented_hexes(shape, element_size, indenter, coarser)
    if shape.kind == "cylinder":
        return mesh_cylinder(shape.length, shape.height, element_size)
    return mesh_cuboid(shape.length, shape.width, shape.height, element_size)


def _with_fields(
    mesh: HexMesh,
    glued: Ids,
    report: dict[str, float | int],
    seconds: float,
    regions: dict[str, Ids] | None = None,
) -> SampleMesh:
    """Add the node flags, the element quality and the CPU seconds of the meshing."""
    flags = {"bottom": mesh.bottom, "glued": glued}
    nodes = np.arange(len(mesh.points))
    return SampleMesh(
        mesh,
        {name: np.isin(nodes, ids).astype(np.uint8) for name, ids in flags.items()},
        {"scaled_jacobian": scaled_jacobian(mesh), **(regions or {})},
        {**report, "cpu_s": round(seconds, 2)},
    )
