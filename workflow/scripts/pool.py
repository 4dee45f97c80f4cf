"""What groups of a study tell of each other (rule `pool`)."""

from softsample import io
from softsample.constitutive.ogden import of_fit
from softsample.from_files.diagnosis import groups_in_turn
from softsample.loop.pool import documents
from softsample.loop.posed import LoopSettings
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    settings, solid = LoopSettings.of_config(given.loop), of_fit(io.read_json(files.fit))
    groups = groups_in_turn(files, given, settings, solid)
    told = documents(groups, settings.selection, progress_bar())
    io.write_json(snakemake.output.told, {"groups": told, "provenance": provenance(snakemake)})
