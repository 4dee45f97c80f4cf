"""Compare the verdicts of all groups with the sealed truth (rule `score_verdicts`)."""

from softsample.io import read_json, write_table
from softsample.scoring import verdict_score
from softsample.workflow import logged_to

with logged_to(snakemake):
    groups = snakemake.params.groups
    table = verdict_score(
        dict(zip(groups, map(read_json, snakemake.input.verdicts), strict=True)),
        dict(zip(groups, map(read_json, snakemake.input.truth), strict=True)),
    )
    write_table(snakemake.output.table, table)
