"""NRRD volumes, and segmentations of 3D Slicer (`.seg.nrrd`), which are NRRD with segments.

The fields are described in [1]_ and [2]_.

References
----------
.. [1] G. Kindlmann, Definition of NRRD file format, https://teem.sourceforge.net/nrrd/format.html
.. [2] 3D Slicer, developer guide, segmentations,
   https://slicer.readthedocs.io/en/latest/developer_guide/modules/segmentations.html
"""

import bz2
import gzip
import os
import re
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import nrrd
import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsample.arrays import Array
from softsample.errors import InputError
from softsample.files import PathLike
from softsample.formats import LPS_TO_RAS, Volume, check_size, within

SPACES = {
    "left-posterior-superior": LPS_TO_RAS,
    "lps": LPS_TO_RAS,
    "right-anterior-superior": np.eye(4),
    "ras": np.eye(4),
    "left-anterior-superior": np.diag([-1.0, 1.0, 1.0, 1.0]),
    "las": np.diag([-1.0, 1.0, 1.0, 1.0]),
}
"""Maps to RAS+ of the worlds that can be told apart."""

TISSUE = (
    "Segmentation category and type - 3D Slicer General Anatomy list"
    "~SCT^85756007^Tissue~SCT^85756007^Tissue~^^~Anatomic codes - DICOM master list~^^~^^"
)
"""What Slicer calls a segment of tissue that is not named further."""

COLOUR = "0.95 0.55 0.35"

LARGEST_VALUE = 8
"""Bytes of a voxel at most."""

CHUNK = 2**20


@dataclass(frozen=True)
class Segment:
    """One segment of a segmentation: where its name, layer and label are."""

    name: str
    layer: int
    label: int


def read(path: PathLike, segments: Sequence[str] = ()) -> Volume:
    """Read a NRRD volume or a segment of a `.seg.nrrd`; see `softsample.formats.read_image`."""
    try:
        _check_files(path)
        data, header = nrrd.read(os.fspath(path))
    except InputError:
        raise
    except (nrrd.NRRDError, OSError, EOFError, ValueError, KeyError, zlib.error) as error:
        raise InputError(
            f"{path}: not a readable NRRD image ({error}); save it again, a .nhdr together with "
            "its data file"
        ) from error
    layers, affine = _placed(data, header, path)
    found = _segments(header)
    if found:
        return _chosen(layers, found, segments, header, path), affine
    if len(layers) != 1:
        raise InputError(f"{path}: image has shape {data.shape}; give one three-dimensional volume")
    return layers[0].astype(np.float32), affine


def _check_files(path: PathLike) -> None:
    """Refuse data that lie outside the folder of the header, or are not of the size it tells."""
    with open(path, "rb") as stream:
        header = nrrd.read_header(stream)
        check_size(header["sizes"], path)
        name = header.get("data file", header.get("datafile"))
        if name is None:
            _check_inflated(stream, header, path)
            return
    data = Path(path).parent / name
    if not within(data, Path(path).parent):
        raise InputError(
            f"{path}: its data file {name!r} lies outside its folder; put both into one folder, "
            "and name the data by its name alone"
        )
    with open(data, "rb") as stream:
        _check_inflated(stream, header, path)


def _check_inflated(stream: IO[bytes], header: Mapping[str, Any], path: PathLike) -> None:
    """Refuse compressed data that unpack to far more than the header tells."""
    unpackers: dict[str, Any] = dict.fromkeys(("gz", "gzip"), gzip.open)
    unpackers |= dict.fromkeys(("bz2", "bzip2"), bz2.open)
    unpack = unpackers.get(str(header.get("encoding")))
    if unpack is None:
        return
    for _ in range(int(header.get("line skip", header.get("lineskip", 0)))):
        stream.readline()
    left = LARGEST_VALUE * int(np.prod([int(size) for size in header["sizes"]])) + CHUNK
    with unpack(stream) as unpacked:
        while chunk := unpacked.read(CHUNK):
            left -= len(chunk)
            if left < 0:
                raise InputError(f"{path}: unpacks to more than its header tells; export it again")


def _placed(
    data: NDArray[Any], header: Mapping[str, Any], path: PathLike
) -> tuple[NDArray[Any], Array]:
    """Volumes (layers, nx, ny, nz) of a file, one as a rule, and their affine to RAS+ [mm]."""
    for field in ("space", "space directions", "space origin"):
        if header.get(field) is None:
            raise InputError(
                f"{path}: the header has no field {field!r}, so that the place of the image in "
                "the world is not known; save the image with its geometry, in 3D Slicer for one"
            )
    to_ras = SPACES.get(str(header["space"]).lower())
    if to_ras is None:
        raise InputError(
            f"{path}: space {header['space']!r} is not tied to the body; save the image as "
            "left-posterior-superior or right-anterior-superior"
        )
    units = {str(unit).strip('"') for unit in header.get("space units", [])} - {"mm"}
    if units:
        raise InputError(f"{path}: space units {', '.join(sorted(units))}; save the image in mm")
    directions = np.array(header["space directions"], dtype=np.float64)
    spatial = np.flatnonzero(np.all(np.isfinite(directions), axis=1))
    if directions.shape[1] != 3 or len(spatial) != 3:
        raise InputError(
            f"{path}: {len(spatial)} axes have a direction in space, of sizes "
            f"{' '.join(map(str, data.shape))}; give one three-dimensional volume"
        )
    layers = np.moveaxis(data, spatial, (-3, -2, -1))
    affine = np.eye(4)
    affine[:3, :3] = directions[spatial].T
    affine[:3, 3] = header["space origin"]
    return layers.reshape(-1, *layers.shape[-3:]), to_ras @ affine


def _segments(header: Mapping[str, Any]) -> list[Segment]:
    """Segments that a header lists, in their order; none if the file is a plain image.

    Files from before layers were known (Slicer 4.10) have each segment, as 1, in one of its own.
    """
    keys = (re.fullmatch(r"Segment(\d+)_(?:ID|Name)", key) for key in header)
    numbers = sorted({int(key[1]) for key in keys if key})

    def field(number: int, name: str, default: Any) -> Any:
        return header.get(f"Segment{number}_{name}", default)

    return [
        Segment(
            str(field(number, "Name", field(number, "ID", ""))),
            int(field(number, "Layer", number)),
            int(field(number, "LabelValue", 1)),
        )
        for number in numbers
    ]


def _chosen(
    layers: NDArray[Any],
    found: Sequence[Segment],
    wanted: Sequence[str],
    header: Mapping[str, Any],
    path: PathLike,
) -> NDArray[np.float32]:
    """The wanted segment as 1 on 0, or the labels of all if none is named."""
    listed = ", ".join(repr(segment.name) for segment in found)
    if "Fractional" in str(
        header.get("Segmentation_SourceRepresentation")
        or header.get("Segmentation_MasterRepresentation")
    ):
        raise InputError(f"{path}: a fractional labelmap; convert it to a binary one in 3D Slicer")
    if max(segment.layer for segment in found) >= len(layers):
        raise InputError(f"{path}: lacks layers of its segments ({listed}); save it again")
    if not wanted:
        if len(layers) > 1:
            raise InputError(
                f"{path}: the segments {listed} may overlap, so that they are no labels; export "
                "them as a labelmap (module Segmentations of 3D Slicer)"
            )
        return layers[0].astype(np.float32)
    names = [segment.name.casefold() for segment in found]
    matches = [names.index(name.casefold()) for name in wanted if name.casefold() in names]
    if not matches and len(found) > 1:
        asked = " or ".join(repr(name) for name in wanted)
        raise InputError(
            f"{path}: holds the segments {listed}; name the one that is wanted {asked}, or keep "
            "it alone"
        )
    segment = found[matches[0] if matches else 0]
    inside = layers[segment.layer] == segment.label
    if not inside.any():
        raise InputError(f"{path}: segment {segment.name!r} is empty; choose another file")
    return inside.astype(np.float32)


def segmentation_bytes(mask: ArrayLike, affine: ArrayLike, name: str) -> bytes:
    """Content of a `.seg.nrrd` with one segment, as 3D Slicer writes it but without a date.

    Parameters
    ----------
    mask : (nx, ny, nz)
        Not zero inside the segment.
    affine : (4, 4)
        From voxel index to world RAS+ [mm].
    name
        Of the segment.
    """
    inside = np.asarray(mask) != 0
    to_world = LPS_TO_RAS @ np.asarray(affine, dtype=np.float64)
    vectors = ["(" + ",".join(f"{x:.17g}" for x in column) + ")" for column in to_world[:3].T]
    ends = [
        np.flatnonzero(inside.any(axis=tuple({0, 1, 2} - {axis})))[[0, -1]] for axis in range(3)
    ]
    segment = {
        "Color": COLOUR,
        "ColorAutoGenerated": 0,
        "Extent": " ".join(str(end) for pair in ends for end in pair),
        "ID": name,
        "LabelValue": 1,
        "Layer": 0,
        "Name": name,
        "NameAutoGenerated": 0,
        "Tags": f"TerminologyEntry:{TISSUE}|",
    }
    lines = [
        "NRRD0004",
        "type: unsigned char",
        "dimension: 3",
        "space: left-posterior-superior",
        f"sizes: {' '.join(map(str, inside.shape))}",
        f"space directions: {' '.join(vectors[:3])}",
        "kinds: domain domain domain",
        "encoding: gzip",
        f"space origin: {vectors[3]}",
        *(f"Segment0_{key}:={value}" for key, value in segment.items()),
        "Segmentation_ContainedRepresentationNames:=Binary labelmap|Closed surface|",
        "Segmentation_ConversionParameters:=",
        "Segmentation_MasterRepresentation:=Binary labelmap",  # up to Slicer 5.0
        "Segmentation_SourceRepresentation:=Binary labelmap",
        "Segmentation_ReferenceImageExtentOffset:=0 0 0",
    ]
    voxels = inside.astype(np.uint8).tobytes(order="F")
    return "\n".join([*lines, "", ""]).encode() + gzip.compress(voxels, mtime=0)
