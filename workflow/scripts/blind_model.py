"""Simulate the loop's model of a body of the blind laboratory (rule `blind_model`)."""

from softsample.blindlab.bodies import Body
from softsample.blindlab.models import model_curves
from softsample.fem.explicit import SolverSettings
from softsample.io import write_table
from softsample.response.pieces import PerturbationSettings
from softsample.workflow import logged_to

with logged_to(snakemake):
    given = snakemake.params
    write_table(
        snakemake.output.curves,
        model_curves(
            Body.named(snakemake.wildcards.body),
            given.bank["model_element_size_mm"],
            SolverSettings(
                loading_time_s=given.bank["model_loading_time_s"],
                curve_error_percent=given.bank["model_curve_error_percent"],
            ),
            PerturbationSettings(**given.perturbations),
        ),
    )
