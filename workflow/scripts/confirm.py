"""One run with the calibrated material: curve, deformed shape and strain (rule `confirm`)."""

import numpy as np
import pandas as pd

from softsample.calibration.measured import MeasuredCurve
from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.fields import contact_report, max_principal_hencky_strain
from softsample.fem.setup import set_up
from softsample.io import (
    read_json,
    read_mesh_with_data,
    read_record,
    read_table,
    write_json,
    write_mesh,
    write_table,
)
from softsample.protocol import travel_sign
from softsample.response.unit import run_report
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, sample = snakemake.params, snakemake.wildcards.sample
    fit, curve = read_json(snakemake.input.fit), read_table(snakemake.input.fit_curve)
    mesh, point_data, cell_data = read_mesh_with_data(snakemake.input.mesh)
    model, boundary = set_up(
        mesh,
        point_data,
        cell_data,
        given.mode,
        solver=given.solver,
        contact=given.contact,
        material=given.material,
    )
    measured = MeasuredCurve.of_record(read_record(snakemake.input.record), given.mode)
    material = OgdenMaterial.of_fit(fit)
    bar = progress_bar()
    run = model.run(
        material,
        boundary,
        measured.travel,
        snapshots=np.linspace(0.05, 1.0, 20),
        loading_time=read_json(snakemake.input.family)["loading_time_s"],
        progress=lambda fraction: bar("run at the optimum", fraction),
    )
    sign = travel_sign(given.mode)
    modelled = curve.loc[curve["sample"] == sample, "model_N"].to_numpy()
    direct = sign * np.interp(measured.displacement, run.displacement, run.force)
    write_table(
        snakemake.output.curve,
        {"displacement_mm": sign * 1e3 * run.displacement, "force_N": sign * run.force},
    )
    energies = {f"{k}_J": values for k, values in run.energies.items() if k != "displacement"}
    write_table(
        snakemake.output.energies,
        {"displacement_mm": sign * 1e3 * run.energies["displacement"], **energies},
    )
    contacts = [
        {"displacement_mm": sign * 1e3 * snapshot.travel, **contact_report(mesh, snapshot)}
        for snapshot in run.snapshots
    ]
    write_table(snakemake.output.contact, pd.DataFrame(contacts))
    write_mesh(
        snakemake.output.fields,
        mesh,
        {"displacement_mm": 1e3 * run.displacement_field, "held": run.held, **point_data},
        {"max_principal_hencky_strain": max_principal_hencky_strain(mesh, run.displacement_field)},
    )
    report = {
        "travel_mm": 1e3 * measured.travel,
        "against_calibrated_curve_percent": 100
        * float(abs(direct - modelled).max() / abs(modelled).max()),
        **run_report(run),
        "provenance": provenance(snakemake),
    }
    write_json(snakemake.output.report, report)
