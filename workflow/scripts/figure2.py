"""Figure 2: from the image to the meshes (rule `figure2`)."""

import numpy as np

from softsample.figures.geometry import SegmentedImage, geometry_figure
from softsample.figures.render import available_renderer
from softsample.figures.style import write
from softsample.figures.surface import mesh_surface
from softsample.io import read_distance, read_image, read_json, read_mesh
from softsample.workflow import logged_to

with logged_to(snakemake):
    given = snakemake.input
    meshes = [read_mesh(name) for name in (given.real, given.ideal)]
    image = SegmentedImage(
        *read_image(given.image[0]),
        *read_distance(given.distance, given.segmentation),
        np.array(read_json(given.segmentation)["sample_to_world"]),
    )
    figure = geometry_figure(
        image,
        *((mesh_surface(mesh), len(mesh.hexes)) for mesh in meshes),
        renderer=available_renderer(),
    )
    write(figure, *snakemake.output)
