"""Figure 2: from the image to the meshes."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from softsample.arrays import Array
from softsample.figures.render import Look, Renderer, draw_surface
from softsample.figures.style import label_panel, page_figure, styled
from softsample.figures.surface import OBLIQUE, Surface, above_base, level_surface
from softsample.units import MM

CONTOUR = "#E69F00"
FINE = 3
"""Points of a slice for each voxel at which the distance is taken for the contour."""

SIGHTS = ("side", "front", "from above")
"""How a slice normal to x, y or z of the sample sees it."""


@dataclass(frozen=True)
class Scan:
    """Image of a sample.

    Parameters
    ----------
    data : (nx, ny, nz) float
        Intensities.
    affine : (4, 4) float64
        From voxel index to world [mm].
    """

    data: NDArray[np.floating]
    affine: Array

    @property
    def voxel_mm(self) -> Array:
        """Voxel edges (3,) [mm]."""
        return np.asarray(np.linalg.norm(self.affine[:3, :3], axis=0))

    @property
    def views(self) -> list[tuple[int, str]]:
        """Image axes that slices are normal to, and what such a slice shows."""
        return [(axis, f"MRI, across {'xyz'[axis]}") for axis in (2, 1, 0)]

    def centre(self) -> Array:
        """Image indices (3,) that slices go through: the middle."""
        return 0.5 * (np.array(self.data.shape) - 1.0)


@dataclass(frozen=True)
class SegmentedImage(Scan):
    """And its signed distance in the sample frame.

    Parameters
    ----------
    distance : (mx, my, mz) float64
        Signed distance to the sample's surface [m], negative inside.
    origin : (3,) float64
        Position of distance voxel [0, 0, 0] in the sample frame [m].
    spacing : float
        Spacing of the distance grid [m].
    sample_to_world : (4, 4) float64
        From the sample frame to world [mm].
    """

    distance: Array
    origin: Array
    spacing: float
    sample_to_world: Array

    @property
    def views(self) -> list[tuple[int, str]]:
        """The same, by the axes of the sample."""
        in_sample = self.sample_to_world[:3, :3].T @ self.affine[:3, :3]
        nearest = np.argmax(np.abs(in_sample), axis=0)
        return [(axis, f"MRI and contour, {SIGHTS[nearest[axis]]}") for axis in (2, 1, 0)]

    def surface(self) -> Surface:
        """Segmented surface in the sample frame."""
        return level_surface(self.distance, self.origin, self.spacing)

    def distance_at(self, voxels: Array) -> Array:
        """Signed distance [mm] at image indices (..., 3), the base plane taken as a face."""
        to_sample = np.linalg.inv(self.sample_to_world) @ self.affine
        sample = voxels @ to_sample[:3, :3].T + to_sample[:3, 3]
        index = np.moveaxis((MM * sample - self.origin) / self.spacing, -1, 0)
        closed = above_base(self.distance, self.origin, self.spacing)
        return np.asarray(map_coordinates(closed, index, order=1, mode="nearest")) / MM

    def centre(self) -> Array:
        """Image indices (3,) of the middle of the sample."""
        inside = np.argwhere(above_base(self.distance, self.origin, self.spacing) < 0.0)
        sample = (self.origin + self.spacing * inside.mean(axis=0)) / MM
        world = self.sample_to_world[:3, :3] @ sample + self.sample_to_world[:3, 3]
        return np.linalg.solve(self.affine[:3, :3], world - self.affine[:3, 3])


@styled
def geometry_figure(
    image: SegmentedImage,
    real: tuple[Surface, int],
    ideal: tuple[Surface, int],
    renderer: Renderer = "vtk",
) -> Figure:
    """Slices with the segmented contour, the surface, and both meshes.

    Parameters
    ----------
    image
        Image and segmentation of one sample.
    real, ideal
        Boundary of the mesh and its number of elements.
    """
    figure = page_figure(height_mm=130.0)
    parts: Any = figure.subfigures(2, 1, height_ratios=[1.0, 1.0], hspace=0.04)
    upper, lower = parts
    draw_slices(upper, image)
    shapes = (
        (image.surface(), "Segmented surface", False),
        (real[0], f"Real mesh, {real[1]} elements", True),
        (ideal[0], f"Idealised mesh, {ideal[1]} elements", True),
    )
    limits = page_limits([surface for surface, _, _ in shapes])
    for ax, letter, (surface, name, edges) in zip(lower.subplots(1, 3), "def", shapes, strict=True):
        ax.set(xlim=limits[0], ylim=limits[1])
        draw_surface(ax, surface, OBLIQUE, Look(edges=edges), renderer)
        ax.set_axis_off()
        label_panel(ax, letter, name)
        scale_bar(ax, 10.0)
    return figure


def draw_slices(part: Any, image: Scan) -> None:
    """The slices of an image, panels a to c of a part of a figure."""
    widths = [extent(image, axis)[0] for axis, _ in image.views]
    slices = part.subplots(1, 3, width_ratios=widths)
    for ax, letter, (axis, name) in zip(slices, "abc", image.views, strict=True):
        draw_slice(ax, image, axis)
        label_panel(ax, letter, name)


def extent(image: Scan, axis: int) -> tuple[float, float]:
    """Width and height [mm] of the slice normal to an image axis."""
    across, up = (i for i in range(3) if i != axis)
    shape, voxel = np.array(image.data.shape), image.voxel_mm
    return float(shape[across] * voxel[across]), float(shape[up] * voxel[up])


def draw_slice(ax: Axes, image: Scan, axis: int) -> None:
    """Slice through the middle, with the sample's contour; coordinates in mm from the corner."""
    across, up = (i for i in range(3) if i != axis)
    at = round(float(image.centre()[axis]))
    width, height = extent(image, axis)
    shown = np.take(image.data, at, axis=axis).T
    ax.imshow(
        shown, origin="lower", extent=(0.0, width, 0.0, height), cmap="gray", vmin=0.0,
        vmax=float(np.percentile(image.data, 99.7)), interpolation="nearest",
    )  # fmt: skip
    if isinstance(image, SegmentedImage):
        _draw_contour(ax, image, axis, (across, up))
    ax.set(xlabel=f"image {'xyz'[across]} [mm]", ylabel=f"image {'xyz'[up]} [mm]")
    ax.set_anchor("N")
    ax.spines[["top", "right"]].set_visible(True)


def _draw_contour(ax: Axes, image: SegmentedImage, axis: int, of: tuple[int, int]) -> None:
    """Where that slice, along the axes `of`, cuts the segmented surface."""
    sizes = image.data.shape
    steps = [np.linspace(0.0, sizes[i] - 1.0, FINE * sizes[i]) for i in of]
    voxels = np.zeros((len(steps[0]), len(steps[1]), 3))
    voxels[..., of[0]], voxels[..., of[1]] = np.meshgrid(*steps, indexing="ij")
    voxels[..., axis] = round(float(image.centre()[axis]))
    x, y = ((s + 0.5) * image.voxel_mm[i] for s, i in zip(steps, of, strict=True))
    distance = image.distance_at(voxels)
    ax.contour(x, y, distance.T, levels=[0.0], colors=CONTOUR, linewidths=1.0)


def page_limits(surfaces: list[Surface]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Common limits of the page for several surfaces, so that all have one scale."""
    page = np.concatenate([OBLIQUE.project(surface.points) for surface in surfaces])
    low, high = page.min(axis=0) - 1.0, page.max(axis=0) + 1.0
    return (float(low[0]), float(high[0])), (float(low[1]) - 2.0, float(high[1]))


def scale_bar(ax: Axes, length_mm: float) -> None:
    """Bar of a given length in the lower left corner of axes in mm."""
    left, bottom = ax.get_xlim()[0] + 0.5, ax.get_ylim()[0] + 0.6
    ax.plot([left, left + length_mm], [bottom, bottom], color="black", lw=2, solid_capstyle="butt")
    ax.annotate(f"{length_mm:g} mm", (left + length_mm, bottom), xytext=(3, 0),
                textcoords="offset points", va="center", size=7)  # fmt: skip
