"""Record and calibrated model of one sample (rule `figure_response`)."""

from softsample.figures.response import response_figure
from softsample.figures.style import save
from softsample.io import read_table, written_aside
from softsample.workflow import logged_to

with logged_to(snakemake):
    sample, shown = snakemake.wildcards.sample, snakemake.params
    tables = {geometry: read_table(snakemake.input[geometry]) for geometry in ("real", "ideal")}
    curves = {name: table[table["sample"] == sample] for name, table in tables.items()}
    figure = response_figure(curves, shown.mode, f"Sample {sample}, {shown.mode}, {shown.cohort}")
    with written_aside(snakemake.output.png) as aside:
        save(figure, aside)
