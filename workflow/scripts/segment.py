"""Segment the image of one sample, or take over its segmentation (rule `segment`)."""

from softsample.images import world_axis
from softsample.imaging.segment import SegmentationSettings, segment, segmentation_from_mask
from softsample.io import read_image, write_image, write_json
from softsample.workflow import logged_to, provenance

M_TO_MM = 1e3

with logged_to(snakemake.log[0]):
    given = snakemake.params
    elsewhere = snakemake.input.segmentation
    data, affine = read_image(elsewhere or snakemake.input.image)
    found = (segmentation_from_mask if elsewhere else segment)(
        data,
        affine,
        SegmentationSettings(**given.settings),
        loading_axis=world_axis(given.axes["loading_axis"]),
        shear_axis=world_axis(given.axes["shear_axis"]),
    )
    distance_mm = (M_TO_MM * found.distance).astype("float32")
    write_image(snakemake.output.mask, found.mask.astype("uint8"), affine)
    write_image(snakemake.output.distance, distance_mm, found.distance_affine_mm)
    write_json(snakemake.output.report, {**found.summary(), "provenance": provenance(snakemake)})
