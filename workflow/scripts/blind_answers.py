"""Have the loop judge one part of the blind laboratory's experiments (rule `blind_answers`)."""

from softsample.blindlab.bodies import Body
from softsample.blindlab.judge import Resolution, answer, elastics
from softsample.blindlab.plan import Benches, Extent, plan
from softsample.io import read_table, write_json
from softsample.loop.posed import LoopSettings
from softsample.workflow import logged_to, progress_bar

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    curves = dict(zip(given.names, map(read_table, files.curves), strict=True))
    changes = zip(given.names, map(read_table, files.models), strict=True)
    models = {name: elastics(table, Body.named(name)) for name, table in changes}
    loop, resolution = LoopSettings.of_config(given.loop), Resolution(**given.noise)
    extent, benches = Extent(**given.extent), Benches(**given.bodies)
    misfits = [*map(read_table, files.get("misfits", []))]
    tell, answers, part = progress_bar(), {}, [*enumerate(plan(extent))][given.part :: given.parts]
    for done, (number, experiment) in enumerate(part):
        tell("experiments", done / len(part))
        body = experiment.body(benches)
        answers[number] = answer(
            experiment.records(body, curves[body.name], extent.floor(experiment, *misfits)),
            models[body.name],
            resolution.settings(loop, experiment.floor_percent) if extent.told else loop,
            given.bootstraps if number % given.bootstrap_every == 0 else 0,
        )
    write_json(snakemake.output.answers, answers)
