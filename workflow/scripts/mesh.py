"""Mesh the real or the idealised geometry of one sample (rule `mesh`)."""

from softsample.io import read_distance, read_json, write_json, write_mesh
from softsample.meshing.hexahedral import MeshSettings
from softsample.meshing.sample import mesh_ideal, mesh_real
from softsample.workflow import logged_to, provenance

MM = 1e-3

with logged_to(snakemake.log[0]):
    keys = dict(snakemake.params.mesh)
    size = keys.pop("element_size_mm") * MM
    if snakemake.wildcards.geometry == "real":
        grid = read_distance(snakemake.input.distance, snakemake.input.segmentation)
        made = mesh_real(*grid, size, snakemake.params.preload_mm * MM, MeshSettings(**keys))
    else:
        cuboid = read_json(snakemake.input.cuboid)
        edges = (cuboid[f"{name}_mm"] * MM for name in ("length", "width", "height"))
        made = mesh_ideal(*edges, size)
    write_mesh(snakemake.output.mesh, made.mesh, made.point_data, made.cell_data)
    write_json(snakemake.output.report, {**made.report, "provenance": provenance(snakemake)})
