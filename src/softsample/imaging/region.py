"""The region of an image that is the sample: one, whole, large enough, and no ring."""

import numpy as np
from scipy import ndimage

from softsample.arrays import Array, Mask
from softsample.errors import SegmentationError
from softsample.imaging.checked import voxel_size
from softsample.imaging.settings import SegmentationSettings
from softsample.units import MM

LEFT_OUT = 0.05
"""A region that is larger than this beside the sample may be a part of it, in its volumes."""

MOST_OF_RIM = 0.5
"""Part of the outermost voxels of an image that may be bright: holders and samples that touch the
edge take less."""

MOST_ENCLOSED = 0.2
"""Part of the sections of a sample that it may enclose: a bubble of half its width does 0.1, tubes
and baths 0.3 to 0.5."""


def refuse_bright_rim(bright: Mask) -> None:
    """Refuse an image most of whose rim is as bright as a sample, which air about it is not."""
    inside = tuple(slice(1, n - 1) for n in bright.shape)
    rim = np.ones_like(bright)
    rim[inside] = False
    share = float(bright[rim].mean())
    if share > MOST_OF_RIM:
        raise SegmentationError(
            f"{100.0 * share:.0f} % of the rim of the image are bright, as a bath or a reversed"
            " contrast has it; give an image of the sample in air, brighter than its surroundings,"
            " or a mask of it in column segmentation"
        )


def left_out(regions: Mask, spacing: Array) -> float:
    """Volume [m3] of what is largest beside the sample; zero if it is small beside it.

    Refuses what is more than half as large as the sample.
    """
    labels, _ = ndimage.label(regions)
    sizes = np.bincount(labels.ravel())[1:] * float(np.prod(spacing))
    first, second = np.sort(np.append(sizes, [0.0, 0.0]))[[-1, -2]]
    if second > 0.5 * first:
        raise SegmentationError(
            f"two samples found, of {first / MM**3:.0f} and {second / MM**3:.0f} mm3; crop the "
            "image to one, or keep one region of a mask"
        )
    return float(second) if second > LEFT_OUT * first else 0.0


def check_component(mask: Mask, spacing: Array, settings: SegmentationSettings) -> None:
    """Refuse a sample that is too small or cut by the edge of the image."""
    volume = np.count_nonzero(mask) * np.prod(spacing) / MM**3
    if volume < settings.min_volume_mm3:
        raise SegmentationError(
            f"no sample found: the largest region has {volume:.3g} mm3, at least"
            f" {settings.min_volume_mm3:g} mm3 are expected; check the image and its scale"
        )
    for axis, name in enumerate("ijk"):
        for side, index in (("first", 0), ("last", -1)):
            if np.take(mask, index, axis=axis).any():
                raise SegmentationError(
                    f"sample touches the edge of the field of view ({side} slice along {name});"
                    " give an image of the whole sample"
                )


def refuse_surrounded(solid: Mask, to_world: Array, up: Array) -> None:
    """Refuse a sample whose sections are rings: a container, or a bath about the sample."""
    sections = from_above(solid, to_world, up)
    filled = sum(np.count_nonzero(ndimage.binary_fill_holes(section)) for section in sections)
    enclosed = 1.0 - np.count_nonzero(solid) / filled
    if enclosed > MOST_ENCLOSED:
        raise SegmentationError(
            f"the brightest region encloses {100.0 * enclosed:.0f} % of its sections: it looks "
            "like a container, or fluid about a sample; give an image of the sample in air, or "
            "a mask in column segmentation"
        )


def from_above(mask: Mask, to_world: Array, up: Array) -> Mask:
    """Sections across the image's axis that is nearest to the loading axis, the highest first."""
    along = up @ (to_world[:3, :3] / voxel_size(to_world))
    axis = int(np.abs(along).argmax())
    sections = np.moveaxis(mask, axis, 0)
    return sections[::-1] if along[axis] > 0.0 else sections
