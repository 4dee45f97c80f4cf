"""Figure 7: deformed samples with their largest principal strain (rule `figure7`)."""

from softsample.figures.render import available_renderer
from softsample.figures.strain import StrainRow, strain_figure
from softsample.figures.style import write
from softsample.figures.surface import level_surface
from softsample.io import read_distance, read_json, read_mesh_with_data
from softsample.validation import resolved
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, shown = snakemake.input, snakemake.params
    distances = map(read_distance, given.distances, given.segmentations)
    surfaces = {name: level_surface(*d) for name, d in zip(shown.real, distances, strict=True)}
    fields = {
        geometry: dict(zip(names, map(read_mesh_with_data, given[geometry]), strict=True))
        for geometry, names in (("real", shown.real), ("ideal", shown.samples))
    }
    runs = [{g: of[n] for g, of in fields.items() if n in of} for n in shown.samples]
    travels = [read_json(path)["travel_mm"] for path in given.runs]
    heights = [read_json(path)["height_mm"] for path in given.cuboids]
    rows = [
        StrainRow.of({"sample": name, **resolved(row)}, surfaces.get(name), *own)
        for name, row, *own in zip(shown.samples, shown.rows, runs, travels, heights, strict=True)
    ]
    write(strain_figure(rows, available_renderer()), *snakemake.output)
