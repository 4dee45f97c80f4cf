"""Figure 4: nominal stress against nominal strain (rule `figure4`)."""

from softsample.figures.stress import stress_strain_figure
from softsample.figures.style import save
from softsample.io import read_table, written_aside
from softsample.workflow import logged_to

with logged_to(snakemake):
    figure = stress_strain_figure(read_table(snakemake.input.table))
    for path in snakemake.output:
        with written_aside(path) as aside:
            save(figure, aside)
