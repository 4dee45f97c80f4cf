"""Check the image of one sample, or that its surface is there (rule `check_image`)."""

from softsample import io
from softsample.files import refuse_missing
from softsample.images import check_image
from softsample.manifest import check_files
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    files = snakemake.input
    refuse_missing(snakemake.params.missing)
    if files.manifest:
        shipped = [files.table, *files.image, *files.surface]
        check_files(io.read_samples(files.manifest), files.manifest, shipped)
    report = {"sample": snakemake.wildcards.sample}
    if files.image:
        report["image"] = check_image(*io.read_image(files.image[0]), files.image[0])
    io.write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
