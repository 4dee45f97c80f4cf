"""Effects of the geometry on the bias and its parts (rule `table_geometry_effects`)."""

import pandas as pd

from softsample.io import read_json, read_table, write_table
from softsample.report.geometry_effects import effects_table, needed_table, shares_table
from softsample.report.tables import loading
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    biases = pd.concat(
        [
            read_table(path).assign(group=group)
            for group, path in zip(given.groups, files.biases, strict=True)
        ],
        ignore_index=True,
    )
    whole = biases["group"].map({group: loading(modes) for group, modes in given.groups.items()})
    biases["mode"] = whole.where(biases["terms"] == 2, "compression")
    summits = {}
    for mode, path in zip(given.modes, files.cuboids, strict=True):
        cuboid = read_json(path)
        summit = cuboid["highest_point_mm"] - cuboid["height_mm"]
        for name in {name for name in biases["mode"] if mode in name}:
            summits.setdefault(name, []).append(summit)
    effects = effects_table(biases)
    write_table(snakemake.output.effects, effects)
    write_table(snakemake.output.shares, shares_table(biases))
    if files.paper:
        paper = read_table(files.paper)
    else:
        paper = pd.DataFrame(columns=["quantity", "mode", "mean_percent"])
    write_table(snakemake.output.needed, needed_table(effects, given.preload_mm, summits, paper))
