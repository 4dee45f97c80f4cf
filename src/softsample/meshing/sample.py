"""The mesh of one sample, real or idealised, with what its file and its report hold."""

from dataclasses import dataclass
from time import process_time

import numpy as np
from numpy.typing import NDArray

from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.hexahedral import MeshSettings, mesh_solid
from softsample.meshing.levelset import LevelSet
from softsample.meshing.mesh import HexMesh
from softsample.meshing.quality import quality_report, scaled_jacobian


@dataclass(frozen=True, eq=False)
class SampleMesh:
    """A mesh, its fields and its quality report (millimetres, as in the files)."""

    mesh: HexMesh
    point_data: dict[str, NDArray[np.uint8]]
    cell_data: dict[str, NDArray[np.float64]]
    report: dict[str, float | int]


def mesh_real(
    distance: NDArray[np.float64],
    origin: NDArray[np.float64],
    spacing: float,
    element_size: float,
    preload: float,
    settings: MeshSettings | None = None,
) -> SampleMesh:
    """Mesh a segmented sample; parameters as of `mesh_solid`.

    `preload` [m] is the way of the platen below the highest point that decides which nodes are
    glued (flag ``glued``; flag ``bottom`` marks the base).

    Raises
    ------
    MeshError
        If no valid mesh comes out; the message names the cure.
    """
    start = process_time()
    mesh = mesh_solid(distance, origin, spacing, element_size, settings)
    seconds = process_time() - start
    surface = LevelSet(distance, origin, spacing)
    report = quality_report(mesh, element_size, surface.volume, surface)
    return _with_fields(mesh, preload, report, seconds)


def mesh_ideal(length: float, width: float, height: float, element_size: float) -> SampleMesh:
    """Mesh the idealised cuboid; parameters as of `mesh_cuboid`, glued is the top face."""
    start = process_time()
    mesh = mesh_cuboid(length, width, height, element_size)
    seconds = process_time() - start
    report = quality_report(mesh, element_size, length * width * height)
    return _with_fields(mesh, 0.0, report, seconds)


def _with_fields(
    mesh: HexMesh, depth: float, report: dict[str, float | int], seconds: float
) -> SampleMesh:
    """Add the node flags, the element quality and the CPU seconds of the meshing."""
    flags = {"bottom": mesh.bottom, "glued": mesh.glued(depth)}
    nodes = np.arange(len(mesh.points))
    return SampleMesh(
        mesh,
        {name: np.isin(nodes, ids).astype(np.uint8) for name, ids in flags.items()},
        {"scaled_jacobian": scaled_jacobian(mesh)},
        {**report, "cpu_s": round(seconds, 2)},
    )
