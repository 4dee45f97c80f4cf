"""Segment the image of one sample, or take over its segmentation or surface (rule `segment`)."""

from softsample.images import on_grid_of, world_axis
from softsample.imaging.segment import SegmentationSettings, segment, segmentation_from_mask
from softsample.imaging.surface import segmentation_from_surface
from softsample.io import (
    read_image,
    read_surface,
    write_image,
    write_json,
    write_segmentation,
    write_surface,
)
from softsample.meshing.surface import level_surface
from softsample.workflow import logged_to, provenance

M_TO_MM = 1e3

with logged_to(snakemake):
    given, files, written = snakemake.params, snakemake.input, snakemake.output
    sample = snakemake.wildcards.sample
    settings = SegmentationSettings(**given.settings)
    axes = {name: world_axis(axis) for name, axis in given.axes.items()}
    if files.surface:
        found = segmentation_from_surface(read_surface(files.surface), settings, **axes)
        affine = found.distance_affine_mm
    else:
        data, affine = read_image(files.image[0])
        elsewhere = next(iter(files.segmentation), None)
        if elsewhere:
            mask = read_image(elsewhere, segments=(sample, "sample"))
            data = on_grid_of((data, affine), *mask, elsewhere)
        made = segmentation_from_mask if elsewhere else segment
        found = made(data, affine, settings, **axes)
    report = found.summary()
    surface = level_surface(found.distance, found.origin, found.spacing)
    write_image(written.mask, found.mask.astype("uint8"), affine)
    write_segmentation(written.segments, found.mask, affine, sample)
    for name in ("distance", "sigma"):
        in_mm = (M_TO_MM * getattr(found, name)).astype("float32")
        write_image(written[name], in_mm, found.distance_affine_mm)
    write_surface(written.surface, surface, report["sample_to_world"])
    write_json(written.report, {**report, "provenance": provenance(snakemake)})
