"""Effects of the geometry on the bias and its parts (rule `table_geometry_effects`)."""

import pandas as pd

from softsample.io import read_json, read_table, write_table
from softsample.report.geometry_effects import (
    biases_of_groups,
    effects_table,
    needed_table,
    shares_table,
    summits_of_modes,
)
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files, out = snakemake.params, snakemake.input, snakemake.output
    biases = biases_of_groups([*map(read_table, files.biases)], given.groups)
    summits = summits_of_modes(given.modes, [*map(read_json, files.cuboids)], biases["mode"])
    none = pd.DataFrame(columns=["quantity", "mode", "mean_percent"])
    paper = read_table(files.paper) if files.paper else none
    effects = effects_table(biases)
    write_table(out.effects, effects)
    write_table(out.shares, shares_table(biases))
    write_table(out.needed, needed_table(effects, given.preload_mm, summits, paper))
