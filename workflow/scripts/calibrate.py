"""Ogden moduli of one group on one geometry (rule `calibrate`)."""

import pandas as pd

from softsample.calibration.direct import SimulatedCurves
from softsample.calibration.measured import fitted_curves
from softsample.calibration.slsqp import AreaObjective, CalibrationSettings, fit_ogden
from softsample.calibration.uncertainty import Uncertainty, UncertaintySettings
from softsample.fem.setup import set_up
from softsample.io import (
    read_json,
    read_mesh_with_data,
    read_record,
    read_table,
    write_json,
    write_table,
)
from softsample.protocol import travel_sign
from softsample.response.curves import ResponseCurves
from softsample.shapes import IdealShape
from softsample.validation import modelled_ends
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    rows = {row["sample"]: row for row in given.rows}
    records = [read_record(path) for path in files.records]
    heights = [IdealShape.of_report(read_json(path)).height for path in files.cuboids]
    measured = fitted_curves(rows, records, heights, given.hold_out)
    responses = {
        name: ResponseCurves.of_table(read_table(path), row["mode"])
        for (name, row), path in zip(rows.items(), files.curves, strict=True)
        if name in measured
    }
    settings = CalibrationSettings(**given.settings)
    simulated = {}
    if settings.method == "direct":
        sections = {name: given[name] for name in ("solver", "contact", "material")}
        for name, mesh, report in zip(rows, files.meshes, files.reports, strict=True):
            mode, ends = rows[name]["mode"], modelled_ends(rows[name])
            simulated[name] = SimulatedCurves(
                *set_up(*read_mesh_with_data(mesh), mode, ends=ends, **sections),
                measured[name].travel,
                read_json(report)["loading_time_s"],
                given.material["alpha"],
                given.material["poisson_ratio"],
                responses[name].bounds["mu1_fraction"],
            )
    fit = fit_ogden(simulated or responses, measured, settings)
    uncertainty = Uncertainty(
        responses, measured, fit, settings, UncertaintySettings(**given.uncertainty)
    )
    # on the ideal shape contact begins at its top, by definition
    contact_zero = {
        name: 1e-3 * given.contact_zero_mm
        for name in measured
        if rows[name]["mode"] == "compression" and snakemake.wildcards.geometry == "real"
    }
    objective = AreaObjective(responses, measured)
    curve = [
        pd.DataFrame(
            {
                "sample": name,
                "displacement_mm": travel_sign(rows[name]["mode"]) * 1e3 * loading.displacement,
                "measured_N": travel_sign(rows[name]["mode"]) * loading.force,
                "model_N": travel_sign(rows[name]["mode"])
                * objective.force(name, fit.mu, fit.mu1_fraction),
            }
        )
        for name, loading in measured.items()
    ]
    write_table(snakemake.output.curve, pd.concat(curve))
    terms = 1 if snakemake.wildcards.model == "ogden1" else 2
    write_json(
        snakemake.output.fit,
        {
            "group": snakemake.wildcards.group,
            "geometry": snakemake.wildcards.geometry,
            "model": snakemake.wildcards.model,
            "samples": list(measured),
            "modes": [rows[name]["mode"] for name in measured],
            "held_out": [name for name in rows if name not in measured],
            "alpha": given.material["alpha"][:terms],
            "poisson_ratio": given.material["poisson_ratio"],
            **fit.report(),
            "simulations": sum(curves.simulations for curves in simulated.values()),
            "simulations_cpu_s": sum(curves.cpu_s for curves in simulated.values()),
            "uncertainty": uncertainty.report(contact_zero),
            "provenance": provenance(snakemake),
        },
    )
