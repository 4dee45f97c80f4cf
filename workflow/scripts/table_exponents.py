"""Free exponents of all groups, and whether they are constant (rule `table_exponents`)."""

from softsample.io import read_json, read_table, write_table
from softsample.laws.exponents import common_table, exponent_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    reports, curves, runs = (
        dict(zip(given.groups, map(read, paths), strict=True))
        for read, paths in (
            (read_json, files.reports), (read_table, files.curves), (read_table, files.runs)
        )
    )  # fmt: skip
    write_table(snakemake.output.table, exponent_table(given.law, reports, curves, runs))
    write_table(snakemake.output.common, common_table(given.law, reports))
