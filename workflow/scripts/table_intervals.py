"""Intervals of all calibrated moduli, term by term (rule `table_intervals`)."""

from softsample.io import read_json, write_table
from softsample.report.intervals import FloorSettings, force_terms, interval_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    bands = dict(zip(given.modes, map(read_json, files.bands), strict=True))
    changes = dict(zip(given.modes, map(read_json, files.sensitivities), strict=True))
    forces = {
        (sample, geometry, model): force_terms(
            given.modes[sample],
            bands[sample],
            changes[sample]["changes"],
            read_json(report)["error_bound_percent"],
            given.element_size_mm,
            FloorSettings(**given.floor),
        )
        for (sample, geometry, model), report in zip(given.curves, files.curves, strict=True)
    }
    write_table(snakemake.output.table, interval_table([*map(read_json, files.fits)], forces))
