"""Mesh the real or the idealised geometry of one sample (rule `mesh`)."""

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
from softsample.workflow import logged_to, provenance

MM = 1e-3

with logged_to(snakemake):
    keys = dict(snakemake.params.mesh)
    size = keys.pop("element_size_mm") * MM
    shift = keys.pop("boundary_shift_mm") * MM
    if snakemake.wildcards.geometry == "real":
        grid = read_distance(snakemake.input.distance, snakemake.input.segmentation)
        marks = read_marks(
            snakemake.input.bond_mask, snakemake.input.labels, snakemake.input.segmentation
        )
        preload = snakemake.params.preload_mm * MM
        made = mesh_real(*grid, size, preload, MeshSettings(**keys), boundary_shift=shift, **marks)
    else:
        cuboid = read_json(snakemake.input.cuboid)
        edges = (cuboid[f"{name}_mm"] * MM for name in ("length", "width", "height"))
        made = mesh_ideal(*edges, size)
    write_mesh(snakemake.output.mesh, made.mesh, made.point_data, made.cell_data)
    write_surface(snakemake.output.surface, boundary_surface(made.mesh))
    write_json(snakemake.output.report, {**made.report, "provenance": provenance(snakemake)})
