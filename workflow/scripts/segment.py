"""Segment the image of one sample, or take over its segmentation or surface (rule `segment`)."""

from softsample import io
from softsample.images import on_grid_of, one_label, world_axis
from softsample.imaging.segment import segment, segmentation_from_mask
from softsample.imaging.settings import SegmentationSettings
from softsample.imaging.surface import segmentation_from_surface
from softsample.meshing.surface import level_surface
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given, files, written = snakemake.params, snakemake.input, snakemake.output
    sample, settings = snakemake.wildcards.sample, SegmentationSettings(**given.settings)
    axes = {name: world_axis(axis) for name, axis in given.axes.items()}
    if files.surface:
        found = segmentation_from_surface(io.read_surface(files.surface), settings, **axes)
        affine = found.distance_affine_mm
    else:
        data, affine = io.read_image(files.image[0])
        if elsewhere := next(iter(files.segmentation), None):
            mask, own = io.read_image(elsewhere, segments=(sample, "sample"))
            data = on_grid_of((data, affine), one_label(mask, elsewhere), own, elsewhere)
        found = (segmentation_from_mask if elsewhere else segment)(data, affine, settings, **axes)
    report, surface = found.summary(), level_surface(found.distance, found.origin, found.spacing)
    io.write_image(written.mask, found.mask.astype("uint8"), affine)
    io.write_segmentation(written.segments, found.mask, affine, sample)
    for name, grid in found.grids_mm.items():
        io.write_image(written[name], grid, found.distance_affine_mm)
    io.write_surface(written.surface, surface, report["sample_to_world"])
    io.write_json(written.report, {**report, "provenance": provenance(snakemake)})
