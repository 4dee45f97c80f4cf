"""Unit-modulus curves of one sample for free exponents (rule `simulate_exponents`)."""

from softsample.calibration.measured import MeasuredCurve
from softsample.fem.setup import set_up
from softsample.io import read_json, read_mesh_with_data, read_record, write_table
from softsample.response.exponents import (
    ExponentSettings,
    curves_table,
    exponent_grid,
    simulate_exponents,
)
from softsample.workflow import logged_to, progress_bar

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    curves = simulate_exponents(
        *set_up(read_mesh_with_data(files.mesh), given.mode, given),
        MeasuredCurve.of_record(read_record(files.record), given.mode).travel,
        exponent_grid(ExponentSettings(**given.exponents), given.material["alpha"]),
        given.material["poisson_ratio"],
        read_json(files.family)["loading_time_s"],
        progress_bar(),
    )
    write_table(snakemake.output.curves, curves_table(curves, given.mode))
