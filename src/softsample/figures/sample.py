"""One sample at a glance: contours, uncertainty of the surface, quality of the mesh."""

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.ndimage import map_coordinates

from softsample.arrays import Array
from softsample.figures.geometry import SegmentedImage, draw_slices, page_limits, scale_bar
from softsample.figures.render import Look, Renderer, draw_surface
from softsample.figures.style import MODE_COLOURS, STRAIN_MAP, label_panel, page_figure, styled
from softsample.figures.surface import OBLIQUE, Surface, mesh_surface
from softsample.meshing.mesh import HexMesh
from softsample.units import MM

QUALITY = (0.4, 1.0)
"""Ends of the colour map of the scaled Jacobian."""


@styled
def sample_figure(
    image: SegmentedImage,
    sigma: Array,
    mesh: HexMesh,
    scaled_jacobian: Array,
    renderer: Renderer = "vtk",
) -> Figure:
    """Three slices with contours, surface by its uncertainty, mesh by its quality, histogram.

    Parameters
    ----------
    image
        Image and segmentation of the sample.
    sigma : (mx, my, mz) float64
        Standard deviation of the boundary on the grid of the signed distance [m].
    mesh
        Hexahedra [m].
    scaled_jacobian : (n_elements,) float64
        Quality of the elements; nodes show the mean of those around them.
    """
    figure = page_figure(height_mm=130.0)
    parts: Any = figure.subfigures(2, 1, hspace=0.04)
    draw_slices(parts[0], image)
    surface = uncertain_surface(image, sigma)
    quality = mesh_surface(mesh, element_values=scaled_jacobian)
    top = float(np.quantile(np.asarray(surface.values), 0.995))
    limits = page_limits([surface, quality])
    left, middle, right = parts[1].subplots(1, 3)
    for ax, shape, ends, edges, label in (
        (left, surface, (0.0, top), False, "one sigma of the boundary [mm]"),
        (middle, quality, QUALITY, True, "scaled Jacobian, mean at nodes"),
    ):
        ax.set(xlim=limits[0], ylim=limits[1])
        draw_surface(ax, shape, OBLIQUE, Look(limits=ends, edges=edges), renderer)
        ax.set_axis_off()
        scale_bar(ax, 10.0)
        colours = mpl.cm.ScalarMappable(mpl.colors.Normalize(*ends), STRAIN_MAP)
        parts[1].colorbar(colours, ax=ax, orientation="horizontal", label=label, shrink=0.8)
    label_panel(left, "d", "Uncertainty of the surface")
    label_panel(middle, "e", f"Mesh, {len(mesh.hexes)} elements")
    _histogram(right, scaled_jacobian)
    label_panel(right, "f", "Quality of the elements")
    return figure


def uncertain_surface(image: SegmentedImage, sigma: Array) -> Surface:
    """Segmented surface whose values are the standard deviation of its position [mm]."""
    surface = image.surface()
    index = (MM * surface.points - image.origin) / image.spacing
    values = map_coordinates(sigma, index.T, order=1, mode="nearest") / MM
    return Surface(surface.points, surface.faces, np.asarray(values))


def _histogram(ax: Axes, scaled_jacobian: Array) -> None:
    """Elements by scaled Jacobian, few bad ones visible by the logarithmic count."""
    ax.hist(scaled_jacobian, bins=np.linspace(0.0, 1.0, 41).tolist(), color=MODE_COLOURS["tension"])
    least = float(scaled_jacobian.min())
    ax.axvline(least, color="black", lw=0.8, ls="--")
    label = f"least {least:.2f}"
    ax.annotate(label, (least, 0.97), xycoords=("data", "axes fraction"), xytext=(-3, 0),
                textcoords="offset points", ha="right", va="top", size=7)  # fmt: skip
    ax.set(xlabel="scaled Jacobian", ylabel="elements", yscale="log", xlim=(0.0, 1.0))
