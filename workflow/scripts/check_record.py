"""Check the record of one sample (rule `check_record`)."""

from softsample import io
from softsample.files import refuse_missing
from softsample.formats.machine import read
from softsample.manifest import check_files
from softsample.plausibility import Limits, doubts
from softsample.records import RecordSettings, aligned_record
from softsample.shapes import IdealShape
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    files, given = snakemake.input, snakemake.params
    refuse_missing(given.missing)
    if files.manifest:
        shipped = [files.table, files.record]
        check_files(io.read_samples(files.manifest), files.manifest, shipped)
    settings = RecordSettings(**given.records)
    raw = read(files.record, *settings.of_files, given.mode)
    size = IdealShape.of_row(given.shape) if given.shape else None
    test = (given.mode, settings, io.read_yaml(files.schema), files.record, size, given.cycle)
    record, facts = aligned_record(raw.table, raw.reading, *test)
    limits = Limits(**given.plausibility).of(given.mode)
    test = ({}, settings.block, given.mode, files.record)
    facts["warnings"] += doubts(facts, size, limits, *test)
    report = {"sample": snakemake.wildcards.sample, "mode": given.mode, "record": facts}
    io.write_table(snakemake.output.record, record)
    io.write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
