"""Ogden moduli of one group on one geometry (rule `calibrate`)."""

from softsample import io
from softsample.calibration.direct import simulated_curves, simulation_costs
from softsample.calibration.group import GroupCurves
from softsample.calibration.slsqp import CalibrationSettings, fit_ogden
from softsample.calibration.uncertainty import Uncertainty, UncertaintySettings
from softsample.units import MM
from softsample.validation import modelled_ends
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given, files, of = snakemake.params, snakemake.input, snakemake.wildcards
    settings, simulated = CalibrationSettings(**given.settings), {}
    records = [*map(io.read_record, files.records)]
    heights = [io.read_shape(path).height for path in files.cuboids]
    tables = map(io.read_table, files.curves)
    group = GroupCurves.of(given.rows, records, heights, tables, given.hold_out)
    if settings.method == "direct":
        samples = map(io.read_mesh_with_data, files.meshes), map(modelled_ends, given.rows)
        simulated = simulated_curves(group, *samples, map(io.read_json, files.reports), given)
    fit = fit_ogden(simulated or group.responses, group.measured, settings)
    known = group.responses, group.measured, fit, settings, UncertaintySettings(**given.uncertainty)
    shifts = group.contact_zero(of.geometry, MM * given.contact_zero_mm)
    report = group.report(of, given.material, fit) | simulation_costs(simulated)
    report["uncertainty"] = Uncertainty(*known).report(shifts)
    io.write_table(snakemake.output.curve, group.compared(fit))
    io.write_json(snakemake.output.fit, {**report, "provenance": provenance(snakemake)})
