"""Shear modulus on the inner and the outer surface of the one-sigma band (rule `band`)."""

import numpy as np

from softsample.calibration.curves import MeasuredCurve
from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.setup import set_up
from softsample.io import read_json, read_mesh_with_data, read_record, write_json
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake.log[0]):
    given, fit = snakemake.params, read_json(snakemake.input.fit)
    measured = MeasuredCurve.of_record(read_record(snakemake.input.record), given.mode)
    pace = read_json(snakemake.input.family)["loading_time_s"]
    bar, scale = progress_bar(), {}
    for done, geometry in enumerate(("real", "inner", "outer")):
        bar(geometry, done / 3.0)
        model, boundary = set_up(
            *read_mesh_with_data(snakemake.input[geometry]),
            given.mode,
            solver=given.solver,
            contact=given.contact,
            material=given.material,
        )
        run = model.run(OgdenMaterial.of_fit(fit), boundary, measured.travel, loading_time=pace)
        force = np.interp(measured.displacement, run.displacement, run.force)
        scale[geometry] = measured.scale_of(force)
    mu = {geometry: fit["mu_pa"] * scale[geometry] / scale["real"] for geometry in scale}
    low, high = min(mu.values()), max(mu.values())
    report = {
        "mu_low_pa": low,
        "mu_pa": mu["real"],
        "mu_high_pa": high,
        "low_percent": 100.0 * (low / mu["real"] - 1.0),
        "high_percent": 100.0 * (high / mu["real"] - 1.0),
        "boundary_sigma_mm": read_json(snakemake.input.segmentation)["boundary_sigma_mm"],
    }
    write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
