"""Summary of the verdicts on others' records, and their page (rule `measured_summary`)."""

from pathlib import Path

from softsample.io import read_json, read_table, write_table, write_text
from softsample.report.measured import (
    channel_table,
    effect_table,
    evidence_table,
    setting_table,
    summary_table,
    unstated_table,
    zero_table,
)
from softsample.report.page import render_page
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, out = snakemake.input, snakemake.output
    verdicts = [read_json(path) for path in given.verdicts]
    zeros = {v["set"]: read_table(path) for v, path in zip(verdicts, given.zeros, strict=True)}
    sources = read_table(given.catalogue).drop_duplicates(["set"])
    tables = {
        "summary": summary_table(verdicts),
        "effects": effect_table(verdicts),
        "channels": channel_table(verdicts),
        "evidence": evidence_table(verdicts),
        "unstated": unstated_table(verdicts),
        "zeros": zero_table(zeros),
        "settings": setting_table(snakemake.params.settings),
        "sources": sources[["set", "source", "licence"]],
    }
    for name, table in tables.items():
        write_table(Path(out.data) / f"{name}.csv", table)
    write_table(out.summary, tables["summary"])
    write_text(out.page, render_page(Path(given.template), tables))
