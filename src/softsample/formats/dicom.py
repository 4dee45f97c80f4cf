"""One DICOM series in a folder: single slices, or an enhanced multi-frame image.

Positions are those of the Image Plane Module [1]_: a voxel's place is ImagePositionPatient plus
column times column spacing along the first three numbers of ImageOrientationPatient plus row
times row spacing along the last three, in LPS. File names and instance numbers are not used.

References
----------
.. [1] DICOM PS3.3, section C.7.6.2.1.1, equation C.7.6.2.1-1,
   https://dicom.nema.org/medical/dicom/current/output/chtml/part03/sect_C.7.6.2.html
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pydicom
from numpy.typing import NDArray
from pydicom.errors import InvalidDicomError
from pydicom.uid import DeflatedExplicitVRLittleEndian

from softsample.arrays import Array
from softsample.errors import InputError
from softsample.files import PathLike
from softsample.formats import LPS_TO_RAS, Volume, check_size, damage_refused, within

SAME_DIRECTION = 1e-3
"""Components of directions that differ by less are the same."""

SAME_STEP = 0.02
"""Part of the step between slices by which one of them may lie off its place."""


@dataclass(frozen=True, eq=False)
class Slice:
    """One slice with its place.

    Parameters
    ----------
    file : str
        Name in the folder, with the frame's number if it has many, for messages.
    values : (columns, rows) float32
        Rescaled.
    along : (2, 3) float64
        Steps of one column and of one row, LPS [mm].
    position : (3,) float64
        Centre of the first voxel, LPS [mm].
    """

    file: str
    values: NDArray[np.float32]
    along: Array
    position: Array

    @property
    def normal(self) -> Array:
        """(3,) unit vector that is right-handed with columns and rows."""
        across = np.cross(*self.along)
        return np.asarray(across / np.linalg.norm(across))


def read(folder: PathLike) -> Volume:
    """Read the series in a folder; see `softsample.formats.read_image`.

    Files that are not DICOM or hold no image are passed over; folders within are not entered.
    """
    datasets, where = _series(folder)
    slices = [slice_ for dataset, file in datasets for slice_ in _slices(dataset, file, where)]
    first = slices[0]
    for other in slices[1:]:
        if first.values.shape != other.values.shape or not np.allclose(
            first.along, other.along, rtol=0.0, atol=SAME_DIRECTION * np.abs(first.along).max()
        ):
            raise InputError(
                f"{where}: {other.file} differs from {first.file} in orientation, size or "
                "PixelSpacing; keep the slices of one volume, without localisers"
            )
    slices.sort(key=lambda slice_: float(slice_.position @ first.normal))
    affine = np.eye(4)
    affine[:3, 0], affine[:3, 1] = first.along
    affine[:3, 2] = _step(slices, where)
    affine[:3, 3] = slices[0].position
    return np.stack([slice_.values for slice_ in slices], axis=-1), LPS_TO_RAS @ affine


def _series(folder: PathLike) -> tuple[list[tuple[pydicom.Dataset, str]], str]:
    """Data sets with an image and their files' names; folder and series in words."""
    found: dict[str, list[tuple[pydicom.Dataset, str]]] = {}
    for path in sorted(Path(folder).iterdir()):
        if path.is_file() and not path.name.startswith("."):
            if not within(path, folder):
                raise InputError(f"{path}: is a link to outside its folder; copy the file itself")
            with damage_refused(path):
                try:
                    _check_packing(path)
                    dataset = pydicom.dcmread(path)
                except InvalidDicomError:
                    continue
            if "PixelData" in dataset:
                series = str(dataset.get("SeriesInstanceUID", "?"))
                found.setdefault(series, []).append((dataset, path.name))
    if not found:
        raise InputError(
            f"{folder}: holds no DICOM image; name the folder that holds the slices themselves"
        )
    words = [_in_words(datasets) for datasets in found.values()]
    if len(found) > 1:
        raise InputError(
            f"{folder}: holds {len(found)} series ({'; '.join(words)}); move each into a folder "
            "of its own and name that of the sample"
        )
    return next(iter(found.values())), f"{folder}, series {words[0]}"


def _check_packing(path: Path) -> None:
    """Refuse a file that is compressed as a whole: it may unpack to anything."""
    meta = pydicom.filereader.read_file_meta_info(path)
    if meta.get("TransferSyntaxUID") == DeflatedExplicitVRLittleEndian:
        raise InputError(f"{path}: a deflated data set; export the series without compression")


def _in_words(datasets: list[tuple[pydicom.Dataset, str]]) -> str:
    """Number, description and files of a series, for messages."""
    dataset, file = datasets[0]
    title = f"{dataset.get('SeriesNumber', '?')} {dataset.get('SeriesDescription', '')!r}"
    return f"{title} with {len(datasets)} files from {file} on"


def _slices(dataset: pydicom.Dataset, file: str, where: str) -> Iterator[Slice]:
    """The slices of one data set."""
    frames = int(dataset.get("NumberOfFrames", 1) or 1)
    if dataset.get("SamplesPerPixel", 1) != 1:
        raise InputError(f"{where}: {file} is a colour image; export the grey values")
    check_size((dataset.get("Rows", 0), dataset.get("Columns", 0), frames), f"{where}: {file}")
    try:
        pixels = dataset.pixel_array
    except Exception as error:  # pydicom names no common type for what its decoders raise
        raise InputError(
            f"{where}: the pixels of {file} cannot be read ({error}); export the series again, "
            "without compression"
        ) from error
    stack = pixels.reshape(frames, *pixels.shape[-2:])
    for number, values in enumerate(stack):
        name = f"frame {number + 1} of {file}" if frames > 1 else file
        place = _Frame(dataset, number, name, where)
        rows, columns = place.numbers("PixelMeasuresSequence", "PixelSpacing", 2)
        direction = place.numbers("PlaneOrientationSequence", "ImageOrientationPatient", 6)
        unit = direction.reshape(2, 3)
        if not np.allclose(unit @ unit.T, np.eye(2), rtol=0.0, atol=SAME_DIRECTION):
            raise InputError(
                f"{where}: ImageOrientationPatient of {name} is {direction.tolist()}, not two "
                "unit vectors at a right angle; export the series again"
            )
        slope, intercept = (
            place.numbers("PixelValueTransformationSequence", key, 1, default)[0]
            for key, default in (("RescaleSlope", 1.0), ("RescaleIntercept", 0.0))
        )
        yield Slice(
            name,
            (slope * values.T + intercept).astype(np.float32),
            unit * [[columns], [rows]],
            place.numbers("PlanePositionSequence", "ImagePositionPatient", 3),
        )


@dataclass(frozen=True, eq=False)
class _Frame:
    """One frame of a data set, whose attributes may stand in functional groups."""

    dataset: pydicom.Dataset
    number: int
    name: str
    where: str

    def numbers(self, group: str, key: str, count: int, default: float | None = None) -> Array:
        """(count,) values of an attribute, of the frame's own group before the shared one."""
        value = next((part[key].value for part in self._parts(group) if part.get(key)), default)
        found = np.atleast_1d(np.array([] if value is None else value, dtype=np.float64))
        if found.shape != (count,):
            raise InputError(
                f"{self.where}: {self.name} has no {key}, so that its place is not known; export "
                "the original images, not a secondary capture"
            )
        return found

    def _parts(self, group: str) -> Iterator[Any]:
        """Data sets that may hold an attribute of this frame."""
        if "PerFrameFunctionalGroupsSequence" in self.dataset:
            shared = self.dataset.get("SharedFunctionalGroupsSequence") or []
            for groups in (self.dataset.PerFrameFunctionalGroupsSequence[self.number], *shared):
                yield from groups.get(group) or []
        elif int(self.dataset.get("NumberOfFrames", 1) or 1) == 1:
            yield self.dataset


def _step(slices: list[Slice], where: str) -> Array:
    """(3,) step from each slice to the next, LPS [mm], if they are equally spaced."""
    if len(slices) < 2:
        raise InputError(f"{where}: one slice is no volume; export the whole series")
    places = np.array([slice_.position for slice_ in slices])
    gaps = np.diff(places @ slices[0].normal)
    usual = float(np.median(gaps))
    at = int(np.argmin(gaps))
    if gaps[at] <= SAME_STEP * max(usual, float(gaps.max())):
        raise InputError(
            f"{where}: {slices[at].file} and {slices[at + 1].file} lie at the same place; keep one "
            "echo, phase or time point"
        )
    at = int(np.argmax(np.abs(gaps - usual)))
    if abs(gaps[at] - usual) > SAME_STEP * usual:
        raise InputError(
            f"{where}: {gaps[at]:.4g} mm lie between {slices[at].file} and {slices[at + 1].file}, "
            f"{usual:.4g} mm as a rule; slices are missing, export the whole series"
        )
    step = np.asarray((places[-1] - places[0]) / (len(slices) - 1))
    off = np.linalg.norm(places - places[0] - np.outer(np.arange(len(slices)), step), axis=1)
    lean = np.degrees(np.arccos(np.clip(step @ slices[0].normal / np.linalg.norm(step), -1.0, 1.0)))
    if off.max() > SAME_STEP * usual or np.radians(lean) > SAME_STEP:
        raise InputError(
            f"{where}: the slices are not stacked along their normal ({lean:.2g} degrees off, or "
            "staggered), like those of a tilted gantry; resample the volume, in 3D Slicer for one"
        )
    return step
