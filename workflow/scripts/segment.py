"""Segment the image of one sample and find its frame (rule `segment`)."""

import numpy as np

from softsample.imaging.segment import SegmentationSettings, segment
from softsample.io import read_image, write_image, write_json
from softsample.workflow import logged_to, provenance

MM = 1e-3

with logged_to(snakemake.log[0]):
    image, affine = read_image(snakemake.input.image)
    found = segment(image, affine, SegmentationSettings(**snakemake.params.settings))
    write_image(snakemake.output.mask, found.mask.astype(np.uint8), affine)
    distance = (found.distance / MM).astype(np.float32)
    write_image(snakemake.output.distance, distance, found.distance_affine_mm)
    write_json(
        snakemake.output.report, {**found.summary(), "provenance": provenance(snakemake)}
    )
