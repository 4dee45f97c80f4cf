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
from softsample.shapes import IdealShape, element_size
from softsample.workflow import logged_to, provenance

MM = 1e-3

with logged_to(snakemake):
    files, keys = snakemake.input, dict(snakemake.params.mesh)
    ideal = IdealShape.of_report(read_json(files.cuboid))
    wanted, across = keys.pop("element_size_mm") * MM, keys.pop("elements_across")
    size = snakemake.params.coarsening * element_size(ideal, wanted, across)
    shift = keys.pop("boundary_shift_mm") * MM
    if files.distance:
        grid = read_distance(files.distance, files.segmentation)
        marks = read_marks(files.bond_mask, files.labels, files.segmentation)
        preload = snakemake.params.preload_mm * MM
        made = mesh_real(*grid, size, preload, MeshSettings(**keys), boundary_shift=shift, **marks)
    else:
        made = mesh_ideal(ideal, size)
    write_mesh(snakemake.output.mesh, made.mesh, made.point_data, made.cell_data)
    write_surface(snakemake.output.surface, boundary_surface(made.mesh))
    write_json(snakemake.output.report, {**made.report, "provenance": provenance(snakemake)})
