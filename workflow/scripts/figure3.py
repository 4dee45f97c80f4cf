"""Figure 3: what holds and moves the samples (rule `figure3`)."""

import numpy as np

from softsample.figures.boundary import HeldSample, boundary_figure
from softsample.figures.render import available_renderer
from softsample.figures.style import write
from softsample.io import read_mesh_with_data
from softsample.shapes import Indenter
from softsample.validation import resolved
from softsample.workflow import logged_to

with logged_to(snakemake):
    shown, rows = snakemake.params, []
    for geometry, samples in shown.samples.items():
        meshes = zip(samples, map(read_mesh_with_data, snakemake.input[geometry]), strict=True)
        rows += [
            HeldSample(
                sample,
                shown.rows[sample]["mode"],
                geometry,
                mesh,
                np.flatnonzero(points["glued"]),
                Indenter.of_row(resolved(shown.rows[sample])),
            )
            for sample, (mesh, points, _) in meshes
        ]
    figure = boundary_figure(rows, available_renderer())
    write(figure, *snakemake.output)
