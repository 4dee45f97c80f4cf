"""NIfTI volumes (`.nii`, `.nii.gz`), whose world is RAS+ already."""

from typing import Any

import nibabel
import numpy as np
from nibabel.filebasedimages import ImageFileError

from softsample.errors import InputError
from softsample.files import PathLike
from softsample.formats import Volume, check_size


def read(path: PathLike) -> Volume:
    """Read a NIfTI volume; see `softsample.formats.read_image`."""
    try:
        image = nibabel.load(path)
        check_size(image.shape, path)
        _check_header(image.header, path)
        data = np.asarray(image.dataobj, dtype=np.float32)
    except InputError:
        raise
    except (ImageFileError, EOFError, OSError, ValueError) as error:
        raise InputError(
            f"{path}: not a readable NIfTI image ({error}); export it again as .nii or .nii.gz"
        ) from error
    if data.ndim == 4 and data.shape[3] == 1:
        data = data[..., 0]
    if data.ndim != 3:
        raise InputError(f"{path}: image has shape {data.shape}; give one three-dimensional volume")
    return data, np.asarray(image.affine, dtype=np.float64)


def _check_header(header: Any, path: PathLike) -> None:
    """Refuse complex or colour values, no place in the world, and lengths that are not in mm."""
    if header.get_data_dtype().kind not in "iuf":
        raise InputError(f"{path}: values of type {header.get_data_dtype()}; export magnitudes")
    if header["sform_code"] == 0 and header["qform_code"] == 0:
        raise InputError(
            f"{path}: has no affine (sform and qform are unset), so that neither axes nor place are"
            " known; export the image with its geometry"
        )
    unit = header.get_xyzt_units()[0]
    if unit not in ("mm", "unknown"):
        raise InputError(f"{path}: its header gives lengths in {unit}; export the image in mm")
