"""Intervals of all calibrated moduli, term by term (rule `table_intervals`)."""

from softsample.io import read_json, write_table
from softsample.report.intervals import force_terms, interval_table
from softsample.response.floor import FloorSettings
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    bands = dict(zip(given.banded, map(read_json, files.bands), strict=True))
    bonds = dict(zip(given.bonded, map(read_json, files.bonds), strict=True))
    changes = dict(zip(given.modes, map(read_json, files.sensitivities), strict=True))
    forces = {
        (piece, geometry, model): force_terms(
            given.modes[piece],
            bands.get(piece),
            bonds.get(piece) if geometry == "real" else None,
            changes[piece]["changes"],
            read_json(report),
            read_json(mesh)["element_size_mm"],
            FloorSettings(**given.floor),
        )
        for (piece, geometry, model), report, mesh in zip(
            given.curves, files.curves, files.meshes, strict=True
        )
    }
    table = interval_table([*map(read_json, files.fits)], forces, given.piece_of)
    write_table(snakemake.output.table, table)
