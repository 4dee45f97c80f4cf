"""Trace what the calibrated model leaves over to the effect that it lacks (rule `diagnose`)."""

from softsample.constitutive.ogden import OgdenMaterial
from softsample.figures.loop import loop_figure
from softsample.figures.style import save
from softsample.io import read_json, read_record, read_table, write_json, write_text, written_aside
from softsample.loop.diagnose import LoopSettings, diagnose, report
from softsample.loop.effects import library
from softsample.loop.page import page
from softsample.loop.specimen import Elastic, Specimen
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    settings = LoopSettings.of_config(given.loop)
    solid = OgdenMaterial.of_fit(read_json(files.fit))
    specimens = [
        Specimen.of_record(
            name,
            mode,
            read_record(files.records[k]),
            Elastic.of_tables(
                mode,
                read_table(files.curves[k]),
                [read_table(files.variants[k])],
                solid,
                read_table(files.real[k]) if files.get("real") else None,
            ),
        )
        for k, (name, mode) in enumerate(zip(given.samples, given.modes, strict=True))
    ]
    effects = library(solid).values()
    found = diagnose(specimens, settings, list(effects))
    verdict = report(found, settings)
    write_json(snakemake.output.verdict, {**verdict, "provenance": provenance(snakemake)})
    write_text(snakemake.output.page, page(snakemake.wildcards.group, verdict))
    with written_aside(snakemake.output.figure) as aside:
        save(loop_figure(found), aside)
