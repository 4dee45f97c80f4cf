"""Everything that is wrong with a study, at once and in seconds, before anything is computed."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from skimage.filters import threshold_otsu

from softsample.errors import InputError, SoftsampleError
from softsample.formats import Volume
from softsample.formats.machine import described, read
from softsample.holdout import check_hold_out
from softsample.images import check_image, on_grid_of, world_axis
from softsample.imaging.measure import circularity, proposed_shape
from softsample.imaging.segment import SegmentationSettings, segmentation_from_mask
from softsample.io import PathLike, read_image, read_samples, read_surface, read_yaml
from softsample.meshing.marks import MarkedImage
from softsample.meshing.regions import relative_stiffness
from softsample.records import RecordSettings, aligned_record
from softsample.shapes import IdealShape
from softsample.study import ROOT, SETTINGS, TABLE, table_of
from softsample.validation import (
    DEFAULT_AXES,
    DIMENSIONS,
    check_config,
    overlaid,
    record_settings,
    resolved,
    sample_faults,
    sample_rows,
    stated_shape,
)

MM = 1e-3

GLANCE = 12.0
"""Voxels along the edge of a cube as large as the sample, when it is looked at in passing."""


@dataclass
class Inspection:
    """What was found in a study.

    Parameters
    ----------
    found : list of str
        Lines about the samples: what their files hold and how they are understood.
    faults : list of str
        What is wrong: file, row or line, value and cure.
    samples : int
        Rows of the table.
    """

    found: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    samples: int = 0


def check_study(folder: PathLike) -> Inspection:
    """Check settings, table, images and records of a study folder; nothing stops at the first."""
    home = Path(folder)
    result = Inspection()
    settings = _settings(home, result)
    schema = _schema("samples")
    try:
        table = read_samples(table_of(home))
        rows = sample_rows(table, str(home / TABLE))
    except InputError as error:
        result.faults.append(str(error))
        return result
    faults = list(sample_faults(table, rows, schema, settings["formats"]))
    result.faults += [f"{home / TABLE}, {fault}" for fault in faults]
    result.samples = len(rows)
    wrong = {(fault.line, fault.column) for fault in faults}
    for line, row in rows.items():
        sound = {column: cell for column, cell in row.items() if (line, column) not in wrong}
        where = f"{home / TABLE}, row {line} ({row.get('sample', '?')})"
        _check_row(home, sound, where, settings, result)
    if not faults:
        _check_hold_out(home, list(rows.values()), settings, result)
    return result


def _check_hold_out(
    home: Path, rows: Sequence[Mapping[str, str]], settings: Mapping[str, Any], result: Inspection
) -> None:
    try:
        check_hold_out(rows, settings["hold_out"])
    except InputError as error:
        result.faults.append(f"{home / SETTINGS}: {error}")


@cache
def _schema(name: str) -> Any:
    return read_yaml(ROOT / f"workflow/schemas/{name}.schema.yaml")


def _settings(home: Path, result: Inspection) -> dict[str, Any]:
    """Configuration of the study; the defaults if its own is wrong."""
    defaults = read_yaml(ROOT / "config/config.yaml")
    if not (home / SETTINGS).is_file():
        return dict(defaults)
    try:
        own = read_yaml(home / SETTINGS) or {}
        if not isinstance(own, dict):
            raise InputError(f"{home / SETTINGS}: holds no keys; give some, such as records: ...")
        merged = overlaid(defaults, own)
        check_config(merged, _schema("config"), str(home / SETTINGS))
    except InputError as error:
        first, *more = str(error).split("\n")
        result.faults += [f"{home / SETTINGS}: {line.strip()}" for line in more] or [first]
        return dict(defaults)
    return merged


def _check_row(
    home: Path, row: Mapping[str, str], where: str, settings: Mapping[str, Any], result: Inspection
) -> None:
    """Check the files of one sample; `row` holds its sound cells."""

    def attempt(column: str, step: Callable[[str], Any]) -> Any:
        """What a step makes of the file of a column; None without a file, or if it is refused."""
        if column not in row:
            return None
        try:
            return step(str(home / row[column]))
        except SoftsampleError as error:
            result.faults += [f"{where}: {line}" for line in str(error).split("\n")]
            return None

    result.found.append(f"{row.get('sample', '?')}: {row.get('mode', '?')}")
    image = attempt("image", lambda path: _image(path, result))
    attempt("surface", lambda path: _surface(path, result))
    size = _size(row, result)
    attempt("record", lambda path: _record(path, row, size, settings, result))
    if image:
        result.found += _round(image, row)
        names = (row.get("sample", ""), "sample")
        attempt("segmentation", lambda path: _mask(path, names, image))
        attempt("bond_mask", lambda path: _glued(path, image))
        attempt("labels", lambda path: _labels(path, image, settings))


def _image(path: str, result: Inspection) -> Volume:
    volume = read_image(path)
    facts = check_image(*volume, path)
    size, voxel, extent = (
        " x ".join(f"{value:.4g}" for value in facts[name])
        for name in ("shape", "voxel_mm", "extent_mm")
    )
    result.found.append(f"  image {path}: {size} voxels of {voxel} mm, {extent} mm in all")
    return volume


def round_section(image: Volume, row: Mapping[str, str]) -> float:
    """Circularity of the sample's section (`softsample.imaging.measure`), at a glance.

    The image is cut at Otsu's threshold and coarsened, which is enough to tell a disc from a
    rectangle, and takes no minutes as the segmentation does.

    Raises
    ------
    SegmentationError
        If no sample is seen that way.
    """
    data, affine = image
    bright = data > threshold_otsu(data)
    voxel = np.linalg.norm(affine[:3, :3], axis=0)
    coarse = float(np.cbrt(np.count_nonzero(bright) * voxel.prod()) / GLANCE)
    steps = [max(1, int(0.5 * coarse / size)) for size in voxel]
    axes = {name: world_axis(row.get(name, default)) for name, default in DEFAULT_AXES.items()}
    found = segmentation_from_mask(
        bright[tuple(slice(None, None, step) for step in steps)],
        affine @ np.diag([*map(float, steps), 1.0]),
        SegmentationSettings(grid_spacing_mm=coarse),
        **axes,
    )
    return circularity(found.distance, found.origin, found.spacing)


def _round(image: Volume, row: Mapping[str, str]) -> Iterator[str]:
    """What to say of a sample that looks round, where the table says no shape."""
    try:
        roundness = 0.0 if "shape" in row else round_section(image, row)
    except SoftsampleError:  # the segmentation looks more closely
        return
    if proposed_shape(roundness) == "cylinder":
        yield (
            f"    its section looks round (circularity {roundness:.2f}): if it is, write cylinder "
            "into column shape, so that it is idealised as one"
        )


def _surface(path: str, result: Inspection) -> None:
    surface = read_surface(path)
    extent = " x ".join(f"{size / MM:.4g}" for size in np.ptp(surface.points, axis=0))
    result.found.append(
        f"  surface {path}: {len(surface.triangles)} triangles, {extent} mm, "
        f"{surface.volume / MM**3:.4g} mm3"
    )


def _size(row: Mapping[str, str], result: Inspection) -> IdealShape | None:
    """The shape that a row states, if its cells are sound."""
    try:
        shape = IdealShape.of_row(stated_shape(row))
    except InputError:  # the table says what is wrong, or there is an image
        return None
    sizes = [f"{name[:-3]} {row[name]} mm" for name in DIMENSIONS[shape.kind]]
    result.found.append(
        f"  {shape.kind} of {', '.join(sizes)}: section {shape.area / MM**2:.4g} mm2"
    )
    return shape


def _mask(path: str, segments: Sequence[str], image: Volume) -> None:
    on_grid_of(image, *read_image(path, segments), path)


def _glued(path: str, image: Volume) -> None:
    data, affine = read_image(path, ("bond_mask",))
    MarkedImage.in_world(data, affine, np.eye(4), path)
    on_grid_of(image, data, affine, path)


def _labels(path: str, image: Volume, settings: Mapping[str, Any]) -> None:
    data, affine = read_image(path)
    marked = MarkedImage.in_world(data, affine, np.eye(4), path)
    on_grid_of(image, data, affine, path)
    try:
        relative_stiffness(np.unique(marked.values), settings["material"]["region_stiffness"])
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _record(
    path: str,
    row: Mapping[str, str],
    size: IdealShape | None,
    settings: Mapping[str, Any],
    result: Inspection,
) -> None:
    given = RecordSettings(**record_settings(settings, row))
    raw = read(path, given.columns, given.units, given.sheet)
    result.found.append(f"  record {path}: {raw.reading['kind']}")
    result.found += [f"    {line}" for line in described(raw.reading)]
    if "mode" in row:
        schema, which = _schema("record"), resolved(row)["cycle"]
        test = (raw.reading, row["mode"], given, schema, path, size, which)
        _, facts = aligned_record(raw.table, *test)
        result.found += [f"    {line}" for line in _aligned(facts)]


def _aligned(facts: Mapping[str, Any]) -> Iterator[str]:
    """Signs, zero, ramp and doubts of a record in words."""
    rest = facts["force_offset_N"]
    at_rest = "not known" if rest is None else f"{rest:.4g} N, noise {facts['force_noise_N']:.2g} N"
    begins = {
        "displacement_mm": f"the ramp begins at {facts['ramp_start_mm']:z.4g} mm",
        "force_N": f"the force at rest is {at_rest}",
    }
    for column, state in begins.items():
        positive, shift = facts["positive"][column], facts["subtracted"][column]
        zero = f"{shift:.4g} was subtracted" if shift else "zero is that of the file"
        yield f"{column}: {positive} is positive in the file; {zero}, and {state}"
    speed, rate = facts["ramp_speed_mm_s"], facts["sampling_rate_hz"]
    yield (
        f"ramp of {facts['travel_mm']:.4g} mm"
        + (f" at {speed:.3g} mm/s" if speed else "")
        + f" to {facts['peak_force_N']:.4g} N (tension positive); {facts['samples']} samples, "
        + (f"{rate:.4g} Hz, " if rate else "")
        + ", ".join(phase["kind"] for phase in facts["phases"])
    )
    if facts["loadings"] > 1:
        yield (
            f"loading {facts['calibrated_loading']} of {facts['loadings']} is calibrated; column "
            "cycle chooses another one"
        )
    if "strain" in facts:
        low, high = (100.0 * strain for strain in facts["strain"])
        bottom, top = (1e-3 * stress for stress in facts["stress_pa"])
        yield (
            f"nominal strain {low:z.3g} to {high:z.3g} %, nominal stress {bottom:.3g} to {top:.3g} "
            "kPa"
        )
    yield from (f"warning: {warning}" for warning in facts["warnings"])
