"""Confirmations of all groups in one table (rule `table_confirmation`)."""

import pandas as pd

from softsample.io import read_table, write_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    parts = [read_table(path) for path in snakemake.input.groups]
    write_table(snakemake.output.table, pd.concat(parts, ignore_index=True))
