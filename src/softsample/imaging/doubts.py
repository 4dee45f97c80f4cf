"""What makes one doubt that a segmented region is the sample, the whole of it and nothing else."""

from collections.abc import Iterator

import numpy as np
from scipy import ndimage
from skimage.morphology import convex_hull_image

from softsample.arrays import Array, Mask
from softsample.imaging.boundary import Boundary
from softsample.imaging.tissue import MOST_SHARED
from softsample.units import MM

REACH_MM = 1.0
"""Thickness of the shell around a sample whose brightness counts [mm]: some voxels."""

BRIGHT_BESIDE = 0.1
"""Brightness of such a shell over that of tissue. It is 0.01 at most around the samples of the
cohorts, and 0.2 to 0.4 at platens and in fluids that a lab sees."""

STEP_MM = 0.5
"""Distance of the sections that are compared [mm]."""

MOST_STEP = 0.15
"""Change of the area of sections so near to each other, relative. It is 0.08 at most in the samples
of the cohorts, and 0.3 where a platen that is 8 mm wider begins."""

RELIEF = 0.8
"""Above this part of its height the sections of a sample shrink, as its top is not flat."""

MOST_NOTCH = 0.1
"""Depth of a notch in a section over the root of its area. It is 0.05 at most in the samples of the
cohorts, and 0.13 where a piece of half the width touches a sample."""

NOTCHED_AT = (0.25, 0.5, 0.75)
"""Heights of the sections in which notches are looked for, over that of the sample."""

AS_SCANNED = "give the image as scanned: its boundary is known to about half a voxel only"

CURE = "give an image of the sample alone, or a mask of it in column segmentation"


def bright_beside(
    share: Array, mask: Mask, spacing: Array, margin: float, to_sample: Array
) -> Iterator[str]:
    """What to say of bright things below, beside or above a sample: they move its boundary.

    Parameters
    ----------
    share : (nx, ny, nz) float64
        Brightness from that of the surroundings (0) to that of tissue (1).
    mask : (nx, ny, nz) bool
        Sample.
    spacing : (3,) float64
        Voxel edges [m].
    margin : float
        Voxels closer to the sample than this [m] are partly tissue.
    to_sample : (4, 4) float64
        From voxel index to the sample frame [m].
    """
    depth, nearest = ndimage.distance_transform_edt(~mask, sampling=spacing, return_indices=True)
    shell = (depth > margin) & (depth < margin + REACH_MM * MM)
    away = np.argwhere(shell) - nearest[:, shell].T
    height = (away @ to_sample[:3, :3].T)[:, 2] / depth[shell]
    sides = {"below": height < -0.8, "beside": np.abs(height) < 0.3, "above": height > 0.8}
    for where, there in sides.items():
        level = float(np.median(share[shell][there])) if np.count_nonzero(there) > 100 else 0.0
        if level > BRIGHT_BESIDE:
            yield (
                f"what lies {where} the sample is {100.0 * level:.0f} % as bright as its tissue, "
                f"such as a visible platen or fluid, and moves its boundary outward; {CURE}"
            )


def unlike_a_scan(noise: float, shared_noise: float, found: Boundary) -> Iterator[str]:
    """What to say of an image whose edges or noise are not those of a scan.

    Parameters
    ----------
    noise : float
        Of the surroundings; NaN if they have none.
    shared_noise : float
        Part of its variance that neighbouring voxels share.
    """
    if not np.isfinite(noise):
        yield f"the surroundings of the sample have no noise, as if masked; {AS_SCANNED}"
    elif shared_noise > MOST_SHARED:
        yield (
            f"neighbouring voxels share {100.0 * shared_noise:.0f} % of their noise, as if "
            f"zero-filled, interpolated or filtered; {AS_SCANNED}"
        )
    elif found.misfit is not None and not found.is_fitted:
        yield (
            f"voxels at its boundary differ from those of a scan by {found.misfit:.2g} times the "
            f"noise; {AS_SCANNED}"
        )


def odd_sections(distance: Array, origin: Array, spacing: float) -> Iterator[str]:
    """What to say of sections that jump in size or have a notch: another thing is part of them.

    The parameters are those of `softsample.imaging.measure.measure`.
    """
    inside = np.clip(0.5 - distance / spacing, 0.0, 1.0)
    base = round(float(-origin[2] / spacing))
    areas = spacing**2 * inside.sum(axis=(0, 1))[base:]
    top = int(np.count_nonzero(areas > 0.5 * np.median(areas[areas > 0.0])))
    apart = max(1, round(STEP_MM * MM / spacing))
    step = np.diff(np.log(np.maximum(areas[1:top], spacing**2)))
    step = np.convolve(step, np.ones(apart), "valid")
    step[(step < 0.0) & (np.arange(len(step)) > RELIEF * top - apart)] = 0.0
    if len(step) and np.abs(step).max() > MOST_STEP:
        worst = int(np.abs(step).argmax())
        yield (
            f"its section {'grows' if step[worst] > 0.0 else 'shrinks'} by "
            f"{100.0 * abs(np.expm1(step[worst])):.0f} % at a height of "
            f"{(worst + 1 + 0.5 * apart) * spacing / MM:.2g} mm, so that a visible platen or "
            f"holder may be part of it; {CURE}"
        )
    sections = [distance[:, :, base + int(part * top)] < 0.0 for part in NOTCHED_AT]
    notch = max(_notch(section) * spacing for section in sections)
    if notch > MOST_NOTCH * np.sqrt(np.median(areas[:top])):
        yield (
            f"its section has a notch of {notch / MM:.2g} mm, so that another piece that touches "
            f"it may be part of it; {CURE}"
        )


def _notch(section: Mask) -> float:
    """Depth of the deepest notch of a section below its convex hull, in grid points."""
    points = np.argwhere(section)
    if len(points) < 3 or min(np.ptp(points, axis=0)) == 0:
        return 0.0
    hull = convex_hull_image(section, offset_coordinates=False)
    depth = ndimage.distance_transform_edt(np.pad(hull, 1))[1:-1, 1:-1]
    return float(depth[~ndimage.binary_fill_holes(section)].max())
