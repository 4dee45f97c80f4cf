"""Tables of the verdicts of all groups (rule `table_loop`)."""

from softsample.io import read_json, write_table
from softsample.report.loop import error_table, verdict_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    models = map(tuple, snakemake.params.models)
    verdicts = dict(zip(models, map(read_json, snakemake.input.verdicts), strict=True))
    write_table(snakemake.output.table, verdict_table(verdicts))
    write_table(snakemake.output.errors, error_table(verdicts))
