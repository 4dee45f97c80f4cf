"""Calibration with a simulation per evaluation beside that by curves (rule `table_direct`)."""

from softsample.io import read_json, write_table
from softsample.report.tables import direct_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given = snakemake.input
    fits = zip(map(read_json, given.direct), map(read_json, given.family), strict=True)
    write_table(snakemake.output.table, direct_table(fits, map(read_json, given.curves)))
