"""Shear modulus on the inner and the outer surface of the one-sigma band (rule `band`)."""

import numpy as np

from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.uncertainty import band_report
from softsample.constitutive.ogden import of_fit
from softsample.fem.setup import set_up
from softsample.io import (
    read_distance,
    read_json,
    read_mesh_with_data,
    read_record,
    write_json,
    write_surface,
)
from softsample.meshing.levelset import LevelSet
from softsample.meshing.morph import shifted
from softsample.meshing.surface import boundary_surface
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, fit = snakemake.params, read_json(snakemake.input.fit)
    measured = MeasuredCurve.of_record(read_record(snakemake.input.records[0]), given.mode)
    pace = read_json(snakemake.input.response)["loading_time_s"]
    mesh, *data = read_mesh_with_data(snakemake.input.mesh)
    surface, sigma = (
        LevelSet(*read_distance(snakemake.input[name], snakemake.input.segmentation))
        for name in ("distance", "sigma")
    )
    bar, scale = progress_bar(), {}
    for done, (name, times) in enumerate({"inner": -1.0, "real": 0.0, "outer": 1.0}.items()):
        bar(name, done / 3.0)
        moved = shifted(mesh, surface, sigma, times) if times else mesh
        model, boundary = set_up(
            moved,
            *data,
            given.mode,
            solver=given.solver,
            contact=given.contact,
            material=given.material,
            ends=given.ends,
        )
        run = model.run(of_fit(fit), boundary, measured.travel, loading_time=pace)
        force = np.interp(measured.displacement, run.displacement, run.force)
        scale[name] = measured.scale_of(force)
        if times:
            write_surface(snakemake.output[name], boundary_surface(moved))
    report = {
        **band_report(fit["mu_pa"], scale),
        "boundary_sigma_mm": read_json(snakemake.input.segmentation)["boundary_sigma_mm"],
    }
    write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
