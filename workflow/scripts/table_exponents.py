"""Free exponents of all groups, and whether they are constant (rule `table_exponents`)."""

from softsample.io import read_json, write_table
from softsample.report.exponents import common_table, exponent_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    fits = read_json(snakemake.input.fits)
    runs = dict(zip(snakemake.params.samples, map(read_json, snakemake.input.runs), strict=True))
    write_table(snakemake.output.table, exponent_table(fits["groups"], runs))
    write_table(snakemake.output.common, common_table(fits["common"]))
