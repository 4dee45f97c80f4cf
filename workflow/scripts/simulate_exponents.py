"""Unit-modulus curves of one sample for free exponents (rule `simulate_exponents`)."""

from softsample.calibration.measured import MeasuredCurve
from softsample.fem.setup import set_up
from softsample.io import read_json, read_mesh_with_data, read_record, write_table
from softsample.protocol import travel_sign
from softsample.response.exponents import ExponentSettings, exponent_grid, simulate_exponents
from softsample.workflow import logged_to, progress_bar

with logged_to(snakemake):
    given = snakemake.params
    curves = simulate_exponents(
        *set_up(
            *read_mesh_with_data(snakemake.input.mesh),
            given.mode,
            solver=given.solver,
            contact=given.contact,
            material=given.material,
        ),
        MeasuredCurve.of_record(read_record(snakemake.input.record), given.mode).travel,
        exponent_grid(
            ExponentSettings(**given.exponents),
            given.material["alpha"],
        ),
        given.material["poisson_ratio"],
        read_json(snakemake.input.family)["loading_time_s"],
        progress_bar(),
    )
    sign = travel_sign(given.mode)
    write_table(
        snakemake.output.curves,
        {
            **{name: curves[name] for name in ("mu1_fraction", "alpha1", "alpha2")},
            "displacement_mm": sign * 1e3 * curves["displacement"],
            "force_per_mu_mm2": sign * 1e6 * curves["force"],
        },
    )
