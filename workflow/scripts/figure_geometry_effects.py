"""Figure: bias of every experiment on the shape (rule `figure_geometry_effects`)."""

from softsample.figures.geometry_effects import effects_figure
from softsample.figures.style import write
from softsample.io import read_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    tables = (read_table(path) for path in (snakemake.input.effects, snakemake.input.needed))
    figure = effects_figure(*tables)
    write(figure, *snakemake.output)
