"""Ogden moduli of one group on one geometry (rule `calibrate`)."""

from softsample.calibration.direct import SimulatedCurves
from softsample.calibration.group import GroupCurves
from softsample.calibration.slsqp import CalibrationSettings, fit_ogden
from softsample.calibration.uncertainty import Uncertainty, UncertaintySettings
from softsample.fem.setup import set_up
from softsample.io import (
    MM,
    read_json,
    read_mesh_with_data,
    read_record,
    read_table,
    write_json,
    write_table,
)
from softsample.shapes import IdealShape
from softsample.validation import modelled_ends
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given, files, of = snakemake.params, snakemake.input, snakemake.wildcards
    material, settings = given.material, CalibrationSettings(**given.settings)
    records = [read_record(path) for path in files.records]
    heights = [IdealShape.of_report(read_json(path)).height for path in files.cuboids]
    group = GroupCurves.of(
        given.rows, records, heights, map(read_table, files.curves), given.hold_out
    )
    curves, measured, simulated = group.responses, group.measured, {}
    if settings.method == "direct":
        sections = {name: given[name] for name in ("solver", "contact", "material")}
        simulated = {
            row["sample"]: SimulatedCurves(
                *set_up(
                    *read_mesh_with_data(mesh), row["mode"], ends=modelled_ends(row), **sections
                ),
                measured[row["sample"]].travel,
                read_json(report)["loading_time_s"],
                material["alpha"],
                material["poisson_ratio"],
                curves[row["sample"]].bounds["mu1_fraction"],
            )
            for row, mesh, report in zip(given.rows, files.meshes, files.reports, strict=True)
        }
    fit = fit_ogden(simulated or curves, measured, settings)
    uncertainty = Uncertainty(
        curves, measured, fit, settings, UncertaintySettings(**given.uncertainty)
    )
    shifts = group.contact_zero(of.geometry, given.contact_zero_mm * MM)
    write_table(snakemake.output.curve, group.compared(fit))
    write_json(
        snakemake.output.fit,
        {
            **{name: of[name] for name in ("group", "geometry", "model")},
            **group.report(),
            "alpha": material["alpha"][: 1 if of.model == "ogden1" else 2],
            "poisson_ratio": material["poisson_ratio"],
            **fit.report(),
            "simulations": sum(curves.simulations for curves in simulated.values()),
            "simulations_cpu_s": sum(curves.cpu_s for curves in simulated.values()),
            "uncertainty": uncertainty.report(shifts),
            "provenance": provenance(snakemake),
        },
    )
