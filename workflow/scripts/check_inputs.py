"""Check the image and the record of one sample (rule `check_inputs`)."""

from softsample.formats.machine import read
from softsample.images import check_image
from softsample.io import read_image, read_samples, read_yaml, write_json, write_table
from softsample.manifest import check_files
from softsample.records import RecordSettings, aligned_record
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    if snakemake.input.manifest:
        manifest, files = snakemake.input.manifest, snakemake.input
        shipped = [files.table, *files.image, files.record]
        check_files(read_samples(manifest), manifest, shipped)
    image, source = snakemake.input.image[0], snakemake.input.record
    given = RecordSettings(**snakemake.params.records)
    raw = read(source, given.columns, given.units)
    schema, mode = read_yaml(snakemake.input.schema), snakemake.params.mode
    record, facts = aligned_record(raw.table, raw.reading, mode, given, schema, source)
    report = {
        "sample": snakemake.wildcards.sample,
        "mode": snakemake.params.mode,
        "image": check_image(*read_image(image), image),
        "record": facts,
    }
    write_table(snakemake.output.record, record)
    write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
