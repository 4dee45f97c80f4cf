"""What an image holds, and what to idealise it as, seen in seconds before the study runs."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from softsample.arrays import Array
from softsample.errors import SegmentationError
from softsample.imaging.checked import voxel_size
from softsample.imaging.measure import MeasurementSettings, circularity, measure, proposed_shape
from softsample.imaging.segment import Segmentation, segment, segmentation_from_mask
from softsample.imaging.settings import SegmentationSettings
from softsample.imaging.surface import segmentation_from_surface
from softsample.meshing.surface import TriangleSurface
from softsample.shapes import IdealShape
from softsample.units import MM

SPACING_MM = 0.5
"""Edge of the voxels, and grid of the signed distance, that are enough to see the shape [mm]."""

CELLS_WIDE = 40.0
"""Cells of the grid across a surface that are enough to see its shape."""


@dataclass(frozen=True)
class Glance:
    """A sample as it is seen at low resolution.

    Parameters
    ----------
    shape : IdealShape
        Of the proposed kind, as large as the sample.
    circularity : float
        0 for a rectangle, 1 for a disc; `softsample.imaging.measure.ROUND` separates the kinds.
    found : Segmentation
        With its volume, tilt and flags.
    """

    shape: IdealShape
    circularity: float
    found: Segmentation


def glance(
    data: ArrayLike,
    affine: ArrayLike,
    settings: SegmentationSettings | None = None,
    measurement: MeasurementSettings | None = None,
    *,
    loading_axis: ArrayLike = (0.0, 0.0, 1.0),
    shear_axis: ArrayLike = (1.0, 0.0, 0.0),
    is_mask: bool = False,
) -> Glance:
    """Segment an image at low resolution and measure what is there.

    The boundary is the half-maximum on a coarse grid; a film of fluid is not corrected for, so
    that the size is a few tenths of a millimetre too large at most. What is refused at low
    resolution is looked at in full before it is refused.

    Parameters
    ----------
    data, affine, settings, loading_axis, shear_axis
        As of `softsample.imaging.segment.segment`.
    is_mask : bool
        Whether `data` is a segmentation made elsewhere in place of an image.

    Raises
    ------
    InputError, SegmentationError
        As of `segment` and `measure`.
    """
    coarse = replace(settings or SegmentationSettings(), grid_spacing_mm=SPACING_MM)
    values, to_world = np.asarray(data, dtype=np.float64), np.array(affine, dtype=np.float64)

    def seen(image: ArrayLike, map_to_world: Array) -> Segmentation:
        axes = {"loading_axis": loading_axis, "shear_axis": shear_axis}
        if is_mask:
            return segmentation_from_mask(image, map_to_world, coarse, **axes)
        return segment(image, map_to_world, coarse, find_film=False, **axes)

    small, map_of_small = coarsened((values != 0.0) * 1.0 if is_mask else values, to_world)
    try:
        found = seen(small >= 0.5 if is_mask else small, map_of_small)
    except SegmentationError:
        if small.shape == values.shape:
            raise
        found = seen(values, to_world)
    grid = (found.distance, found.origin, found.spacing)
    roundness = circularity(*grid)
    report = measure(*grid, measurement, proposed_shape(roundness))
    return Glance(IdealShape.of_report(report), roundness, found)


def coarsened(data: Array, affine: Array) -> tuple[Array, Array]:
    """Means of as many neighbouring voxels as fit into `SPACING_MM`, and their affine.

    Parameters
    ----------
    data : (nx, ny, nz) float64
    affine : (4, 4) float64
        From voxel index to world [mm].
    """
    if data.ndim != 3:
        return data, affine
    steps = [max(1, int(SPACING_MM / edge + 0.1)) for edge in voxel_size(affine)]
    shape = [n // step for n, step in zip(data.shape, steps, strict=True)]
    cut = data[tuple(slice(n * step) for n, step in zip(shape, steps, strict=True))]
    blocks = [size for pair in zip(shape, steps, strict=True) for size in pair]
    to_first = np.diag([*map(float, steps), 1.0])
    to_first[:3, 3] = 0.5 * (np.array(steps) - 1.0)
    return cut.reshape(blocks).mean(axis=(1, 3, 5)), affine @ to_first


def circularity_of_surface(
    surface: TriangleSurface, loading_axis: ArrayLike = (0.0, 0.0, 1.0)
) -> float:
    """`circularity` of the sections of a surface across the loading axis, at low resolution.

    The surface is stretched along that axis until it is as high as wide, which changes no section,
    so that thin discs need no fine grid.
    """
    up = np.asarray(loading_axis, dtype=np.float64)
    extent = np.ptp(surface.points, axis=0)
    width = float(np.max(extent * (1.0 - np.abs(up))))
    stretch = np.eye(4)
    stretch[:3, :3] += (width / float(extent @ np.abs(up)) - 1.0) * np.outer(up, up)
    found = segmentation_from_surface(
        surface.moved(stretch),
        SegmentationSettings(grid_spacing_mm=width / CELLS_WIDE / MM),
        loading_axis=up,
        shear_axis=np.eye(3)[int(np.argmin(np.abs(up)))],
    )
    return circularity(found.distance, found.origin, found.spacing)
