"""Response of the first term alone, out of that of both (rule `one_term`)."""

from softsample.io import read_json, read_table, write_json, write_table
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    curves, report = read_table(snakemake.input.curves), read_json(snakemake.input.report)
    alone = curves[curves["mu1_fraction"] == 1.0]
    runs = [run for run in report["runs"] if run["mu1_fraction"] == 1.0]
    write_table(snakemake.output.curves, alone)
    found = {**report, "runs": runs, "provenance": provenance(snakemake)}
    write_json(snakemake.output.report, found)
