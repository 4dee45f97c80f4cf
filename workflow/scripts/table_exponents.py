"""Free exponents of all groups, and whether they are constant (rule `table_exponents`)."""

from softsample.io import read_json, read_table, write_table
from softsample.laws.exponents import common_table, exponent_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    reports = dict(zip(given.groups, map(read_json, files.reports), strict=True))
    runs = dict(zip(given.groups, map(read_table, files.runs), strict=True))
    write_table(snakemake.output.table, exponent_table(given.law, reports, runs))
    write_table(snakemake.output.common, common_table(given.law, reports))
