"""Figure 4: nominal stress against nominal strain (rule `figure4`)."""

from softsample.figures.stress import stress_strain_figure
from softsample.figures.style import write
from softsample.io import read_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    figure = stress_strain_figure(read_table(snakemake.input.table))
    write(figure, *snakemake.output)
