"""A closed surface made elsewhere in place of an image: the same result as a segmentation."""

import numpy as np
from numpy.typing import ArrayLike

from softsample.imaging import frame
from softsample.imaging.boundary import PADDING_MM
from softsample.imaging.checked import checked_axes
from softsample.imaging.segment import Segmentation
from softsample.imaging.settings import SegmentationSettings
from softsample.meshing.surface import TriangleSurface, base_centre, distance_grid
from softsample.units import MM

CELLS_ACROSS = (24.0, 80.0)
"""Cells of the grid along the shortest extent of a surface, at least and at most."""

RIM = 6.0
"""Least width of the rim of the grid, in its spacings."""

GRID_ERROR = 0.1
"""How far the grid moves a sharp edge, in its spacings: the standard deviation that is stated."""


def segmentation_from_surface(
    surface: TriangleSurface,
    settings: SegmentationSettings | None = None,
    *,
    loading_axis: ArrayLike = (0.0, 0.0, 1.0),
    shear_axis: ArrayLike = (1.0, 0.0, 0.0),
) -> Segmentation:
    """Take over the surface of a sample; its lowest face, which has to be flat, is the base.

    Parameters
    ----------
    surface : TriangleSurface
        Closed, its axes those of the world [m].
    settings : SegmentationSettings, optional
        The spacing of the grid is used; in a small or large sample it gives way.
    loading_axis, shear_axis : (3,) array
        World directions, nominally: from the glued base upward, and of the shear.

    Returns
    -------
    Segmentation
        Its `mask` lies on the grid of the distance. Of the position of the surface nothing is
        known but what the grid leaves open.

    Raises
    ------
    MeshError
        If the surface is not closed or its lowest face is not flat.
    """
    settings = settings or SegmentationSettings()
    up, shear = checked_axes(loading_axis, shear_axis)
    x = frame.wall_direction(frame.Surface(surface.points[surface.triangles]), up, shear)
    to_world = frame.rigid(x, up, np.zeros(3))
    turned = surface.moved(to_world.T)
    spacing = _spacing(turned, settings.grid_spacing_mm * MM)
    padding = max(PADDING_MM * MM, RIM * spacing)
    distance, origin, _ = distance_grid(turned, spacing, padding)
    height = origin[2] + spacing * np.arange(distance.shape[2])
    return Segmentation(
        mask=(distance < 0.0) & (height >= 0.0),
        distance=distance,
        origin=origin,
        spacing=spacing,
        sample_to_world=frame.rigid(x, up, to_world[:3, :3] @ base_centre(turned)),
        sigma=np.full(distance.shape, GRID_ERROR * spacing),
        flags=frame.told_turn(x, shear),
    )


def _spacing(surface: TriangleSurface, wanted: float) -> float:
    """Spacing of the grid [m], as wanted where that suits the size of the sample."""
    smallest = float(np.ptp(surface.points, axis=0).min())
    fewest, most = CELLS_ACROSS
    return min(max(wanted, smallest / most), smallest / fewest)
