"""How numerical choices change the curve at the optimum (rule `sensitivity`)."""

from softsample.calibration.measured import MeasuredCurve
from softsample.constitutive.ogden import of_fit
from softsample.io import read_json, read_mesh_with_data, read_record, read_table, write_json
from softsample.records import reach
from softsample.response.sensitivity import changes_of_force, forces_with_changes
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    records, response = [*map(read_record, files.records)], read_json(files.response)
    measured = MeasuredCurve.of_record(records[0], given.mode)
    reference = measured.along_table(read_table(files.optimum), given.mode)
    forces = forces_with_changes(
        {name: read_mesh_with_data(files[name]) for name in ("mesh", "coarse")},
        (given.mode, given, given.ends),
        of_fit(read_json(files.fit)),
        response["reached"] * reach(records, given.mode),
        response,
        (measured.displacement, reference),
        progress_bar(),
    )
    found = changes_of_force(forces, reference, measured.scale_of)
    write_json(snakemake.output.report, {"changes": found, "provenance": provenance(snakemake)})
