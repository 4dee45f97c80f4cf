"""Mean nominal stress against strain of each loading mode (rule `table_stress`)."""

from softsample.calibration.measured import MeasuredCurve
from softsample.io import read_json, read_record, write_table
from softsample.report.stress import nominal_curve, stress_strain_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, curves = snakemake.input, []
    for mode, record, name in zip(
        snakemake.params.modes, given.records, given.cuboids, strict=True
    ):
        ramp = MeasuredCurve.of_record(read_record(record), mode)
        curves.append((mode, *nominal_curve(ramp.displacement, ramp.force, read_json(name))))
    write_table(snakemake.output.table, stress_strain_table(curves))
