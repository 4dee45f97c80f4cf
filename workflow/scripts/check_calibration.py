"""Check every calibration of one group (rule `check_calibration`)."""

from softsample.checks import calibration_checks, calibration_findings, checked
from softsample.io import read_json, write_json
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    fits = [*map(read_json, snakemake.input.fits)]
    report = checked(calibration_checks(fits), calibration_findings(fits))
    write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
