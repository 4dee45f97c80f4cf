"""Mean nominal stress against strain of each loading mode (rule `table_stress`)."""

from softsample.calibration.measured import MeasuredCurve
from softsample.io import MM, read_json, read_record, write_table
from softsample.report.stress import nominal_curve, stress_strain_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, curves = snakemake.input, []
    for mode, record, name in zip(
        snakemake.params.modes, given.records, given.cuboids, strict=True
    ):
        ramp, cuboid = (
            MeasuredCurve.of_record(read_record(record), mode),
            read_json(name),
        )
        edges = (cuboid[f"{edge}_mm"] * MM for edge in ("length", "width", "height"))
        curves.append((mode, *nominal_curve(ramp.displacement, ramp.force, *edges)))
    write_table(snakemake.output.table, stress_strain_table(curves))
