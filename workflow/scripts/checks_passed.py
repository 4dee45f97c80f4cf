"""Gather all checks of the study, and fail if one of them did (rule `checks_passed`)."""

from pathlib import Path

from softsample.checks import gather
from softsample.io import read_json, write_json
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    report = gather({Path(path).stem: read_json(path) for path in snakemake.input.reports})
    write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
