"""NIfTI volumes (`.nii`, `.nii.gz`), whose world is RAS+ already."""

import nibabel
import numpy as np
from nibabel.filebasedimages import ImageFileError

from softsample.errors import InputError
from softsample.formats import PathLike, Volume


def read(path: PathLike) -> Volume:
    """Read a NIfTI volume; see `softsample.formats.read_image`."""
    try:
        image = nibabel.load(path)
        data = np.asarray(image.dataobj, dtype=np.float32)
    except (ImageFileError, EOFError, OSError, ValueError) as error:
        raise InputError(
            f"{path}: not a readable NIfTI image ({error}); export it again as .nii or .nii.gz"
        ) from error
    if data.ndim == 4 and data.shape[3] == 1:
        data = data[..., 0]
    if data.ndim != 3:
        raise InputError(f"{path}: image has shape {data.shape}; give one three-dimensional volume")
    if image.header["sform_code"] == 0 and image.header["qform_code"] == 0:
        raise InputError(
            f"{path}: has no affine (sform and qform are unset), so that neither axes nor place are"
            " known; export the image with its geometry"
        )
    return data, np.asarray(image.affine, dtype=np.float64)
