"""Mesh the real or the idealised geometry of one sample (rules `mesh`, `mesh_coarse`)."""

from softsample.io import (
    read_distance,
    read_json,
    read_marks,
    write_json,
    write_mesh,
    write_surface,
)
from softsample.meshing.hexahedral import MeshSettings
from softsample.meshing.sample import mesh_ideal, mesh_real
from softsample.meshing.surface import boundary_surface
from softsample.shapes import IdealShape, Indenter, element_size
from softsample.workflow import logged_to, provenance

MM = 1e-3

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    ideal = IdealShape.of_report(read_json(files.cuboid))
    wanted = given.mesh["element_size_mm"] * MM
    size = given.coarsening * element_size(ideal, wanted, given.mesh["elements_across"])
    if files.distance:
        grid = read_distance(files.distance, files.segmentation)
        marks = read_marks(files.bond_mask, files.labels, files.segmentation)
        made = mesh_real(
            *grid,
            size,
            given.preload_mm * MM,
            MeshSettings.of_config(given.mesh),
            boundary_shift=given.mesh["boundary_shift_mm"] * MM,
            **marks,
        )
    else:
        indenter = given.ends if isinstance(given.ends, Indenter) else None
        made = mesh_ideal(ideal, size, indenter, given.coarsening)
    write_mesh(snakemake.output.mesh, made.mesh, made.point_data, made.cell_data)
    write_surface(snakemake.output.surface, boundary_surface(made.mesh))
    write_json(snakemake.output.report, {**made.report, "provenance": provenance(snakemake)})
