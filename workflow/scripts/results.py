"""All numbers of the study in one document, checked against its schema (rule `results`)."""

from softsample.errors import InputError
from softsample.io import read_json, read_table, read_yaml, write_json
from softsample.report.results import study_results
from softsample.validation import refusals
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given, shown = snakemake.input, snakemake.params
    document = study_results(
        shown.samples,
        [read_json(name) for name in given.found],
        [read_json(name) for name in given.cuboids],
        [read_json(name) for name in given.fits],
        read_table(given.intervals),
        {group: read_json(given.verdicts[at]) for at, group in enumerate(shown.groups)},
    )
    document["provenance"] = provenance(snakemake)
    if wrong := list(refusals(document, read_yaml(given.schema))):
        raise InputError("\n".join(f"results.json, {place}: {reason}" for place, reason in wrong))
    write_json(snakemake.output.document, document)
