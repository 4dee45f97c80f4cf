"""Trace what the calibrated model leaves over to the effect that it lacks (rule `diagnose`)."""

from softsample.calibration.curves import CurveFamily
from softsample.figures.loop import loop_figure
from softsample.figures.style import save
from softsample.io import read_json, read_record, read_table, write_json, write_text, written_aside
from softsample.loop.diagnose import LoopSettings, diagnose, report
from softsample.loop.noise import NoiseSettings
from softsample.loop.page import page
from softsample.loop.select import SelectionSettings
from softsample.loop.specimen import Elastic, Specimen
from softsample.loop.variants import for_all_mixtures, read_changes
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    settings = LoopSettings(
        NoiseSettings(**given.loop["noise"]), SelectionSettings(**given.loop["selection"])
    )
    mixture = read_json(files.fit)["mu1_fraction"]
    specimens = []
    for k, (name, mode) in enumerate(zip(given.samples, given.modes, strict=True)):
        family = CurveFamily.of_table(read_table(files.curves[k]), mode)
        changes = read_changes(read_table(files.variants[k]), family, mode)
        variants = for_all_mixtures(changes, family, mixture)
        if files.get("real"):
            real = CurveFamily.of_table(read_table(files.real[k]), mode)
            variants["real_geometry"] = real.less(family)
        elastic = Elastic(family, variants, contact=mode == "compression")
        specimens.append(Specimen.of_record(name, mode, read_record(files.records[k]), elastic))
    found = diagnose(specimens, settings)
    verdict = report(found, settings)
    write_json(snakemake.output.verdict, {**verdict, "provenance": provenance(snakemake)})
    write_text(snakemake.output.page, page(snakemake.wildcards.group, verdict))
    with written_aside(snakemake.output.figure) as aside:
        save(loop_figure(found), aside)
