"""The optimum with free exponents on the study's mesh (rule `confirm_exponents`)."""

import numpy as np

from softsample.calibration.exponents import ExponentFamily
from softsample.calibration.measured import MeasuredCurve
from softsample.constitutive.ogden import unit_modulus
from softsample.fem.setup import set_up
from softsample.io import MM, read_json, read_mesh_with_data, read_record, read_table, write_json
from softsample.response.curves import ResponseCurves
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    fit = read_json(files.fits)["groups"][given.group]
    shape = [fit[name] for name in ("mu1_fraction", "alpha1", "alpha2")]
    measured = MeasuredCurve.of_record(read_record(files.record), given.mode)
    height = MM * read_json(files.cuboid)["height_mm"]
    family = ExponentFamily.of_table(read_table(files.curves), given.mode, height).anchored(
        ResponseCurves.of_table(read_table(files.fine), given.mode), given.material["alpha"]
    )
    model, boundary = set_up(
        *read_mesh_with_data(files.mesh),
        given.mode,
        solver=given.solver,
        contact=given.contact,
        material=given.material,
    )
    bar = progress_bar()
    run = model.run(
        unit_modulus(shape[0], shape[1:], given.material["poisson_ratio"], fit["mu_pa"]),
        boundary,
        measured.travel,
        loading_time=read_json(files.family)["loading_time_s"],
        progress=lambda fraction: bar("run at the optimum", fraction),
    )
    direct = np.interp(measured.displacement, run.displacement, run.force)
    modelled = family.force(measured.displacement, fit["mu_pa"], *shape)
    report = {
        "area_error_percent": 100.0 * measured.area_between(direct) / measured.area,
        "against_calibrated_curve_percent": 100.0
        * float(np.abs(direct - modelled).max() / np.abs(modelled).max()),
        "modulus_percent": 100.0 * (measured.scale_of(direct) / measured.scale_of(modelled) - 1.0),
    }
    write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
