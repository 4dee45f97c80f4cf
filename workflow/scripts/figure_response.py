"""Record and calibrated model of one sample (rule `figure_response`)."""

from softsample.figures.response import response_figure
from softsample.figures.style import write
from softsample.io import read_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    sample, shown = snakemake.wildcards.sample, snakemake.params
    tables = map(read_table, snakemake.input.curves)
    curves = {
        geometry: table[table["sample"] == sample]
        for geometry, table in zip(shown.geometries, tables, strict=True)
    }
    figure = response_figure(curves, shown.mode, shown.ideal)
    write(figure, snakemake.output.png)
