"""Mesh the real or the idealised geometry of one sample (rules `mesh`, `mesh_coarse`)."""

from functools import partial

from softsample import io
from softsample.meshing.surface import boundary_surface
from softsample.response.pieces import sample_mesher
from softsample.shapes import element_size
from softsample.units import MM
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    ideal = io.read_shape(files.cuboid)
    wanted = given.mesh["element_size_mm"] * MM
    size = given.coarsening * element_size(ideal, wanted, given.mesh["elements_across"])
    grid = partial(io.read_distance, files.distance, files.segmentation)
    marks = partial(io.read_marks, files.bond_mask, files.labels, files.segmentation)
    real = (lambda: (grid(), marks())) if files.distance else None
    made = sample_mesher(ideal, size, given.coarsening, real, dict(given.items()))(0.0)
    io.write_mesh(snakemake.output.mesh, made.mesh, made.point_data, made.cell_data)
    io.write_surface(snakemake.output.surface, boundary_surface(made.mesh))
    io.write_json(snakemake.output.report, {**made.report, "provenance": provenance(snakemake)})
