"""Trace what the calibrated model leaves over to the effect that it lacks (rule `diagnose`)."""

from softsample import io
from softsample.constitutive.ogden import of_fit
from softsample.figures.loop import loop_figure
from softsample.figures.style import write
from softsample.from_files.diagnosis import assumed_ends
from softsample.holdout import hold_out_text
from softsample.loop.ends import diagnose_ends, for_sliding
from softsample.loop.leave_out import left_out_errors
from softsample.loop.posed import LoopSettings
from softsample.loop.verdict import document
from softsample.report.residual import residual_table
from softsample.report.verdict import page
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files, out = snakemake.params, snakemake.input, snakemake.output
    settings, solid = LoopSettings.of_config(given.loop), of_fit(io.read_json(files.fit))
    models = assumed_ends(files, given, solid)
    others = [io.read_json(path) for path in files.get("ends_of_others", [])]
    elsewhere = sum(for_sliding(verdict) for verdict in others)
    found = diagnose_ends(models, settings, elsewhere)
    left_out = left_out_errors(models, given.folds, settings, elsewhere, progress_bar())
    rule = hold_out_text(given.hold_out, given.leave_out, bool(files.get("told")))
    verdict = document(found, left_out, settings, solid, given.rows, rule)
    io.write_json(out.verdict, {**verdict, "provenance": provenance(snakemake)})
    io.write_text(out.page, page(files.template, snakemake.wildcards.group, verdict))
    write(loop_figure(found), out.figure)
    io.write_table(out.residual, residual_table(found))
