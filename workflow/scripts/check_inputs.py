"""Check the image and the record of one sample (rule `check_inputs`)."""

from softsample.images import check_image
from softsample.io import read_image, read_record, read_yaml, write_json
from softsample.records import check_record
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    image, record = snakemake.input.image[0], snakemake.input.record
    report = {
        "sample": snakemake.wildcards.sample,
        "mode": snakemake.params.mode,
        "image": check_image(*read_image(image), image),
        "record": check_record(
            read_record(record), snakemake.params.mode, read_yaml(snakemake.input.schema), record
        ),
    }
    write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
