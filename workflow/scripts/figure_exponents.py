"""Exponents of all groups with their intervals (rule `figure_exponents`)."""

from softsample.figures.exponents import exponents_figure
from softsample.figures.style import write
from softsample.io import read_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given = snakemake.params
    figure = exponents_figure(read_table(snakemake.input.table), given.ranges, given.alpha)
    write(figure, *snakemake.output)
