"""Trace what the calibrated model leaves over to the effect that it lacks (rule `diagnose`)."""

from softsample.constitutive.ogden import of_fit
from softsample.figures.loop import loop_figure
from softsample.figures.style import save
from softsample.io import read_json, read_record, read_table, write_json, write_text, written_aside
from softsample.loop.candidates import candidates
from softsample.loop.diagnose import diagnose
from softsample.loop.held_out import Tables, hold_out_text, tests_of
from softsample.loop.leave_out import left_out_errors
from softsample.loop.page import page
from softsample.loop.pool import Others
from softsample.loop.posed import LoopSettings
from softsample.loop.verdict import document
from softsample.shapes import IdealShape
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    settings, solid = LoopSettings.of_config(given.loop), of_fit(read_json(files.fit))
    real = [read_table(path) for path in files.get("real", [])] or [None] * len(given.rows)
    reports = map(read_json, files.get("bonds", []))
    bonds = [next(reports, None) if bonded else None for bonded in given.bonded]
    of_pieces = zip(files.curves, files.perturbations, real, bonds, strict=True)
    known = {
        curves: Tables(read_table(curves), [read_table(changes)], solid, *of_piece)
        for curves, changes, *of_piece in of_pieces
    }
    responses = [known[curves] for curves in files.curves]
    records = [read_record(path) for path in files.records]
    shapes = [IdealShape.of_report(read_json(path)) for path in files.cuboids]
    every = given.rows, records, responses, shapes
    whole, tests = tests_of(*every, []), tests_of(*every, given.hold_out)
    own = [test for test in tests if test.name in given.samples]
    heights = {row["sample"]: shape.height for row, shape in zip(given.rows, shapes, strict=True)}
    effects = candidates(own, heights[own[0].name], solid)
    verdicts = [[read_json(path) for path in files.get(kind, [])] for kind in ("whole", "alone")]
    others = Others.of(given.others, (whole, tests), heights, verdicts, settings, solid)
    found = diagnose(own, settings, effects, others)
    left_out = left_out_errors(tests, given.folds, settings, effects, progress_bar())
    rule = hold_out_text(given.hold_out, given.leave_out, bool(given.others))
    verdict = document(found, left_out, settings, solid, given.rows, rule)
    write_json(snakemake.output.verdict, {**verdict, "provenance": provenance(snakemake)})
    write_text(snakemake.output.page, page(snakemake.wildcards.group, verdict))
    with written_aside(snakemake.output.figure) as aside:
        save(loop_figure(found), aside)
