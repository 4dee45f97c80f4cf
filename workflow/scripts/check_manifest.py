"""Compare the shipped files that the study reads with their manifest (rule `check_manifest`)."""

from softsample.io import read_samples, write_json
from softsample.manifest import check_files
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    manifest = snakemake.input.manifest
    report = check_files(read_samples(manifest), manifest, snakemake.input.files)
    write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
