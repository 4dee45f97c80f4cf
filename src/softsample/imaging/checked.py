"""What is given with a sample: an image, its voxels and its directions, checked."""

import numpy as np
from numpy.typing import ArrayLike

from softsample.arrays import Array
from softsample.errors import InputError
from softsample.units import MM


def voxel_size(affine: Array) -> Array:
    """Edges of a voxel, (3,), in the unit of the affine."""
    return np.asarray(np.linalg.norm(affine[:3, :3], axis=0))


def checked_image(data: ArrayLike, affine: ArrayLike) -> tuple[Array, Array]:
    """Image as float64 and its affine in metres, or an `InputError` with the cure."""
    image, to_world = np.asarray(data, dtype=np.float64), np.array(affine, dtype=np.float64)
    if image.ndim != 3 or min(image.shape) < 8:
        raise InputError(
            f"image has shape {image.shape}; give one volume of at least 8 voxels along each axis"
        )
    if to_world.shape != (4, 4) or not np.all(np.isfinite(to_world)):
        raise InputError("the affine of the image must be a finite 4 x 4 matrix; export it again")
    size = voxel_size(to_world)
    if np.any(size < 0.05) or np.any(size > 2.0):
        raise InputError(
            f"voxel size {size.round(4).tolist()} mm is outside 0.05 to 2 mm; check that the"
            " header is in mm"
        )
    if abs(np.linalg.det(to_world[:3, :3])) < 0.5 * np.prod(size):
        raise InputError("the image axes are far from perpendicular; resample the image")
    bad = int(np.count_nonzero(~np.isfinite(image)))
    if bad:
        raise InputError(f"image has {bad} NaN or infinite voxels of {image.size}; export it again")
    if np.ptp(image) == 0.0:
        raise InputError(f"image is {image.flat[0]:g} everywhere; export it again")
    to_world[:3] *= MM
    return image, to_world


def checked_axes(loading: ArrayLike, shear: ArrayLike) -> tuple[Array, Array]:
    """Unit loading axis and unit shear axis, the latter made perpendicular to the former."""
    up, x = np.array(loading, dtype=np.float64), np.array(shear, dtype=np.float64)
    if up.shape != (3,) or x.shape != (3,) or not (np.any(up) and np.any(x)):
        raise InputError(f"loading_axis {up} and shear_axis {x} must be directions")
    up /= np.linalg.norm(up)
    x = x - (x @ up) * up
    if np.linalg.norm(x) < 1e-6:
        raise InputError("loading_axis and shear_axis are parallel; give two different axes")
    return up, x / np.linalg.norm(x)
