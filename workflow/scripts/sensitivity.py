"""How numerical choices change the curve at the optimum (rule `sensitivity`)."""

import numpy as np

from softsample.calibration.measured import MeasuredCurve
from softsample.constitutive.ogden import of_fit
from softsample.fem.setup import set_up
from softsample.io import read_json, read_mesh_with_data, read_record, read_table, write_json
from softsample.protocol import travel_sign
from softsample.records import reach
from softsample.response.optimum import loading_time
from softsample.response.sensitivity import changes_of_force, numerical_changes
from softsample.response.unit import CLOSED_FORM
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files, fit = snakemake.params, snakemake.input, read_json(snakemake.input.fit)
    meshes = {name: read_mesh_with_data(files[name]) for name in ("mesh", "coarse")}
    records = [read_record(path) for path in files.records]
    measured = MeasuredCurve.of_record(records[0], given.mode)
    material, response = of_fit(fit), read_json(files.response)
    travel = response["reached"] * reach(records, given.mode)
    optimum, sign = read_table(files.optimum), travel_sign(given.mode)
    reference = np.interp(
        measured.displacement, sign * 1e-3 * optimum["displacement_mm"], sign * optimum["force_N"]
    )
    changes = numerical_changes(given.solver["hourglass_coefficient"])
    forces, bar = {change.name: reference for change in changes}, progress_bar()
    if response["method"] != CLOSED_FORM:  # which has no mesh, and nothing to choose
        sections = {name: given[name] for name in ("contact", "material", "ends")}
        for done, change in enumerate(changes):
            bar(change.name, done / len(changes))
            mesh = meshes["coarse" if change.coarse else "mesh"]
            solver = {**given.solver, **change.solver}
            model, boundary = set_up(*mesh, given.mode, solver=solver, **sections)
            run = model.run(material, boundary, travel, loading_time=loading_time(response, model))
            forces[change.name] = np.interp(measured.displacement, run.displacement, run.force)
    found = changes_of_force(forces, reference, measured.scale_of)
    write_json(snakemake.output.report, {"changes": found, "provenance": provenance(snakemake)})
