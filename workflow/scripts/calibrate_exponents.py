"""Moduli and exponents of all groups, profiles, common exponents (rule `calibrate_exponents`)."""

import pandas as pd

from softsample.calibration.exponents import (
    ExponentFamily,
    common_exponents,
    exponent_report,
    profile_table,
)
from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.slsqp import CalibrationSettings, fit_ogden
from softsample.calibration.uncertainty import Uncertainty, UncertaintySettings
from softsample.io import MM, read_json, read_record, read_table, write_json, write_table
from softsample.report.tables import loading
from softsample.response.curves import ResponseCurves
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    settings = CalibrationSettings(**given.settings)
    scatter = UncertaintySettings(**given.uncertainty)
    families, measured = {}, {}
    for (sample, mode), curves, fine, record, cuboid in zip(
        given.modes.items(), files.curves, files.fine, files.records, files.cuboids, strict=True
    ):
        height = MM * read_json(cuboid)["height_mm"]
        coarse = ExponentFamily.of_table(read_table(curves), mode, height)
        families[sample] = coarse.anchored(
            ResponseCurves.of_table(read_table(fine), mode), given.alpha
        )
        measured[sample] = MeasuredCurve.of_record(read_record(record), mode)
    bar, likelihoods, reports, tables = progress_bar(), {}, {}, []
    for done, (group, samples) in enumerate(given.groups.items()):
        bar(group, done / len(given.groups))
        ours = {s: families[s] for s in samples}, {s: measured[s] for s in samples}
        fit = fit_ogden(*ours, settings)
        likelihoods[group] = Uncertainty(*ours, fit, settings, scatter).likelihood()
        profiles = likelihoods[group].profiles(scatter.confidence)
        tables.append(profile_table(group, profiles))
        reports[group] = {
            "loading": loading(given.modes[s] for s in samples),
            **exponent_report(likelihoods[group], profiles, given.alpha),
        }
    write_table(snakemake.output.profiles, pd.concat(tables))
    kinds = {"all": list(reports)}
    for group, report in reports.items():
        kinds.setdefault(report["loading"], []).append(group)
    common = {
        kind: common_exponents([likelihoods[group] for group in groups])
        for kind, groups in kinds.items()
        if len(groups) > 1
    }
    write_json(
        snakemake.output.fits,
        {"groups": reports, "common": common, "provenance": provenance(snakemake)},
    )
