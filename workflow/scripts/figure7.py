"""Figure 7: deformed samples with their largest principal strain (rule `figure7`)."""

from softsample.figures.render import available_renderer
from softsample.figures.strain import Deformed, StrainRow, strain_figure
from softsample.figures.style import save
from softsample.figures.surface import level_surface
from softsample.io import read_distance, read_json, read_mesh_with_data, written_aside
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, shown, rows = snakemake.input, snakemake.params, []
    distances = zip(given.distances, given.segmentations, strict=True)
    surfaces = dict(zip(shown.real, distances, strict=True))
    meshes = {
        "real": dict(zip(shown.real, given.real, strict=True)),
        "ideal": dict(zip(shown.samples, given.ideal, strict=True)),
    }
    for at, (sample, mode) in enumerate(zip(shown.samples, shown.modes, strict=True)):
        shapes = {}
        for geometry, files in meshes.items():
            if sample in files:
                mesh, points, cells = read_mesh_with_data(files[sample])
                run = points["displacement_mm"], cells["max_principal_hencky_strain"]
                shapes[geometry] = Deformed.of_run(mesh, *run)
        travel = read_json(given.runs[at])["travel_mm"]
        rows.append(
            StrainRow(
                sample,
                mode,
                travel / read_json(given.cuboids[at])["height_mm"],
                level_surface(*read_distance(*surfaces[sample])) if sample in surfaces else None,
                shapes,
                "MRI" if sample in shown.imaged else "surface",
            )
        )
    title = f"Deformed samples at the calibrated moduli, {shown.cohort}"
    figure = strain_figure(rows, title, available_renderer())
    for path in snakemake.output:
        with written_aside(path) as aside:
            save(figure, aside)
