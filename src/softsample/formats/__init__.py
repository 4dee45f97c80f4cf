"""Images as labs keep them: NIfTI, NRRD, segmentations of 3D Slicer, DICOM folders."""

import math
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from softsample.arrays import Array
from softsample.errors import InputError
from softsample.files import PathLike

Volume = tuple[NDArray[np.float32], Array]
"""Values (nx, ny, nz) and affine (4, 4) from voxel index to world RAS+ [mm]."""

LPS_TO_RAS = np.diag([-1.0, -1.0, 1.0, 1.0])
"""World of DICOM and of Slicer's files (left, posterior, superior) to ours; its own inverse."""

MOST_VOXELS = 2**29
"""Larger volumes are refused before room is made for them: their header may lie."""

IMAGE_ENDINGS = (".nii", ".nii.gz", ".nrrd", ".nhdr")
"""How a file with an image ends; a folder is taken for a DICOM series."""


def header_doubts(path: PathLike) -> list[str]:
    """What to say of the header of a volume that `read_image` reads."""
    from softsample.formats import nifti

    return list(nifti.doubts(path)) if os.fspath(path).lower().endswith((".nii", ".nii.gz")) else []


def read_image(path: PathLike, segments: Sequence[str] = ()) -> Volume:
    """Read a volume of any supported format; the world comes back as RAS+ in mm.

    Parameters
    ----------
    path
        `.nii`, `.nii.gz`, `.nrrd`, `.nhdr`, `.seg.nrrd`, or a folder with one DICOM series.
    segments
        Names, in order of preference, of the segment that is wanted of a segmentation made in
        3D Slicer (upper and lower case count as the same); the only one is taken by any name.
        Without names the labels of all segments are read. Ignored for other files.

    Returns
    -------
    data : (nx, ny, nz) float32
        Intensities or labels; of one segment, 1 inside and 0 outside.
    affine : (4, 4) float64
        From voxel index to world RAS+ [mm].

    Raises
    ------
    InputError
        If there is no single volume with a known place in the world; names file and cure.
    """
    from softsample.formats import dicom, nifti, nrrd  # each loads a library of its own

    name = os.fspath(path).lower()
    with damage_refused(path):
        if Path(path).is_dir():
            return dicom.read(path)
        if not Path(path).is_file():
            raise InputError(f"{path}: no such image; correct its path")
        if name.endswith((".nrrd", ".nhdr")):
            return nrrd.read(path, segments)
        if name.endswith((".nii", ".nii.gz")):
            return nifti.read(path)
    raise InputError(
        f"{path}: not an image of a known kind; give {', '.join(IMAGE_ENDINGS)} or a DICOM folder"
    )


@contextmanager
def damage_refused(path: PathLike) -> Iterator[None]:
    """Turn whatever a library raises on a damaged file into an `InputError`.

    The libraries name no common type for it: an image from outside may make them raise anything.
    """
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        what = str(error).split("\n")[0] or type(error).__name__
        raise InputError(f"{path}: damaged or not of its kind ({what}); export it again") from error


def check_size(sizes: Iterable[int], path: PathLike) -> None:
    """Refuse a volume whose header claims an impossible number of voxels."""
    numbers = [int(size) for size in sizes]
    if min(numbers, default=0) < 1 or math.prod(numbers) > MOST_VOXELS:
        raise InputError(
            f"{path}: a volume of {' x '.join(map(str, numbers))} voxels cannot be read; crop the "
            "image to the sample, or export it again"
        )


def within(file: PathLike, folder: PathLike) -> bool:
    """Whether a file, with all links followed, lies in a folder."""
    return Path(file).resolve().is_relative_to(Path(folder).resolve())


def files_of(path: PathLike) -> list[str]:
    """The path of an image and, behind it, the files that its content lies in besides.

    These are the files of a DICOM folder, and the data files that a `.nhdr` header names. An
    edited slice is then seen, which leaves the time stamp of its folder as it was.
    """
    image = Path(path)
    if image.is_dir():
        parts = [file for file in image.iterdir() if file.is_file() and file.name[0] != "."]
    elif image.suffix.lower() == ".nhdr" and image.is_file():
        lines = image.read_text(encoding="utf-8", errors="replace").splitlines()
        names = (re.sub(r"^data ?file:", "", line).strip() for line in lines)
        parts = [image.parent / name for name in names if name]
        parts = [file for file in parts if file != image and within(file, image.parent)]
        parts = [file for file in parts if file.is_file()]
    else:
        parts = []
    return [os.fspath(path), *sorted(map(str, parts))]
