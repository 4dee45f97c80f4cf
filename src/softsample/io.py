"""The only reader and writer of files: units in names, atomic, nothing half-written.

Files for people are in mm, N, s and Pa; arrays handed to the library are SI (see each function).
"""

import csv
import gzip
import json
import math
import os
import re
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml
from numpy.typing import ArrayLike, NDArray

from softsample.arrays import Array
from softsample.errors import InputError, MeshError
from softsample.files import written_aside
from softsample.formats import LPS_TO_RAS, PathLike, read_image
from softsample.formats.text import read_lines
from softsample.meshing.marks import MarkedImage
from softsample.meshing.mesh import HexMesh
from softsample.meshing.surface import TriangleSurface
from softsample.records import Record
from softsample.shapes import IdealShape
from softsample.units import MM

VTK_HEXAHEDRON = 12

SAFE_YAML = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""Plain values only; ten times as fast where PyYAML was built with its C library."""

LONGEST_HEADER = 512
"""Bytes of a surface's file in which the name of its space is looked for."""

MOST_VALUES = 100_000
"""A YAML file with more is refused: few lines of aliases can stand for billions."""


def write_text(path: PathLike, text: str) -> None:
    """Write UTF-8 text, atomically."""
    with written_aside(path) as aside:
        aside.write_text(text, encoding="utf-8")


def read_json(path: PathLike) -> Any:
    """Read a JSON file; a damaged one is an `InputError` that names file and place."""
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"))
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not valid JSON ({error}); delete it and run again") from error


def write_json(path: PathLike, data: Mapping[str, Any]) -> None:
    """Write readable JSON, atomically; NumPy values become plain ones.

    Raises
    ------
    InputError
        If a number is NaN or infinite (use None for "not known"); the message names its key.
    """
    text = json.dumps(_plain(data, str(path)), indent=2, ensure_ascii=False, allow_nan=False)
    write_text(path, text + "\n")


def _plain(value: Any, where: str) -> Any:
    """Copy of `value` in the types that JSON knows; `where` names it in an error."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item, f"{where}: {key}") for key, item in value.items()}
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, list | tuple | set | frozenset):
        return [_plain(item, f"{where}[{index}]") for index, item in enumerate(value)]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, float) and not math.isfinite(value):
        raise InputError(f"{where} is {value}; a result must be finite, write null if unknown")
    return value


def read_yaml(path: PathLike) -> Any:
    """Read a YAML file; a damaged one is an `InputError` that names file and line."""
    try:
        content = yaml.load(Path(path).read_text(encoding="utf-8-sig"), SAFE_YAML)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        where = f", line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        raise InputError(
            f"{path}{where}: not valid YAML: {error.problem}; look for a bracket that is not "
            "closed, a missing space behind a colon, or another indentation"
        ) from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:  # a date may be no date
        raise InputError(f"{path}: not valid YAML: {error}") from error
    if _counts(content) > MOST_VALUES:
        raise InputError(f"{path}: holds more than {MOST_VALUES} values, all aliases written out")
    return content


def _counts(content: Any) -> int:
    """Number of values in nested dicts and lists, counted no further than `MOST_VALUES`."""
    todo, seen = [content], 0
    while todo and seen <= MOST_VALUES:
        value, seen = todo.pop(), seen + 1
        if isinstance(value, dict):
            todo += value.values()
        elif isinstance(value, list):
            todo += value
    return seen


def read_table(path: PathLike) -> pd.DataFrame:
    """Read a CSV (`.tsv`: tab-separated) table with a header; lines with `#` are comments.

    Empty cells are NaN, and nothing else is: `NA` may be the name of a sample. Samples and groups
    are text even where they look like numbers (`007`).
    """
    text = dict.fromkeys(("sample", "group"), str)
    separator = "\t" if Path(path).suffix == ".tsv" else ","
    try:
        return pd.read_csv(
            path, sep=separator, comment="#", dtype=text, keep_default_na=False, na_values=[""]
        )
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not a table with a header: {error}") from error


def write_table(path: PathLike, table: pd.DataFrame | Mapping[str, ArrayLike]) -> None:
    """Write a table (a frame or columns) as CSV, atomically, ten significant digits."""
    frame = table if isinstance(table, pd.DataFrame) else pd.DataFrame(dict(table))
    with written_aside(path) as aside:
        frame.to_csv(aside, index=False, float_format="%.10g", lineterminator="\n")


def read_samples(path: PathLike) -> pd.DataFrame:
    """Read a table of samples as text; nothing is checked or converted here.

    Returns
    -------
    pandas.DataFrame
        One row a sample, all columns text, empty cells as "". The index is the line in the file.
    """
    try:
        lines, _ = read_lines(path, "save the table as tab-separated text")
    except FileNotFoundError as error:
        raise InputError(
            f"{path}: no such table of samples; give its path with --config samples=PATH"
        ) from error
    separator = "," if Path(path).suffix == ".csv" else "\t"
    numbers = [n for n, line in enumerate(lines, 1) if line.strip() and line.lstrip()[0] != "#"]
    if not numbers:
        raise InputError(f"{path}: not a tab-separated table with a header: it is empty")
    try:
        cells = [next(csv.reader([lines[n - 1]], delimiter=separator)) for n in numbers]
    except csv.Error as error:
        raise InputError(f"{path}: not a tab-separated table with a header: {error}") from error
    header = "\t".join(name.strip() for name in cells[0]).rstrip("\t").split("\t")
    if len(header) == 1 and (other := re.search("[,;]", header[0])):
        raise InputError(
            f"{path}, row {numbers[0]}: titles are separated by {other[0]!r}; separate cells by "
            "one tab each"
        )
    for number, row in zip(numbers, cells, strict=True):
        if any(cell.strip() for cell in row[len(header) :]):
            raise InputError(
                f"{path}, row {number}: {len(row)} cells below {len(header)} titles; separate "
                "cells by one tab each"
            )
    width = len(header)
    rows = [(row + [""] * width)[:width] for row in cells[1:]]
    return pd.DataFrame(
        rows, columns=header, dtype=object, index=pd.Index(numbers[1:], name="line", dtype=int)
    )


def read_record(path: PathLike) -> Record:
    """Read a record of the workflow, `records/{sample}.csv`."""
    return Record.of_table(read_table(path))


def read_shape(path: PathLike) -> IdealShape:
    """Read the idealised shape of a sample, `cuboid/{sample}.json`."""
    return IdealShape.of_report(read_json(path))


def write_image(path: PathLike, data: NDArray[Any], affine: ArrayLike) -> None:
    """Write a NIfTI volume (`.nii.gz`), atomically and with the same bytes every time.

    Parameters
    ----------
    path
        Target, ending in `.nii.gz`.
    data : (nx, ny, nz) uint8, int16, float32 or float64
        Values; the type is kept.
    affine : (4, 4)
        From voxel index to world RAS+ [mm].
    """
    import nibabel

    image = nibabel.Nifti1Image(data, np.asarray(affine, dtype=np.float64))
    image.header.set_xyzt_units("mm", "sec")
    with written_aside(path) as aside:
        aside.write_bytes(gzip.compress(image.to_bytes(), compresslevel=6, mtime=0))


def write_segmentation(path: PathLike, mask: NDArray[Any], affine: ArrayLike, name: str) -> None:
    """Write a segmentation for 3D Slicer (`.seg.nrrd`), atomically, the same bytes every time.

    Parameters
    ----------
    path
        Target, ending in `.seg.nrrd`.
    mask : (nx, ny, nz)
        Not zero inside the sample.
    affine : (4, 4)
        From voxel index to world RAS+ [mm].
    name
        Of the segment.
    """
    from softsample.formats.nrrd import segmentation_bytes

    with written_aside(path) as aside:
        aside.write_bytes(segmentation_bytes(mask, affine, name))


def read_distance(nifti_path: PathLike, json_path: PathLike) -> tuple[Array, Array, float]:
    """Read the signed distance of a sample and its place in the sample frame.

    Returns
    -------
    distance : (nx, ny, nz) float64
        Signed distance to the surface [m], negative inside.
    origin : (3,) float64
        Position of voxel [0, 0, 0] in the sample frame [m].
    spacing : float
        Grid spacing, the same in all directions [m].
    """
    distance, _ = read_image(nifti_path)
    report = read_json(json_path)
    origin = np.asarray(report["grid_origin_mm"], dtype=np.float64) * MM
    return distance.astype(np.float64) * MM, origin, float(report["grid_spacing_mm"]) * MM


def read_marks(
    bond_mask: Sequence[str], labels: Sequence[str], json_path: PathLike
) -> dict[str, MarkedImage]:
    """Read what is drawn in the image of a sample, by the columns of the sample table.

    Of a segmentation of 3D Slicer the glue is the segment with the column's name; regions are all
    of its segments.

    Parameters
    ----------
    bond_mask, labels : sequence of str
        Files of each; the first one is read, and there may be none.
    json_path : path
        Report of the segmentation, which holds the sample's place in the world.
    """
    frame = read_json(json_path)["sample_to_world"]
    wanted = {"bond_mask": (bond_mask, ("bond_mask",)), "labels": (labels, ())}
    return {
        name: MarkedImage.in_world(*read_image(paths[0], segments), frame, paths[0])
        for name, (paths, segments) in wanted.items()
        if paths
    }


def write_mesh(
    path: PathLike,
    mesh: HexMesh,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
) -> None:
    """Write a mesh as VTU (opens in ParaView), points in mm, atomically.

    Parameters
    ----------
    path
        Target, ending in `.vtu`.
    mesh
        Points [m] in the sample frame.
    point_data, cell_data
        Named arrays, first axis nodes or elements; their units belong in the names.
    """
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    grid = _vtk_grid(mesh, point_data or {}, cell_data or {})
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid)
    with written_aside(path) as aside:
        writer.SetFileName(str(aside))
        if writer.Write() != 1 or writer.GetErrorCode() != 0:
            raise OSError(f"{path}: could not be written (error {writer.GetErrorCode()} of VTK)")


def _vtk_grid(
    mesh: HexMesh, point_data: Mapping[str, ArrayLike], cell_data: Mapping[str, ArrayLike]
) -> Any:
    """Unstructured VTK grid of a mesh, points in mm."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid

    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(mesh.points / MM), deep=True))
    count = len(mesh.hexes)
    cells = vtkCellArray()
    cells.SetData(
        numpy_to_vtkIdTypeArray(np.arange(0, 8 * count + 1, 8, dtype=np.int64), deep=True),
        numpy_to_vtkIdTypeArray(np.ascontiguousarray(mesh.hexes, dtype=np.int64).ravel(), True),
    )
    grid = vtkUnstructuredGrid()
    grid.SetPoints(points)
    grid.SetCells(VTK_HEXAHEDRON, cells)
    sides = (
        (grid.GetPointData(), point_data, len(mesh.points)),
        (grid.GetCellData(), cell_data, count),
    )
    for target, arrays, length in sides:
        for name, values in arrays.items():
            array = np.ascontiguousarray(values)
            if array.dtype == bool:
                array = array.astype(np.uint8)
            if array.shape[0] != length:
                raise InputError(f"mesh data {name!r} has {array.shape[0]} values, not {length}")
            data = numpy_to_vtk(array, deep=True)
            data.SetName(name)
            target.AddArray(data)
    return grid


def read_mesh(path: PathLike) -> HexMesh:
    """Read the mesh of a VTU file; points come back in metres."""
    return read_mesh_with_data(path)[0]


def read_mesh_with_data(
    path: PathLike,
) -> tuple[HexMesh, dict[str, NDArray[Any]], dict[str, NDArray[Any]]]:
    """Read a VTU file of hexahedra.

    Returns
    -------
    mesh : HexMesh
        Points in metres.
    point_data, cell_data : dict of arrays
        Values as they stand in the file, units in their names.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    if not Path(path).is_file():
        raise InputError(f"{path}: no such mesh")
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(os.fspath(path))
    reader.Update()
    grid = reader.GetOutput()
    if reader.GetErrorCode() != 0 or grid.GetNumberOfCells() == 0:
        raise InputError(f"{path}: not a readable VTU mesh; delete it and run again")
    if not grid.IsHomogeneous() or grid.GetCellType(0) != VTK_HEXAHEDRON:
        raise InputError(f"{path}: holds other cells than 8-node hexahedra; mesh it with hexahedra")
    points = vtk_to_numpy(grid.GetPoints().GetData()).astype(np.float64) * MM
    hexes = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).astype(np.int64).reshape(-1, 8)
    point_data, cell_data = (
        {
            data.GetArrayName(index): vtk_to_numpy(data.GetArray(index)).copy()
            for index in range(data.GetNumberOfArrays())
        }
        for data in (grid.GetPointData(), grid.GetCellData())
    )
    return HexMesh(points, hexes), point_data, cell_data


SURFACE_READERS = {
    ".stl": ("vtkIOGeometry", "vtkSTLReader"),
    ".ply": ("vtkIOPLY", "vtkPLYReader"),
    ".vtp": ("vtkIOXML", "vtkXMLPolyDataReader"),
}
"""Module and reader of VTK for each ending of a surface."""


def read_surface(path: PathLike) -> TriangleSurface:
    """Read the closed surface of a sample: STL, PLY or VTP in mm, loading axis +z.

    Points at the same place are merged, polygons cut into triangles. An STL or PLY whose header
    says `SPACE=LPS`, as files of 3D Slicer and `write_surface` do, is turned to RAS+, the world
    of images.

    Raises
    ------
    MeshError
        If the file holds no closed, manifold surface with outward normals and the size of a
        sample; the message names file and cure.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkFiltersCore import vtkCleanPolyData, vtkTriangleFilter

    reader = _surface_reader(path)
    triangles, merged = vtkTriangleFilter(), vtkCleanPolyData()
    triangles.SetInputConnection(reader.GetOutputPort())
    triangles.PassLinesOff()
    triangles.PassVertsOff()
    merged.SetInputConnection(triangles.GetOutputPort())
    merged.SetTolerance(0.0)
    merged.Update()
    found = merged.GetOutput()
    if reader.GetErrorCode() != 0 or found.GetNumberOfPolys() == 0:
        kind = Path(path).suffix.lower()[1:].upper()
        raise MeshError(f"{path}: not a readable {kind} file; export the surface again")
    points = vtk_to_numpy(found.GetPoints().GetData()).astype(np.float64) * MM
    corners = vtk_to_numpy(found.GetPolys().GetConnectivityArray()).astype(np.int64)
    surface = TriangleSurface(points, corners.reshape(-1, 3), str(path))
    with Path(path).open("rb") as file:
        of_slicer = b"SPACE=LPS" in file.read(LONGEST_HEADER)
    surface = surface.moved(LPS_TO_RAS) if of_slicer else surface
    surface.check_closed()
    return surface


def _surface_reader(path: PathLike) -> Any:
    """VTK's reader for a surface, by the ending of its file."""
    ending = Path(path).suffix.lower()
    if ending not in SURFACE_READERS:
        raise MeshError(f"{path}: not a surface by its ending; give {', '.join(SURFACE_READERS)}")
    if not Path(path).is_file():
        raise MeshError(f"{path}: no such surface; correct its path")
    module, name = SURFACE_READERS[ending]
    reader = getattr(import_module(f"vtkmodules.{module}"), name)()
    reader.SetFileName(os.fspath(path))
    return reader


def write_surface(
    path: PathLike, surface: TriangleSurface, sample_to_world_mm: ArrayLike | None = None
) -> None:
    """Write a surface as binary STL in mm, atomically.

    Parameters
    ----------
    path
        Target, ending in `.stl`.
    surface
        Points [m] in the sample frame.
    sample_to_world_mm : (4, 4), optional
        From the sample frame to world RAS+ [mm]. With it the file is in LPS, the world of other
        programs' files, and its header says so: `SPACE=LPS`, as 3D Slicer writes it. Without it
        the file is in the sample frame.
    """
    placed, title = surface, "sample frame, mm"
    if sample_to_world_mm is not None:
        placed, title = surface.moved(LPS_TO_RAS @ np.asarray(sample_to_world_mm)), "SPACE=LPS, mm"
    corners = (placed.points / MM).astype(np.float32)[placed.triangles]
    # corners that fall together in single precision leave slivers that other programs refuse
    sound = np.all(np.any(corners != np.roll(corners, 1, axis=1), axis=2), axis=1)
    corners, normals = corners[sound], placed.area_vectors[sound]
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    kinds = [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]
    facets = np.zeros(len(corners), dtype=kinds)
    facets["normal"], facets["corners"] = normals, corners
    header = f"softsample {title}".encode().ljust(80)
    with written_aside(path) as aside:
        aside.write_bytes(header + np.uint32(len(facets)).tobytes() + facets.tobytes())
