"""Table of sizes and areas of samples and cuboids (rule `table_geometry`)."""

from softsample.io import read_json, write_table
from softsample.report.tables import geometry_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    modes = snakemake.params.modes
    cuboids = {
        sample: read_json(name) for sample, name in zip(modes, snakemake.input.cuboids, strict=True)
    }
    write_table(snakemake.output.table, geometry_table(cuboids, modes))
