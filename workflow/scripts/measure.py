"""Measure the idealised cuboid and the areas of one sample (rule `measure`)."""

from softsample.imaging.measure import MeasurementSettings, measure
from softsample.io import read_distance, write_json
from softsample.workflow import logged_to, provenance

with logged_to(snakemake.log[0]):
    given = snakemake.params
    settings = MeasurementSettings(**given.settings, preload_mm=given.preload_mm)
    grid = read_distance(snakemake.input.distance, snakemake.input.report)
    record = measure(*grid, settings)
    write_json(snakemake.output.cuboid, {**record, "provenance": provenance(snakemake)})
