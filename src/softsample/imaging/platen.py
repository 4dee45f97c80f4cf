"""The platen below a sample: the plane of its base, which a platen has made flat."""

import numpy as np

from softsample.arrays import Array
from softsample.errors import SegmentationError
from softsample.imaging import frame
from softsample.imaging.settings import SegmentationSettings
from softsample.units import MM

BASE_REACH = (0.15, 0.25)
"""What lies this near to the base plane is base [mm, voxel edges; the larger of the two]."""


def base(
    surface: frame.Surface,
    up: Array,
    spacing: Array,
    settings: SegmentationSettings,
    on_platen: bool,
) -> tuple[Array, Array, float]:
    """Base plane, as of `frame.fit_base`; refuses an underside that no platen has made flat."""
    point, normal, spread = frame.fit_base(surface, up, np.radians(settings.max_tilt_deg))
    if not on_platen:
        return point, normal, spread
    edge = float(np.max(spacing))
    reach = max(BASE_REACH[0] * MM, BASE_REACH[1] * edge)
    flat = frame.base_share(surface, point, normal, reach, rim=edge)
    if flat < settings.min_base_share:
        raise SegmentationError(
            f"no platen found below the sample: {100.0 * flat:.0f} % of its underside lie within"
            f" {reach / MM:.2g} mm of one plane, rim apart, at least"
            f" {100.0 * settings.min_base_share:.0f} % are expected; give an image of the sample"
            " bonded to its platen, and a loading_axis that points from there upward, or lower"
            " segmentation.min_base_share"
        )
    return point, normal, spread


def other_end(
    surface: frame.Surface, up: Array, spacing: Array, settings: SegmentationSettings
) -> str | None:
    """What to do about a sample without a base whose other end could be one, or None."""
    try:
        base(surface, -up, spacing, settings, on_platen=True)
    except SegmentationError:
        return None
    axis = int(np.abs(up).argmax())
    opposite = f"{'-' if up[axis] > 0.0 else '+'}{'xyz'[axis]}"
    return (
        f"its other end is flat: if the image is upside down, write {opposite} into column"
        " loading_axis; if something below the sample is as bright, such as a holder, give a mask"
        " without it in column segmentation"
    )
