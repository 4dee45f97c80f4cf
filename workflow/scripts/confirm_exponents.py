"""The optimum with free exponents on the study's mesh (rule `confirm_exponents`)."""

from softsample import io
from softsample.calibration.exponents import ExponentFamily, confirmation
from softsample.calibration.measured import MeasuredCurve
from softsample.constitutive.ogden import unit_modulus
from softsample.fem.setup import set_up
from softsample.shapes import IdealShape
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files, mode = snakemake.params, snakemake.input, snakemake.params.mode
    fit = io.read_json(files.fits)["groups"][given.group]
    fraction, *alpha = (fit[name] for name in ("mu1_fraction", "alpha1", "alpha2"))
    measured = MeasuredCurve.of_record(io.read_record(files.record), mode)
    height = IdealShape.of_report(io.read_json(files.cuboid)).height
    tables = io.read_table(files.curves), io.read_table(files.fine)
    family = ExponentFamily.of_tables(*tables, mode, height, given.material)
    model, boundary = set_up(io.read_mesh_with_data(files.mesh), mode, given)
    bar = progress_bar()
    run = model.run(
        unit_modulus(fraction, alpha, given.material["poisson_ratio"], fit["mu_pa"]),
        boundary,
        measured.travel,
        loading_time=io.read_json(files.family)["loading_time_s"],
        progress=lambda done: bar("run at the optimum", done),
    )
    modelled = family.force(measured.displacement, fit["mu_pa"], fraction, *alpha)
    report = confirmation(measured, measured.along(run.displacement, run.force), modelled)
    io.write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
