"""Simulate the curves that the blind laboratory makes records of (rule `blind_curves`)."""

from softsample.blindlab.bodies import Body
from softsample.blindlab.curves import planted_curves
from softsample.fem.explicit import SolverSettings
from softsample.io import write_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given = snakemake.params
    write_table(
        snakemake.output.curves,
        planted_curves(
            Body.named(snakemake.wildcards.body),
            given.sizes,
            given.bank["element_size_mm"],
            SolverSettings(loading_time_s=given.bank["loading_time_s"]),
        ),
    )
