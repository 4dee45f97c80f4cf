"""Check every calibration of one group (rule `check_calibration`)."""

from softsample.checks import calibration_checks
from softsample.io import read_json, write_json
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    checks = calibration_checks(read_json(path) for path in snakemake.input.fits)
    report = {"passed": all(item["passed"] for item in checks), "checks": checks}
    write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
