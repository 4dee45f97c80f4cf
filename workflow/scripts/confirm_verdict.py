"""Evidence of a verdict's effects, run at their sizes (rule `confirm_verdict`)."""

from softsample.constitutive.ogden import of_fit
from softsample.io import read_json, read_record, read_table, write_table
from softsample.loop.candidates import candidates
from softsample.loop.confirm import confirmations, sizes_to_confirm
from softsample.loop.held_out import Tables, tests_of
from softsample.loop.posed import LoopSettings
from softsample.shapes import IdealShape
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    verdict = read_json(files.verdict)
    solid = of_fit(read_json(files.fit))
    responses = [
        Tables(read_table(curves), [*map(read_table, changes)], solid)
        for curves, *changes in zip(files.curves, files.perturbations, files.runs, strict=True)
    ]
    records = [read_record(path) for path in files.records]
    shapes = [IdealShape.of_report(read_json(path)) for path in files.cuboids]
    tests = tests_of(given.rows, records, responses, shapes, given.hold_out)
    table = confirmations(
        tests,
        sizes_to_confirm(verdict),
        verdict["path"][0]["threshold"],
        LoopSettings.of_config(given.loop),
        {effect.name: effect for effect in candidates(tests, shapes[0].height, solid)},
        verdict["specimen_stiffness"],
    )
    table.insert(0, "geometry", snakemake.wildcards.geometry)
    table.insert(0, "group", snakemake.wildcards.group)
    write_table(snakemake.output.table, table)
