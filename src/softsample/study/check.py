"""Everything that is wrong with a study, at once and in seconds, before anything is computed."""

import copy
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from softsample.errors import InputError
from softsample.formats import Volume
from softsample.formats.machine import described, read
from softsample.images import check_image, on_grid_of
from softsample.io import PathLike, read_image, read_samples, read_yaml
from softsample.meshing.marks import MarkedImage
from softsample.meshing.regions import relative_stiffness
from softsample.records import RecordSettings, aligned_record
from softsample.study import ROOT, SETTINGS, TABLE, table_of
from softsample.validation import check_config, sample_faults, sample_rows


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
    faults = list(sample_faults(table, rows, schema))
    result.faults += [f"{home / TABLE}, {fault}" for fault in faults]
    result.samples = len(rows)
    wrong = {(fault.line, fault.column) for fault in faults}
    for line, row in rows.items():
        sound = {column: cell for column, cell in row.items() if (line, column) not in wrong}
        where = f"{home / TABLE}, row {line} ({row.get('sample', '?')})"
        _check_row(home, sound, where, settings, result)
    return result


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
        merged = _overlaid(defaults, own)
        check_config(merged, _schema("config"), str(home / SETTINGS))
    except InputError as error:
        first, *more = str(error).split("\n")
        result.faults += [f"{home / SETTINGS}: {line.strip()}" for line in more] or [first]
        return dict(defaults)
    return merged


def _overlaid(base: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """Settings with the keys of another file in place of theirs, as Snakemake does it."""
    merged = copy.deepcopy(dict(base))
    for key, value in own.items():
        both = isinstance(value, Mapping) and isinstance(merged.get(key), Mapping)
        merged[key] = _overlaid(merged[key], value) if both else value
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
        except InputError as error:
            result.faults += [f"{where}: {line}" for line in str(error).split("\n")]
            return None

    result.found.append(f"{row.get('sample', '?')}: {row.get('mode', '?')}")
    image = attempt("image", lambda path: _image(path, result))
    attempt("record", lambda path: _record(path, row.get("mode"), settings, result))
    if image:
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


def _record(path: str, mode: str | None, settings: Mapping[str, Any], result: Inspection) -> None:
    given = RecordSettings(**settings["records"])
    raw = read(path, given.columns, given.units)
    result.found.append(f"  record {path}: {raw.reading['kind']}")
    result.found += [f"    {line}" for line in described(raw.reading)]
    if mode:
        schema = _schema("record")
        _, facts = aligned_record(raw.table, raw.reading, mode, given, schema, path)
        result.found += [f"    {line}" for line in _aligned(facts)]


def _aligned(facts: Mapping[str, Any]) -> Iterator[str]:
    """Signs, zero, ramp and doubts of a record in words."""
    rest = facts["force_offset_N"]
    at_rest = "not known" if rest is None else f"{rest:.4g} N, noise {facts['force_noise_N']:.2g} N"
    begins = {
        "displacement_mm": f"the ramp begins at {facts['ramp_start_mm']:.4g} mm",
        "force_N": f"the force at rest is {at_rest}",
    }
    for column, state in begins.items():
        positive, shift = facts["positive"][column], facts["subtracted"][column]
        zero = f"{shift:.4g} was subtracted" if shift else "zero is that of the file"
        yield f"{column}: {positive} is positive in the file; {zero}, and {state}"
    yield (
        f"ramp of {facts['travel_mm']:.4g} mm at {facts['ramp_speed_mm_s']:.3g} mm/s to "
        f"{facts['peak_force_N']:.4g} N (tension positive); {facts['samples']} samples, "
        f"{facts['sampling_rate_hz']:.4g} Hz, {', '.join(p['kind'] for p in facts['phases'])}"
    )
    yield from (f"warning: {warning}" for warning in facts["warnings"])
