"""Measure the idealised cuboid and the areas of one sample (rule `measure`)."""

from softsample.imaging.measure import MeasurementSettings, measure
from softsample.io import read_distance, write_json
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    grid = read_distance(snakemake.input.distance, snakemake.input.report)
    settings = MeasurementSettings(
        **snakemake.params.settings, preload_mm=snakemake.params.preload_mm
    )
    cuboid = measure(*grid, settings)
    write_json(snakemake.output.cuboid, {**cuboid, "provenance": provenance(snakemake)})
