"""Means and deviations of bias and areas beside the paper's (rule `table_summary`)."""

from softsample.io import read_table, write_table
from softsample.report.tables import summary_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, paper = snakemake.input, snakemake.input.paper
    moduli = {
        model: read_table(name)
        for model, name in zip(snakemake.params.models, given.moduli, strict=True)
    }
    table = summary_table(moduli, read_table(given.geometry), read_table(paper) if paper else None)
    write_table(snakemake.output.table, table)
