"""The loop on a set of others' records (rule `measured_verdict`)."""

from pathlib import Path

from softsample.io import read_table, write_json, write_table
from softsample.loop.diagnose import LoopSettings
from softsample.measured.models import elastics
from softsample.measured.readers import READERS
from softsample.measured.siblings import odd_zeros
from softsample.measured.split import SplitSettings, split
from softsample.measured.study import answer
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, name = snakemake.params, snakemake.wildcards.set
    keys, reader, folder = given.settings, READERS[name], Path(given.root, name)
    settings = LoopSettings.of_config(given.loop, {**given.noise, **keys["noise"]})
    models = elastics(read_table(snakemake.input.models, text_columns=("curve",)))
    tests = reader.read(folder)
    cases = split(
        tests, SplitSettings(keys["held_out"], keys["reach"], keys.get("fitted_reach", 0.0))
    )
    tell = progress_bar()
    groups = []
    for k, case in enumerate(cases):
        tell(case.name, k / len(cases))
        for kind in keys["kinds"]:
            found = answer(case, kind, models, tuple(keys["alpha"]), settings)
            groups.append(found.report(settings))
    zeros = odd_zeros(tests, reader.cells(folder))
    write_table(snakemake.output.zeros, zeros[zeros["found"]].drop(columns="found"))
    write_json(
        snakemake.output.verdict,
        {
            "set": name,
            "held_out": keys["held_out"],
            "unstated": reader.unstated,
            "groups": groups,
            "independent_evidence": reader.evidence(folder),
            "provenance": provenance(snakemake),
        },
    )
