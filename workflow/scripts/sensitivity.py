"""How numerical choices change the curve at the optimum (rule `sensitivity`)."""

import numpy as np

from softsample.calibration.measured import MeasuredCurve
from softsample.constitutive.ogden import of_fit
from softsample.fem.setup import set_up
from softsample.io import read_json, read_mesh_with_data, read_record, read_table, write_json
from softsample.protocol import travel_sign
from softsample.records import reach
from softsample.response.optimum import loading_time
from softsample.response.unit import curve_difference
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
    hourglass = given.solver["hourglass_coefficient"]
    coarse = "elements of twice the size"
    variants = {
        "half the hourglass stiffness": ("mesh", {"hourglass_coefficient": 0.5 * hourglass}),
        "twice the hourglass stiffness": ("mesh", {"hourglass_coefficient": 2.0 * hourglass}),
        coarse: ("coarse", {}),
        f"{coarse}, double precision": ("coarse", {"precision": "float64"}),
    }
    bar, forces = progress_bar(), {}
    sections = {name: given[name] for name in ("contact", "material", "ends")}
    uniform = given.mode == "shear" and given.ends == "sliding"  # a closed form: nothing to choose
    for done, (name, (mesh, change)) in enumerate(variants.items()):
        bar(name, done / len(variants))
        if uniform:
            forces[name] = reference
            continue
        model, boundary = set_up(
            *meshes[mesh], given.mode, solver={**given.solver, **change}, **sections
        )
        run = model.run(material, boundary, travel, loading_time=loading_time(response, model))
        forces[name] = np.interp(measured.displacement, run.displacement, run.force)
    # rounding changes so little that it is looked at where it costs little
    before = dict.fromkeys(forces, reference) | {f"{coarse}, double precision": forces[coarse]}
    report = {
        name: {
            "largest_percent_of_peak": 100.0 * curve_difference(force, before[name]),
            "end_force_percent": 100.0 * float(force[-1] / before[name][-1] - 1.0),
            "modulus_percent": 100.0
            * (measured.scale_of(force) / measured.scale_of(before[name]) - 1.0),
        }
        for name, force in forces.items()
    }
    write_json(snakemake.output.report, {"changes": report, "provenance": provenance(snakemake)})
