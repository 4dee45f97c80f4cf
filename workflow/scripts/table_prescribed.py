"""Strains up to which prescribed displacements replace contact (rule `table_prescribed`)."""

from softsample.io import read_table, write_table
from softsample.report.prescribed import prescribed_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given = snakemake.params
    keys = zip(given.samples, given.geometries, strict=True)
    curves = dict(zip(keys, map(read_table, snakemake.input.curves), strict=True))
    write_table(snakemake.output.table, prescribed_table(curves))
