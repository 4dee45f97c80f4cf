"""Moduli and exponents of all groups, profiles, common exponents (rule `calibrate_exponents`)."""

from softsample import io
from softsample.calibration.exponents import ExponentFamily, exponents_of_groups
from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.slsqp import CalibrationSettings
from softsample.calibration.uncertainty import UncertaintySettings
from softsample.protocol import loading
from softsample.shapes import IdealShape
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files, modes = snakemake.params, snakemake.input, snakemake.params.modes
    materials = [given.material for _ in modes]
    heights = [IdealShape.of_report(io.read_json(path)).height for path in files.cuboids]
    tables = map(io.read_table, files.curves), map(io.read_table, files.fine)
    families = map(ExponentFamily.of_tables, *tables, modes.values(), heights, materials)
    loads = map(MeasuredCurve.of_record, map(io.read_record, files.records), modes.values())
    settings = CalibrationSettings(**given.settings), UncertaintySettings(**given.uncertainty)
    report, profiles = exponents_of_groups(
        given.groups,
        dict(zip(modes, families, strict=True)),
        dict(zip(modes, loads, strict=True)),
        given.material["alpha"],
        *settings,
        {group: loading(modes[name] for name in own) for group, own in given.groups.items()},
        progress_bar(),
    )
    io.write_table(snakemake.output.profiles, profiles)
    io.write_json(snakemake.output.fits, {**report, "provenance": provenance(snakemake)})
