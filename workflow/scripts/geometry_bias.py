"""Bias of a group's modulus with sample or cuboid changed (rule `geometry_bias`)."""

from softsample.calibration.slsqp import CalibrationSettings
from softsample.geometry_effects.bias import families, group_bias
from softsample.io import read_json, read_table, write_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, two_term, one_term = snakemake.params, {}, {}
    for (sample, mode), path in zip(given.modes.items(), snakemake.input.curves, strict=True):
        two_term[sample], single = families(read_table(path))
        one_term |= {sample: single} if mode == "compression" else {}
    fit = read_json(snakemake.input.fit)
    table = group_bias(two_term, one_term, fit, CalibrationSettings(**given.settings))
    write_table(snakemake.output.table, table)
