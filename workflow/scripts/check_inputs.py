"""Check the record of one sample, and its image if it has one (rule `check_inputs`)."""

from softsample import io
from softsample.files import refuse_missing
from softsample.formats.machine import read
from softsample.images import check_image
from softsample.manifest import check_files
from softsample.plausibility import Limits, doubts
from softsample.records import RecordSettings, aligned_record
from softsample.shapes import IdealShape
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    files, given = snakemake.input, snakemake.params
    refuse_missing(given.missing)
    if files.manifest:
        shipped = [files.table, *files.image, *files.surface, files.record]
        check_files(io.read_samples(files.manifest), files.manifest, shipped)
    settings = RecordSettings(**given.records)
    raw = read(files.record, *settings.of_files, given.mode)
    size = IdealShape.of_row(given.shape) if given.shape else None
    test = (given.mode, settings, io.read_yaml(files.schema), files.record, size, given.cycle)
    record, facts = aligned_record(raw.table, raw.reading, *test)
    limits = Limits(**given.plausibility).of(given.mode)
    facts["warnings"] += doubts(facts, size, limits, block=settings.block)
    report = {"sample": snakemake.wildcards.sample, "mode": given.mode, "record": facts}
    if files.image:
        report["image"] = check_image(*io.read_image(files.image[0]), files.image[0])
    io.write_table(snakemake.output.record, record)
    io.write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
