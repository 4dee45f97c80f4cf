"""Which law each group follows: table, choice and figure (rule `choose_law`)."""

from softsample.figures.laws import laws_figure
from softsample.figures.style import write
from softsample.io import read_json, read_table, write_json, write_table
from softsample.laws.group import LawSettings
from softsample.laws.table import choices, law_table, model_errors
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    settings = LawSettings(**given.laws)
    candidates = settings.laws(given.alpha)
    reports = {g: read_json(path) for g, path in zip(given.groups, files.reports, strict=True)}
    chosen = choices(candidates, reports, settings.pool)
    errors = model_errors(read_table(files.intervals), given.geometries)
    table = law_table(candidates, reports, chosen, errors, given.confidence)
    write_table(snakemake.output.table, table)
    write_json(snakemake.output.choice, {"groups": chosen, "provenance": provenance(snakemake)})
    curves = {g: read_table(path) for g, path in zip(given.groups, files.curves, strict=True)}
    best = {group: choice["best"] for group, choice in chosen.items()}
    titles = {candidate.name: candidate.title for candidate in candidates}
    figure = laws_figure(curves, best, titles)
    write(figure, *snakemake.output.figures)
