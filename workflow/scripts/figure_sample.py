"""Segmentation and mesh of one sample at a glance (rule `figure_sample`)."""

import numpy as np

from softsample.figures.geometry import SegmentedImage
from softsample.figures.render import available_renderer
from softsample.figures.sample import sample_figure
from softsample.figures.style import write
from softsample.io import read_distance, read_image, read_json, read_mesh_with_data
from softsample.workflow import logged_to

with logged_to(snakemake):
    given = snakemake.input
    report = read_json(given.segmentation)
    mesh, _, cell_data = read_mesh_with_data(given.mesh)
    sigma, _, _ = read_distance(given.sigma, given.segmentation)
    image = SegmentedImage(
        *read_image(given.image[0]),
        *read_distance(given.distance, given.segmentation),
        np.array(report["sample_to_world"]),
    )
    quality = cell_data["scaled_jacobian"]
    figure = sample_figure(image, sigma, mesh, quality, renderer=available_renderer())
    write(figure, snakemake.output.png)
