"""Fitness of an image for segmentation: units, size, contrast."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import affine_transform

from softsample.arrays import Array
from softsample.errors import InputError

VOXEL_MM = (0.05, 2.0)
EXTENT_MM = (3.0, 500.0)
FEWEST_VOXELS = 12
OFFSET = 0.1
"""A magnitude image lies below zero by less than this part of its range."""

COARSE_MM = 0.75
"""Longer voxels hide where in them the base and the top end: by up to 0.06 of their edge, which the
standard deviation that a segmentation states does not hold."""

CLIPPED = 0.1
"""Of the voxels that are brighter than half the brightest one, fewer than this are as bright."""


def world_axis(name: str) -> Array:
    """(3,) unit vector of an image world axis named as `+z` or `-x`."""
    vector = np.zeros(3)
    vector["xyz".index(name[1])] = {"+": 1.0, "-": -1.0}[name[0]]
    return vector


def check_image(data: NDArray[np.float32], affine: Array, source: str) -> dict[str, Any]:
    """Check a volume and report what it holds.

    Parameters
    ----------
    data : (nx, ny, nz) float32
        Intensities.
    affine : (4, 4) float64
        From voxel index to world [mm].
    source
        The file's path, for the message.

    Returns
    -------
    dict
        `shape`, `voxel_mm`, `extent_mm`, `intensity_percentiles` (1, 50, 99 %).

    Raises
    ------
    InputError
        If the volume cannot be an image of a sample; names value and cure.
    """
    voxel = np.linalg.norm(affine[:3, :3], axis=0)
    if not np.all(np.isfinite(affine)) or np.linalg.matrix_rank(affine[:3, :3]) < 3:
        raise InputError(f"{source}: the affine is singular; export the image with its geometry")
    if abs(np.linalg.det(affine[:3, :3])) < 0.5 * np.prod(voxel):
        raise InputError(f"{source}: the image axes are far from perpendicular; resample the image")
    if voxel.min() < VOXEL_MM[0] or voxel.max() > VOXEL_MM[1]:
        raise InputError(
            f"{source}: voxels of {_sizes(voxel)} mm, expected {VOXEL_MM[0]:g} to {VOXEL_MM[1]:g} "
            "mm; is the header in another unit than mm?"
        )
    extent = voxel * data.shape
    if min(data.shape) < FEWEST_VOXELS:
        raise InputError(
            f"{source}: {_sizes(np.array(data.shape))} voxels; a sample needs at least "
            f"{FEWEST_VOXELS} in each direction"
        )
    if extent.min() < EXTENT_MM[0] or extent.max() > EXTENT_MM[1]:
        raise InputError(
            f"{source}: a field of view of {_sizes(extent)} mm, expected {EXTENT_MM[0]:g} to "
            f"{EXTENT_MM[1]:g} mm; crop the image, or correct its voxel size"
        )
    wrong = np.argwhere(~np.isfinite(data))
    if len(wrong):
        raise InputError(
            f"{source}: {len(wrong)} voxels are NaN or infinite, the first at index "
            f"{tuple(int(i) for i in wrong[0])}; export the image again"
        )
    low, middle, high = (float(value) for value in np.percentile(data, [1, 50, 99]))
    if low < -OFFSET * (high - low):
        raise InputError(
            f"{source}: 1 % of the values lie below {low:.4g}, and 99 % below {high:.4g}; export "
            "magnitudes as scanned, without an offset, which are zero where there is no signal"
        )
    if np.ptp(data) == 0.0:
        raise InputError(f"{source}: the image is constant ({low:g}); choose another file")
    return {
        "shape": list(data.shape),
        "voxel_mm": [float(size) for size in voxel],
        "extent_mm": [float(size) for size in extent],
        "intensity_percentiles": [low, middle, high],
    }


def one_label(mask: NDArray[np.float32], source: str) -> NDArray[np.float32]:
    """The same mask, or an `InputError` if it is not of one sample: one value, and 0 outside."""
    inside = np.unique(mask[mask != 0.0])
    if len(inside) > 1:
        raise InputError(
            f"{source}: has {len(inside)} values that are not 0, {inside[0]:g} to "
            f"{inside[-1]:g}; give a mask of the sample alone, not interpolated, no probability"
        )
    return mask


def on_grid_of(
    image: tuple[NDArray[np.float32], Array], mask: NDArray[np.float32], affine: Array, source: str
) -> NDArray[np.float32]:
    """A mask of any grid on the grid of an image, by the nearest voxel.

    Parameters
    ----------
    image : (nx, ny, nz) float32, (4, 4) float64
        The image and its affine from voxel index to world [mm].
    mask : (mx, my, mz) float32
        Not zero inside the sample; may be cropped to it, as 3D Slicer does.
    affine : (4, 4) float64
        Of the mask, to the same world [mm].
    source
        The mask's path, for the message.

    Returns
    -------
    (nx, ny, nz) float32
        1 inside, 0 outside; voxels beyond the mask are outside.

    Raises
    ------
    InputError
        If the mask marks no voxel of the image.
    """
    if not np.all(np.isfinite(affine)) or np.linalg.matrix_rank(affine[:3, :3]) < 3:
        raise InputError(f"{source}: the affine is singular; export the mask with its geometry")
    data, to_world = image
    to_mask = np.linalg.inv(affine) @ to_world
    inside = (mask != 0.0).astype(np.float32)
    found = affine_transform(
        inside, to_mask, output_shape=data.shape, order=0, mode="grid-constant"
    )
    if not found.any():
        raise InputError(
            f"{source}: marks no voxel of the image; draw the sample on the image itself, and save "
            "both with their geometry"
        )
    return np.asarray(found, dtype=np.float32)


def image_doubts(data: NDArray[np.float32], affine: Array, source: str) -> Iterator[str]:
    """What a volume, which `check_image` accepts, is less fit for, with the cure."""
    longest = float(np.linalg.norm(affine[:3, :3], axis=0).max())
    if longest > COARSE_MM:
        yield (
            f"{source}: voxels of up to {longest:.3g} mm: height and relief may be wrong by more "
            f"than is stated; give slices of {COARSE_MM:g} mm at most"
        )
    values = np.unique(data)
    if len(values) == 2:
        yield (
            f"{source}: has two values only, {values[0]:.4g} and {values[1]:.4g}, as a mask; name "
            "it in column segmentation as well, or give the image as scanned"
        )
        return
    highest = float(values[-1])
    clipped = float(np.mean(data[data > 0.5 * highest] == highest))
    if clipped > CLIPPED:
        yield (
            f"{source}: {100.0 * clipped:.0f} % of the bright voxels have the highest value, "
            f"{highest:.4g}, as if cut off there; export the image with all its values"
        )


def _sizes(values: NDArray[Any]) -> str:
    return " x ".join(f"{value:g}" for value in values)
