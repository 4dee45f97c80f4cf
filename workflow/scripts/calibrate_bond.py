"""Moduli of one group if the other rule had bonded its samples (rule `calibrate_bond`)."""

from softsample.calibration.bond import other_bond
from softsample.calibration.group import GroupCurves
from softsample.calibration.slsqp import CalibrationSettings
from softsample.io import read_json, read_record, read_shape, read_table, write_json
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    records = [read_record(path) for path in files.records]
    heights = [read_shape(path).height for path in files.cuboids]
    group = GroupCurves.of(
        given.rows, records, heights, map(read_table, files.curves), given.hold_out
    )
    bonds = dict(zip(given.bonded, map(read_json, files.bonds), strict=True))
    fit = other_bond(group.responses, group.measured, bonds, CalibrationSettings(**given.settings))
    write_json(snakemake.output.fit, {"fit": fit, "provenance": provenance(snakemake)})
