"""Measure the idealised shape and the areas of one sample, or take what is stated (`measure`)."""

from softsample.imaging.measure import MeasurementSettings, measure
from softsample.io import read_distance, write_json
from softsample.shapes import IdealShape
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    if files.distance:
        settings = MeasurementSettings(**given.settings, preload_mm=given.preload_mm)
        grid = read_distance(files.distance, files.report)
        found = measure(*grid, settings, given.shape.get("shape", "cuboid"))
    else:
        found = IdealShape.of_row(given.shape).report()
    write_json(snakemake.output.cuboid, {**found, "provenance": provenance(snakemake)})
