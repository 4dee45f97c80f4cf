"""Evidence of a verdict's effects, run at their sizes (rule `confirm_verdict`)."""

from softsample import io
from softsample.constitutive.ogden import of_fit
from softsample.loop.candidates import candidates
from softsample.loop.confirm import confirmations, sizes_to_confirm
from softsample.loop.held_out import Tables, specimens_of
from softsample.loop.posed import LoopSettings
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    verdict, solid = io.read_json(files.verdict), of_fit(io.read_json(files.fit))
    responses = [
        Tables(io.read_table(curves), [*map(io.read_table, changes)], solid)
        for curves, *changes in zip(files.curves, files.perturbations, files.runs, strict=True)
    ]
    records = [io.read_record(path) for path in files.records]
    shapes = [*map(io.read_shape, files.cuboids)]
    samples = zip(given.rows, records, responses, shapes, strict=True)
    tests = [test for sample in samples for test in specimens_of(*sample, given.hold_out)]
    effects = {effect.name: effect for effect in candidates(tests, shapes[0].height, solid)}
    told = sizes_to_confirm(verdict), verdict["path"][0]["threshold"]
    settings = LoopSettings.of_config(given.loop)
    own = verdict["specimen_stiffness"], verdict["specimen_contact_mm"]
    table = confirmations(tests, *told, settings, effects, *own)
    for place, name in enumerate(("group", "geometry")):
        table.insert(place, name, snakemake.wildcards[name])
    io.write_table(snakemake.output.table, table)
