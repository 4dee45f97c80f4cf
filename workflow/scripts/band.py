"""Shear modulus on the inner and the outer surface of the one-sigma band (rule `band`)."""

from softsample import io
from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.uncertainty import band_report
from softsample.constitutive.ogden import of_fit
from softsample.meshing.levelset import LevelSet
from softsample.meshing.surface import boundary_surface
from softsample.response.band import simulate_band
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files, fit = snakemake.params, snakemake.input, io.read_json(snakemake.input.fit)
    measured = MeasuredCurve.of_record(io.read_record(files.records[0]), given.mode)
    levels = [
        LevelSet(*io.read_distance(path, files.segmentation))
        for path in (files.distance, files.sigma)
    ]
    loaded = of_fit(fit), measured.travel, io.read_json(files.response)["loading_time_s"]
    test = given.mode, given, given.ends
    runs = simulate_band(io.read_mesh_with_data(files.mesh), *levels, test, loaded, progress_bar())
    for name in ("inner", "outer"):
        io.write_surface(snakemake.output[name], boundary_surface(runs[name][0]))
    forces = {name: measured.along(run.displacement, run.force) for name, (_, run) in runs.items()}
    report = {
        **band_report(fit["mu_pa"], {name: measured.scale_of(f) for name, f in forces.items()}),
        "boundary_sigma_mm": io.read_json(files.segmentation)["boundary_sigma_mm"],
        "provenance": provenance(snakemake),
    }
    io.write_json(snakemake.output.report, report)
