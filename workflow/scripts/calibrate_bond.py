"""Moduli of one group if the other rule had bonded its samples (rule `calibrate_bond`)."""

from softsample.calibration.bond import other_bond
from softsample.calibration.measured import fitted_curves
from softsample.calibration.slsqp import CalibrationSettings
from softsample.io import read_json, read_record, read_table, write_json
from softsample.response.curves import ResponseCurves
from softsample.shapes import IdealShape
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    rows = {row["sample"]: row for row in given.rows}
    records = [*map(read_record, files.records)]
    heights = [IdealShape.of_report(read_json(path)).height for path in files.cuboids]
    measured = fitted_curves(rows, records, heights, given.hold_out)
    responses = {
        name: ResponseCurves.of_table(read_table(path), row["mode"])
        for (name, row), path in zip(rows.items(), files.curves, strict=True)
        if name in measured
    }
    bonds = {
        name: read_json(path)
        for name, path in zip(given.bonded, files.bonds, strict=True)
        if name in measured
    }
    fit = other_bond(responses, measured, bonds, CalibrationSettings(**given.settings))
    write_json(snakemake.output.fit, {"fit": fit, "provenance": provenance(snakemake)})
