"""Figure 7: deformed samples with their largest principal strain (rule `figure7`)."""

from softsample.figures.render import available_renderer
from softsample.figures.strain import Deformed, StrainRow, strain_figure
from softsample.figures.style import save
from softsample.figures.surface import level_surface
from softsample.io import read_distance, read_json, read_mesh_with_data, written_aside
from softsample.shapes import Indenter
from softsample.validation import resolved
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, shown, rows = snakemake.input, snakemake.params, []
    distances = zip(given.distances, given.segmentations, strict=True)
    surfaces = dict(zip(shown.real, distances, strict=True))
    meshes = {
        "real": dict(zip(shown.real, given.real, strict=True)),
        "ideal": dict(zip(shown.samples, given.ideal, strict=True)),
    }
    for at, (sample, row) in enumerate(zip(shown.samples, shown.rows, strict=True)):
        indenter = Indenter.of_row(resolved(row))
        shapes = {}
        for geometry, files in meshes.items():
            if sample in files:
                mesh, points, cells = read_mesh_with_data(files[sample])
                run = points["displacement_mm"], cells["max_principal_hencky_strain"]
                shapes[geometry] = Deformed.of_run(mesh, *run, cut=indenter is not None)
        travel = read_json(given.runs[at])["travel_mm"]
        height = read_json(given.cuboids[at])["height_mm"]
        rows.append(
            StrainRow(
                sample,
                row["mode"],
                travel / height,
                level_surface(*read_distance(*surfaces[sample])) if sample in surfaces else None,
                shapes,
                indenter,
                height - travel,
            )
        )
    figure = strain_figure(rows, available_renderer())
    for path in snakemake.output:
        with written_aside(path) as aside:
            save(figure, aside)
