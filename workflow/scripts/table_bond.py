"""Bonded area and modulus by either rule of the bond, of every sample (rule `table_bond`)."""

from softsample.io import read_json, write_table
from softsample.report.bond import bond_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    reports, cuboids = (
        dict(zip(given.rows, map(read_json, paths), strict=True))
        for paths in (files.reports, files.cuboids)
    )
    others = {
        group: read_json(path)["fit"]
        for group, path in zip(given.groups, files.others, strict=True)
    }
    fits = [*map(read_json, files.fits)]
    table = bond_table(reports, cuboids, given.rows, fits, others)
    write_table(snakemake.output.table, table)
