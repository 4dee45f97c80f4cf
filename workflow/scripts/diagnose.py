"""Trace what the calibrated model leaves over to the effect that it lacks (rule `diagnose`)."""

from softsample.constitutive.ogden import of_fit
from softsample.figures.loop import loop_figure
from softsample.figures.style import save
from softsample.io import read_json, read_record, read_table, write_json, write_text, written_aside
from softsample.loop.ends import AssumedEnds, diagnose_ends, for_sliding
from softsample.loop.held_out import Tables, hold_out_text, tests_of
from softsample.loop.leave_out import left_out_errors
from softsample.loop.page import page
from softsample.loop.posed import LoopSettings
from softsample.loop.verdict import document
from softsample.shapes import IdealShape
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    settings, solid = LoopSettings.of_config(given.loop), of_fit(read_json(files.fit))
    reports = map(read_json, files.get("bonds", []))
    bonds = [next(reports, None) if bonded else None for bonded in given.bonded]
    records = [read_record(path) for path in files.records]
    shapes = [IdealShape.of_report(read_json(path)) for path in files.cuboids]
    heights = {row["sample"]: shape.height for row, shape in zip(given.rows, shapes, strict=True)}
    verdicts = [[read_json(path) for path in files.get(kind, [])] for kind in ("whole", "alone")]
    models = []
    for ends in ("", "sliding_")[: 2 if files.get("sliding_curves") else 1]:
        real = [read_table(p) for p in files.get(f"{ends}real", [])] or [None] * len(given.rows)
        curves, changes = files[f"{ends}curves"], files[f"{ends}perturbations"]
        known = {
            path: Tables(read_table(path), [read_table(change)], solid, *of_piece)
            for path, change, *of_piece in zip(curves, changes, real, bonds, strict=True)
        }
        every = given.rows, records, [known[path] for path in curves], shapes
        tests = tests_of(*every, []), tests_of(*every, given.hold_out)
        about = heights, given.others, verdicts, settings, solid
        models.append(AssumedEnds.of(bool(ends), given.samples, tests, *about))
    elsewhere = sum(for_sliding(read_json(path)) for path in files.get("ends_of_others", []))
    found = diagnose_ends(models, settings, elsewhere)
    left_out = left_out_errors(models, given.folds, settings, elsewhere, progress_bar())
    rule = hold_out_text(given.hold_out, given.leave_out, bool(given.others))
    verdict = document(found, left_out, settings, solid, given.rows, rule)
    write_json(snakemake.output.verdict, {**verdict, "provenance": provenance(snakemake)})
    write_text(snakemake.output.page, page(snakemake.wildcards.group, verdict))
    with written_aside(snakemake.output.figure) as aside:
        save(loop_figure(found), aside)
