"""How numerical choices change the curve at the optimum (rule `sensitivity`)."""

import numpy as np

from softsample.calibration.curves import MeasuredCurve
from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.family import curve_difference
from softsample.fem.setup import set_up
from softsample.io import read_json, read_mesh_with_data, read_record, write_json
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, fit = snakemake.params, read_json(snakemake.input.fit)
    meshes = {name: read_mesh_with_data(snakemake.input[name]) for name in ("mesh", "coarse")}
    measured = MeasuredCurve.of_record(read_record(snakemake.input.record), given.mode)
    material = OgdenMaterial.of_fit(fit)
    pace = read_json(snakemake.input.family)["loading_time_s"]
    hourglass = given.solver["hourglass_coefficient"]
    variants = {
        "reference": ("mesh", {}),
        "double precision": ("mesh", {"precision": "float64"}),
        "half the hourglass stiffness": ("mesh", {"hourglass_coefficient": 0.5 * hourglass}),
        "twice the hourglass stiffness": ("mesh", {"hourglass_coefficient": 2.0 * hourglass}),
        "elements of twice the size": ("coarse", {}),
    }
    bar, runs = progress_bar(), {}
    for done, (name, (mesh, change)) in enumerate(variants.items()):
        bar(name, done / len(variants))
        model, boundary = set_up(
            *meshes[mesh],
            given.mode,
            solver={**given.solver, **change},
            contact=given.contact,
            material=given.material,
        )
        runs[name] = model.run(material, boundary, measured.travel, loading_time=pace)
    scale = {
        name: measured.scale_of(np.interp(measured.displacement, run.displacement, run.force))
        for name, run in runs.items()
    }
    reference = runs.pop("reference")
    report = {
        name: {
            "largest_percent_of_peak": 100.0 * curve_difference(run, reference),
            "end_force_percent": 100.0 * float(run.force[-1] / reference.force[-1] - 1.0),
            "modulus_percent": 100.0 * (scale[name] / scale["reference"] - 1.0),
        }
        for name, run in runs.items()
    }
    write_json(snakemake.output.report, {"changes": report, "provenance": provenance(snakemake)})
