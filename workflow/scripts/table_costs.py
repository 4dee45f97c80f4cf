"""Table of what the jobs of a study cost (rule `table_costs`)."""

from pathlib import Path

from softsample.costs import cost_table
from softsample.io import write_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    write_table(snakemake.output.table, cost_table(Path(snakemake.log[0]).parent))
