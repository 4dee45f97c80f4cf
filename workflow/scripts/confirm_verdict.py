"""Evidence of a verdict's effects, run at their sizes (rule `confirm_verdict`)."""

from softsample.constitutive.ogden import OgdenMaterial
from softsample.io import read_json, read_record, read_table, write_table
from softsample.loop.confirm import confirmations, sizes_to_confirm
from softsample.loop.diagnose import LoopSettings
from softsample.loop.effects import library
from softsample.loop.specimen import Elastic, Specimen
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    verdict = read_json(files.verdict)
    solid = OgdenMaterial.of_fit(read_json(files.fit))
    specimens = [
        Specimen.of_record(
            name,
            mode,
            read_record(files.records[k]),
            Elastic.of_tables(
                mode,
                read_table(files.curves[k]),
                [read_table(files.variants[k]), read_table(files.runs[k])],
                solid,
            ),
        )
        for k, (name, mode) in enumerate(zip(given.samples, given.modes, strict=True))
    ]
    table = confirmations(
        specimens,
        sizes_to_confirm(verdict),
        verdict["path"][0]["threshold"],
        LoopSettings.of_config(given.loop),
        library(solid),
    )
    group, geometry = snakemake.wildcards.group, snakemake.wildcards.geometry
    table.insert(0, "geometry", geometry)
    table.insert(0, "group", group)
    write_table(snakemake.output.table, table)
