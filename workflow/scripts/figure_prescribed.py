"""Figure: prescribed displacements in place of contact (rule `figure_prescribed`)."""

from softsample.figures.geometry_effects import prescribed_figure
from softsample.figures.style import write
from softsample.io import read_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, shown = snakemake.input, snakemake.params
    keys = zip(shown.samples, shown.geometries, strict=True)
    curves = dict(zip(keys, map(read_table, given.curves), strict=True))
    figure = prescribed_figure(curves, read_table(given.table))
    write(figure, *snakemake.output)
