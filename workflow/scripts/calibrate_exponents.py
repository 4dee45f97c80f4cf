"""Moduli and exponents of all groups, profiles, common exponents (rule `calibrate_exponents`)."""

from softsample.calibration.exponents import ExponentFamily, exponents_of_groups
from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.slsqp import CalibrationSettings
from softsample.calibration.uncertainty import UncertaintySettings
from softsample.io import MM, read_json, read_record, read_table, write_json, write_table
from softsample.report.tables import loading
from softsample.response.curves import ResponseCurves
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    families, measured = {}, {}
    for (sample, mode), curves, fine, record, cuboid in zip(
        given.modes.items(), files.curves, files.fine, files.records, files.cuboids, strict=True
    ):
        height = MM * read_json(cuboid)["height_mm"]
        families[sample] = ExponentFamily.of_table(read_table(curves), mode, height).anchored(
            ResponseCurves.of_table(read_table(fine), mode), given.alpha
        )
        measured[sample] = MeasuredCurve.of_record(read_record(record), mode)
    report, profiles = exponents_of_groups(
        given.groups,
        families,
        measured,
        given.alpha,
        CalibrationSettings(**given.settings),
        UncertaintySettings(**given.uncertainty),
        {group: loading(given.modes[s] for s in own) for group, own in given.groups.items()},
        progress_bar(),
    )
    write_table(snakemake.output.profiles, profiles)
    write_json(snakemake.output.fits, {**report, "provenance": provenance(snakemake)})
