"""What an image should be idealised as, seen in seconds before the study runs."""

from dataclasses import replace

from numpy.typing import ArrayLike

from softsample.imaging.measure import MeasurementSettings, circularity, measure, proposed_shape
from softsample.imaging.segment import SegmentationSettings, segment
from softsample.shapes import IdealShape

SPACING_MM = 0.5
"""Grid of the signed distance that is fine enough to see the shape [mm]."""


def proposed_shape_of_image(
    data: ArrayLike,
    affine: ArrayLike,
    settings: SegmentationSettings | None = None,
    measurement: MeasurementSettings | None = None,
    *,
    loading_axis: ArrayLike = (0.0, 0.0, 1.0),
    shear_axis: ArrayLike = (1.0, 0.0, 0.0),
) -> tuple[IdealShape, float]:
    """Shape that the sample in an image looks like, and how round it is.

    The boundary is the half-maximum on a coarse grid; a film of fluid is not corrected for, so
    that the size is a few tenths of a millimetre too large at most.

    Parameters
    ----------
    data, affine, settings, loading_axis, shear_axis
        As of `softsample.imaging.segment.segment`.
    measurement : MeasurementSettings, optional

    Returns
    -------
    shape : IdealShape
        Of the proposed kind, as large as the sample.
    circularity : float
        0 for a rectangle, 1 for a disc; `softsample.imaging.measure.ROUND` separates the kinds.

    Raises
    ------
    InputError, SegmentationError
        As of `segment` and `measure`.
    """
    coarse = replace(settings or SegmentationSettings(), grid_spacing_mm=SPACING_MM)
    axes = {"loading_axis": loading_axis, "shear_axis": shear_axis}
    found = segment(data, affine, coarse, find_film=False, **axes)
    grid = (found.distance, found.origin, found.spacing)
    roundness = circularity(*grid)
    report = measure(*grid, measurement, proposed_shape(roundness))
    return IdealShape.of_report(report), roundness
