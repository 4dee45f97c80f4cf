"""Curves of a sample and its cuboid with features of the shape changed (rule `geometry_curves`)."""

from softsample.calibration.measured import MeasuredCurve
from softsample.geometry_effects.shapes import Shape
from softsample.geometry_effects.variants import EffectSettings, ShapeTest
from softsample.io import read_distance, read_json, read_record, read_shape, write_table
from softsample.workflow import logged_to, progress_bar

with logged_to(snakemake):
    given, files, steps = snakemake.params, snakemake.input, dict(snakemake.params.effects)
    coarser = steps.pop("element_size_mm")
    travel = MeasuredCurve.of_record(read_record(files.record), given.mode).travel
    test = ShapeTest.of(travel, read_json(files.family)["loading_time_s"], given)
    shape = Shape.of(
        read_distance(files.distance, files.segmentation),
        read_shape(files.cuboid),
        given.mesh,
        coarser,
        test.preload,
        given.top_normal_deg,
    )
    table = test.simulate(test.variants(shape, EffectSettings(**steps)), progress_bar())
    write_table(snakemake.output.curves, table)
