"""Unit-modulus curves of one sample and geometry (rule `simulate`)."""

from softsample.calibration.measured import MeasuredCurve
from softsample.fem.family import FamilySettings, family_fractions, simulate_family
from softsample.fem.setup import set_up
from softsample.io import read_mesh_with_data, read_record, write_json, write_table
from softsample.protocol import travel_sign
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given = snakemake.params
    tests = {
        mesh: set_up(
            *read_mesh_with_data(snakemake.input[mesh]),
            given.mode,
            solver=given.solver,
            contact=given.contact,
            material=given.material,
        )
        for mesh in ("mesh", "pilot")
    }
    one_term = snakemake.wildcards.model == "ogden1"
    curves, report = simulate_family(
        *tests["mesh"],
        MeasuredCurve.of_record(read_record(snakemake.input.record), given.mode).travel,
        [1.0] if one_term else family_fractions(FamilySettings(**given.family)),
        given.material["alpha"],
        given.material["poisson_ratio"],
        progress_bar(),
        pilot=tests["pilot"],
    )
    sign = travel_sign(given.mode)
    write_table(
        snakemake.output.curves,
        {
            "mu1_fraction": curves["mu1_fraction"],
            "displacement_mm": sign * 1e3 * curves["displacement"],
            "force_per_mu_mm2": sign * 1e6 * curves["force"],
            "platen_force_per_mu_mm2": sign * 1e6 * curves["platen_force"],
            "base_force_per_mu_mm2": sign * 1e6 * curves["base_force"],
        },
    )
    write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
