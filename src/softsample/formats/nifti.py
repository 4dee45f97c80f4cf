"""NIfTI volumes (`.nii`, `.nii.gz`), whose world is RAS+ already."""

from collections.abc import Iterator
from typing import Any

import nibabel
import numpy as np
from nibabel.filebasedimages import ImageFileError

from softsample.errors import InputError
from softsample.files import PathLike
from softsample.formats import Volume, check_size

IN_MM = {"mm": 1.0, "unknown": 1.0, "meter": 1000.0, "micron": 0.001}
"""Units of length that a header may tell [mm]; an unknown one is a millimetre by convention."""

AGREE = 0.5
"""Distance, in voxel edges, by which the places of a voxel by sform and qform may differ."""


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
    to_mm = np.diag([*[_unit(image.header)] * 3, 1.0])
    return data, np.asarray(to_mm @ image.affine, dtype=np.float64)


def _unit(header: Any) -> float:
    """Unit of the affine [mm]."""
    return IN_MM[header.get_xyzt_units()[0]]


def doubts(path: PathLike) -> Iterator[str]:
    """What to say of a readable volume whose two affines, sform and qform, tell other places."""
    header = nibabel.load(path).header
    if header["sform_code"] == 0 or header["qform_code"] == 0:
        return
    sform, qform = header.get_sform(), header.get_qform()
    corners = np.indices((2, 2, 2)).reshape(3, -1) * np.array(header.get_data_shape()[:3])[:, None]
    apart = (sform - qform) @ np.vstack([corners, np.ones(8)])
    furthest = float(np.linalg.norm(apart[:3], axis=0).max())
    if furthest > AGREE * float(np.linalg.norm(sform[:3, :3], axis=0).min()):
        yield (
            f"{path}: its sform and its qform differ by up to {_unit(header) * furthest:.3g} mm; "
            "the sform is used: export the image again, or set both to the one that is right"
        )


def _check_header(header: Any, path: PathLike) -> None:
    """Refuse complex or colour values, and no place in the world."""
    if header.get_data_dtype().kind not in "iuf":
        raise InputError(f"{path}: values of type {header.get_data_dtype()}; export magnitudes")
    if header["sform_code"] == 0 and header["qform_code"] == 0:
        raise InputError(
            f"{path}: has no affine (sform and qform are unset), so that neither axes nor place are"
            " known; export the image with its geometry"
        )
