"""Segment the image of one sample, or take over its segmentation (rule `segment`)."""

from softsample.images import on_grid_of, world_axis
from softsample.imaging.segment import SegmentationSettings, segment, segmentation_from_mask
from softsample.io import (
    read_image,
    write_image,
    write_json,
    write_segmentation,
    write_surface,
)
from softsample.meshing.surface import level_surface
from softsample.workflow import logged_to, provenance

M_TO_MM = 1e3

with logged_to(snakemake):
    given, written = snakemake.params, snakemake.output
    sample = snakemake.wildcards.sample
    data, affine = read_image(snakemake.input.image[0])
    elsewhere = next(iter(snakemake.input.segmentation), None)
    if elsewhere:
        mask = read_image(elsewhere, segments=(sample, "sample"))
        data = on_grid_of((data, affine), *mask, elsewhere)
    found = (segmentation_from_mask if elsewhere else segment)(
        data,
        affine,
        SegmentationSettings(**given.settings),
        loading_axis=world_axis(given.axes["loading_axis"]),
        shear_axis=world_axis(given.axes["shear_axis"]),
    )
    report = found.summary()
    surface = level_surface(found.distance, found.origin, found.spacing)
    write_image(written.mask, found.mask.astype("uint8"), affine)
    write_segmentation(written.segments, found.mask, affine, sample)
    for name in ("distance", "sigma"):
        in_mm = (M_TO_MM * getattr(found, name)).astype("float32")
        write_image(written[name], in_mm, found.distance_affine_mm)
    write_surface(written.surface, surface, report["sample_to_world"])
    write_json(written.report, {**report, "provenance": provenance(snakemake)})
