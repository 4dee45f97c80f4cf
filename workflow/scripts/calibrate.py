"""Ogden moduli of one group on one geometry (rule `calibrate`)."""

import pandas as pd

from softsample.calibration.curves import CurveFamily
from softsample.calibration.direct import SimulatedCurves
from softsample.calibration.measured import MeasuredCurve
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
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given = snakemake.params
    modes = dict(zip(given.samples, given.modes, strict=True))
    families, measured = {}, {}
    for (sample, mode), curves, record in zip(
        modes.items(), snakemake.input.curves, snakemake.input.records, strict=True
    ):
        families[sample] = CurveFamily.of_table(read_table(curves), mode)
        measured[sample] = MeasuredCurve.of_record(read_record(record), mode)
    settings = CalibrationSettings(**given.settings)
    simulated = {}
    if settings.method == "direct":
        for (sample, mode), mesh, report in zip(
            modes.items(), snakemake.input.meshes, snakemake.input.reports, strict=True
        ):
            simulated[sample] = SimulatedCurves(
                *set_up(
                    *read_mesh_with_data(mesh),
                    mode,
                    solver=given.solver,
                    contact=given.contact,
                    material=given.material,
                ),
                measured[sample].travel,
                read_json(report)["loading_time_s"],
                given.material["alpha"],
                given.material["poisson_ratio"],
                families[sample].bounds["mu1_fraction"],
            )
    fit = fit_ogden(simulated or families, measured, settings)
    uncertainty = Uncertainty(
        families, measured, fit, settings, UncertaintySettings(**given.uncertainty)
    )
    # on the cuboid contact begins at its top, by definition
    contact_zero = {
        sample: 1e-3 * given.contact_zero_mm
        for sample, mode in modes.items()
        if mode == "compression" and snakemake.wildcards.geometry == "real"
    }
    objective = AreaObjective(families, measured)
    curve = [
        pd.DataFrame(
            {
                "sample": sample,
                "displacement_mm": travel_sign(mode) * 1e3 * measured[sample].displacement,
                "measured_N": travel_sign(mode) * measured[sample].force,
                "model_N": travel_sign(mode) * objective.force(sample, fit.mu, fit.mu1_fraction),
            }
        )
        for sample, mode in modes.items()
    ]
    write_table(snakemake.output.curve, pd.concat(curve))
    terms = 1 if snakemake.wildcards.model == "ogden1" else 2
    write_json(
        snakemake.output.fit,
        {
            "group": snakemake.wildcards.group,
            "geometry": snakemake.wildcards.geometry,
            "model": snakemake.wildcards.model,
            "samples": given.samples,
            "modes": given.modes,
            "alpha": given.material["alpha"][:terms],
            "poisson_ratio": given.material["poisson_ratio"],
            **fit.report(),
            "simulations": sum(curves.simulations for curves in simulated.values()),
            "simulations_cpu_s": sum(curves.cpu_s for curves in simulated.values()),
            "uncertainty": uncertainty.report(contact_zero),
            "provenance": provenance(snakemake),
        },
    )
