"""Segment the image of one sample (rule `segment`)."""

from softsample.imaging.segment import SegmentationSettings, segment
from softsample.io import read_image, write_image, write_json
from softsample.workflow import logged_to, provenance

M_TO_MM = 1e3

with logged_to(snakemake.log[0]):
    data, affine = read_image(snakemake.input.image)
    found = segment(data, affine, SegmentationSettings(**snakemake.params.settings))
    distance_mm = (M_TO_MM * found.distance).astype("float32")
    write_image(snakemake.output.mask, found.mask.astype("uint8"), affine)
    write_image(snakemake.output.distance, distance_mm, found.distance_affine_mm)
    write_json(snakemake.output.report, {**found.summary(), "provenance": provenance(snakemake)})
