"""Everything that is wrong or doubtful with a study, at once, before anything is computed."""

import difflib
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsample import validation
from softsample.arrays import Mask
from softsample.errors import InputError, SoftsampleError, as_setting
from softsample.formats import Volume, header_doubts
from softsample.formats.machine import described, read
from softsample.holdout import check_hold_out, folds, held_out, selecting
from softsample.images import check_image, image_doubts, on_grid_of, one_label, world_axis
from softsample.imaging.measure import MeasurementSettings, proposed_shape
from softsample.imaging.propose import Glance, circularity_of_surface, coarsened, glance
from softsample.imaging.settings import SegmentationSettings
from softsample.io import PathLike, read_image, read_samples, read_surface, read_yaml
from softsample.meshing.marks import MarkedImage
from softsample.meshing.regions import relative_stiffness
from softsample.meshing.surface import TriangleSurface, base_centre
from softsample.plausibility import Limits, doubts
from softsample.protocol import PRESSED_MODES
from softsample.records import Record, RecordSettings, aligned_record
from softsample.shapes import ANY_DIMENSION, DIMENSIONS, IdealShape
from softsample.study import ROOT, SETTINGS, TABLE, schema, table_of
from softsample.study.compare import Seen, compared
from softsample.units import MM

SLIDING_MODES = ("tension", "compression", "shear", "pure_shear")
"""Modes of a stated shape whose ends may slide."""

PULLED = 0.05
"""Part of the largest push from which on a pull during unloading is more than some adhesion."""

ROW = re.compile(r"row \d+ \([^)]*\)")
"""Where a fault or a doubt is in the table."""


@dataclass
class Inspection:
    """What was found in a study.

    Parameters
    ----------
    seen : list of Seen
        Each row of the table, with what its files hold.
    faults : list of str
        What is wrong: file, row or line, value and cure.
    doubts : list of str
        What is likely to be wrong, in the same form; it stops nothing.
    """

    seen: list[Seen] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    doubts: list[str] = field(default_factory=list)

    @property
    def found(self) -> list[str]:
        """Lines about the samples: what their files hold and how they are understood."""
        return [line for one in self.seen for line in one.found]


def each_cure_once(lines: Iterable[str]) -> list[str]:
    """Faults or doubts; a cure (what follows the semicolon) that many rows need is said once."""
    said: dict[str, str] = {}
    short, before = [], ""
    for line in lines:
        what, _, cure = line.partition("; ")
        first = ROW.search(said.get(cure, ""))
        same = "as above" if cure == before else f"as for {first[0]}" if first else cure
        short.append(f"{what}; {same}" if cure in said else line)
        before = cure
        if cure:
            said.setdefault(cure, what)
    return short


def check_study(folder: PathLike) -> Inspection:
    """Check settings, table, images and records of a study folder; nothing stops at the first."""
    home = Path(folder)
    result = Inspection()
    settings = _settings(home, result)
    try:
        table = read_samples(table_of(home))
        rows = validation.sample_rows(table, str(home / TABLE))
    except InputError as error:
        result.faults.append(str(error))
        return result
    faults = list(validation.sample_faults(table, rows, schema("samples"), settings["formats"]))
    result.faults += [f"{home / TABLE}, {fault}" for fault in faults]
    wrong = {(fault.line, fault.column) for fault in faults}
    seen = result.seen
    for line, row in rows.items():
        sound = {column: cell for column, cell in row.items() if (line, column) not in wrong}
        where = f"{home / TABLE}, row {line} ({row.get('sample', '?')})"
        seen.append(_check_row(home, sound, where, settings, result))
    result.doubts += compared(seen, Limits(**settings["plausibility"]))
    result.faults = _for_their_rows(result.faults, seen)
    result.doubts = _for_their_rows(result.doubts, seen)
    if not faults:
        _check_hold_out(home, list(rows.values()), settings, seen, result)
    return result


def _for_their_rows(messages: Sequence[str], seen: Sequence[Seen]) -> list[str]:
    """Messages whose settings concern only the rows that they are of.

    What is told to every row stays a setting of `records`; otherwise it becomes a block of
    `formats`, named after the first of these rows. `loading` changes nothing where the platen
    pulls.
    """
    setting = re.compile(r"`records: (\{.*\})`")
    told: dict[str, list[str]] = {}
    for message in messages:
        for body in setting.findall(message):
            told.setdefault(body, []).append(message)

    def of_rows(body: str) -> str:
        concerned = [
            one for one in seen if "loading" not in body or one.row.get("mode") in PRESSED_MODES
        ]
        theirs = [one for one in seen if any(m.startswith(one.where) for m in told[body])]
        if all(one in theirs for one in concerned):
            return f"`records: {body}`"
        name = theirs[0].row.get("sample", "machine")
        return f"`formats: {{{name}: {body}}}` and write {name} into column format"

    return [setting.sub(lambda found: of_rows(found[1]), message) for message in messages]


def _check_hold_out(
    home: Path,
    rows: Sequence[Mapping[str, str]],
    settings: Mapping[str, Any],
    seen: Sequence[Seen],
    result: Inspection,
) -> None:
    """Refuse selections that fit no row, and doubt what holds nothing out."""
    result.doubts += _nothing_left_out(home, rows, settings["leave_out"])
    try:
        check_hold_out(rows, settings["hold_out"])
    except InputError as error:
        result.faults.append(f"{home / SETTINGS}: {error}")
        return
    if any(one.facts is None for one in seen):
        return
    used = {number for one in seen if one.facts for number in one.facts["held_out_by"]}
    result.doubts += [
        f"{home / SETTINGS}: hold_out.{number}: {selection} selects nothing of any record; "
        "correct it, or delete it"
        for number, selection in enumerate(settings["hold_out"])
        if number not in used
    ]


def _nothing_left_out(
    home: Path, rows: Sequence[Mapping[str, str]], part: str | None
) -> Iterator[str]:
    """What to say of parts that are to be left out in turn, if there is but one of them."""
    of_group: dict[str, list[Mapping[str, str]]] = {}
    for row in rows:
        of_group.setdefault("" if part == "group" else row["group"], []).append(row)
    if part and not any(folds(of_one, part) for of_one in of_group.values()):
        where = "the study" if part == "group" else "each group"
        yield (
            f"{home / SETTINGS}: leave_out: {part} leaves nothing out, as {where} has one {part} "
            f"only, and no other to predict it from; add one (column {part}), or delete the setting"
        )


def _settings(home: Path, result: Inspection) -> dict[str, Any]:
    """Configuration of the study; the defaults if its own is wrong."""
    defaults = read_yaml(ROOT / "config/config.yaml")
    if not (home / SETTINGS).is_file():
        return dict(defaults)
    try:
        own = read_yaml(home / SETTINGS) or {}
        if not isinstance(own, dict):
            raise InputError(f"{home / SETTINGS}: holds no keys; give some, such as records: ...")
        merged = validation.overlaid(defaults, own)
        validation.check_config(merged, schema("config"), str(home / SETTINGS))
    except InputError as error:
        first, *more = str(error).split("\n")
        result.faults += [f"{home / SETTINGS}: {line.strip()}" for line in more] or [first]
        return dict(defaults)
    return merged


def _check_row(
    home: Path, row: Mapping[str, str], where: str, settings: Mapping[str, Any], result: Inspection
) -> Seen:
    """Check the files of one sample; `row` holds its sound cells."""
    told = [f"{row.get('sample', '?')}: {row.get('mode', '?')}"]

    def attempt(column: str, step: Callable[[str], Any]) -> Any:
        """What a step makes of the file of a column; None without a file, or if it is refused."""
        if column not in row:
            return None
        try:
            _check_there(home, row[column], column)
            return step(str(home / row[column]))
        except SoftsampleError as error:
            result.faults += [f"{where}: {line}" for line in str(error).split("\n")]
            return None

    doubted: list[str] = []
    image = attempt("image", lambda path: _image(path, told, doubted))
    names = (row.get("sample", ""), "sample")
    mask = attempt("segmentation", lambda path: _mask(path, names, image)) if image else None
    piece = None
    if image and ("segmentation" not in row or mask is not None):
        at_fault = "image" if mask is None else "segmentation"
        piece = attempt(at_fault, lambda path: _glance(path, image, mask, row, settings))
        told += _told(piece, row) if piece else ()
        seen = piece.found.doubts if piece else ()
        doubted += [f"{home / row[at_fault]}: {doubt}" for doubt in seen]
    result.doubts += [f"{where}: {doubt}" for doubt in doubted]
    surface = attempt("surface", lambda path: _surface(path, row, told))
    size = _size(row, told)
    around = IdealShape("cuboid", *map(float, np.ptp(surface.points, axis=0))) if surface else None
    known = size or (piece.shape if piece else None) or around
    tested = attempt(
        "record", lambda path: _record(path, row, (size, known), where, settings, result, told)
    )
    if image:
        attempt("bond_mask", lambda path: _marked(path, ("bond_mask",), image))
        attempt("labels", lambda path: _labels(path, image, settings))
    record, facts = tested or (None, None)
    small = coarsened(*image) if image else None
    return Seen(where, row, facts, known, told, record, small, piece, surface)


def _check_there(home: Path, name: str, column: str) -> None:
    """Refuse a file that is not there; one of nearly the same name beside it is proposed."""
    path = home / name
    if path.exists():
        return
    beside = [str(p.relative_to(home)) for p in path.parent.glob("*")]
    same = [other for other in beside if other.lower() == name.lower()]
    near = (same or difflib.get_close_matches(name, beside, n=1, cutoff=0.8))[:1]
    cure = f"write {near[0]} into column {column}" if near else "correct its path in the table"
    raise InputError(f"{path}: no such {column}; {cure}")


def _image(path: str, told: list[str], doubted: list[str]) -> Volume:
    volume = read_image(path)
    facts = check_image(*volume, path)
    doubted += [*header_doubts(path), *image_doubts(*volume, path)]
    size, voxel, extent = (
        " x ".join(f"{value:.4g}" for value in facts[name])
        for name in ("shape", "voxel_mm", "extent_mm")
    )
    told.append(f"  image {path}: {size} voxels of {voxel} mm, {extent} mm in all")
    return volume


def _glance(
    path: str,
    image: Volume,
    mask: NDArray[np.float32] | None,
    row: Mapping[str, str],
    settings: Mapping[str, Any],
) -> Glance:
    """Segment an image at low resolution."""
    axes = {name: world_axis(cell) for name, cell in validation.axes_of(row).items()}
    try:
        return glance(
            image[0] if mask is None else mask,
            image[1],
            SegmentationSettings(**settings["segmentation"]),
            MeasurementSettings(**settings["measurement"]),
            is_mask=mask is not None,
            **axes,
        )
    except SoftsampleError as error:
        raise InputError(f"{path}: {error}") from error


def _told(seen: Glance, row: Mapping[str, str]) -> Iterator[str]:
    """What was seen in an image, in words."""
    shape, found = seen.shape, seen.found
    size = " x ".join(f"{v / MM:.3g}" for v in (shape.length, shape.width, shape.height))
    yield (
        f"    sample of about {size} mm, {found.volume / MM**3:.4g} mm3, base tilted by "
        f"{np.degrees(found.tilt):.1f} degrees{''.join(f'; {flag}' for flag in found.flags)}"
    )
    yield from _told_round(seen.circularity, row)


def _told_round(circularity: float, row: Mapping[str, str]) -> Iterator[str]:
    """What to say of a sample that looks like a cylinder."""
    if proposed_shape(circularity) == "cylinder" and "shape" not in row:
        yield (
            f"    its section looks round (circularity {circularity:.2f}): if it is, write "
            "cylinder into column shape, so that it is idealised as one"
        )


def _surface(path: str, row: Mapping[str, str], told: list[str]) -> TriangleSurface:
    surface = read_surface(path)
    base_centre(surface)
    extent = " x ".join(f"{size / MM:.4g}" for size in np.ptp(surface.points, axis=0))
    told.append(
        f"  surface {path}: {len(surface.triangles)} triangles, {extent} mm, "
        f"{surface.volume / MM**3:.4g} mm3"
    )
    loading_axis = world_axis(validation.axes_of(row)["loading_axis"])
    told += _told_round(circularity_of_surface(surface, loading_axis), row)
    return surface


def _size(row: Mapping[str, str], told: list[str]) -> IdealShape | None:
    """The shape that a row states, if its cells are sound."""
    try:
        shape = IdealShape.of_row(validation.stated_shape(row))
    except InputError:  # the table says what is wrong, or there is an image
        return None
    sizes = [f"{name[:-3]} {row[name]} mm" for name in DIMENSIONS[shape.kind]]
    told.append(f"  {shape.kind} of {', '.join(sizes)}: section {shape.area / MM**2:.4g} mm2")
    if row.get("mode") in SLIDING_MODES:
        none_given = "bonded, as the cell is empty (unknown: the diagnosis compares sliding ones)"
        told.append(f"    ends {row.get('ends', none_given)}")
    return shape


def _mask(path: str, segments: Sequence[str], image: Volume) -> NDArray[np.float32]:
    mask, affine = read_image(path, segments)
    return on_grid_of(image, one_label(mask, path), affine, path)


def _marked(path: str, segments: Sequence[str], image: Volume) -> MarkedImage:
    data, affine = read_image(path, segments)
    marked = MarkedImage.in_world(data, affine, np.eye(4), path)
    on_grid_of(image, data, affine, path)
    return marked


def _labels(path: str, image: Volume, settings: Mapping[str, Any]) -> None:
    marked = _marked(path, (), image)
    try:
        relative_stiffness(np.unique(marked.values), settings["material"]["region_stiffness"])
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _record(
    path: str,
    row: Mapping[str, str],
    sizes: tuple[IdealShape | None, IdealShape | None],
    where: str,
    settings: Mapping[str, Any],
    result: Inspection,
    told: list[str],
) -> tuple[Record, dict[str, Any]] | None:
    """Check a record; `sizes` are the dimensions that are stated, and those that are known."""
    given = RecordSettings(**validation.record_settings(settings, row))
    raw = read(path, given.columns, given.units, given.sheet, given.block, row.get("mode", ""))
    told.append(f"  record {path}: {raw.reading['kind']}")
    told += [f"    {line}" for line in described(raw.reading)]
    if "mode" not in row:
        return None
    form, which = schema("record"), validation.resolved(row)["cycle"]
    stated, known = sizes
    test = (raw.reading, row["mode"], given, form, path, stated, which)
    table, facts = aligned_record(raw.table, *test)
    told += [f"    {line}" for line in _aligned(facts, row["mode"])]
    cells = {name: row[name] for name in ANY_DIMENSION if name in row} if stated else {}
    limits = Limits(**settings["plausibility"]).of(row["mode"])
    own = [*doubts(facts, known, limits, cells, given.block, row["mode"], path)]
    record, hold_out = Record.of_table(table), settings["hold_out"]
    leaves = row["mode"] == "compression" and settings["contact"]["release"]
    pulled = _pulling(record, facts) if leaves else ()
    found = (*facts["warnings"], *own, *pulled)
    result.doubts += [f"{where}: {path}: {doubt}" for doubt in found]
    height = known.height if known else None
    held = selecting(record, row, height, hold_out)
    free = ~held_out(record, row, height or np.inf, "force", hold_out)
    unused = (
        _unused(facts, row) if record.calibrated[free].any() else _no_loading(record, free, facts)
    )
    result.doubts += [f"{where}: {path}: {doubt}" for doubt in unused]
    return record, facts | {"doubted": bool(own), "held_out_by": held}


def _pulling(record: Record, facts: Mapping[str, Any]) -> Iterator[str]:
    """What to say of a platen that pulls during unloading, as the modelled one cannot."""
    rest = facts["force_offset_N"] or 0.0
    pull = float(np.max(record.force - rest, initial=0.0, where=record.phase == "unloading"))
    most = abs(facts["peak_force_N"] - rest)
    if pull > PULLED * most:
        yield (
            f"during unloading the platen pulls with {pull:.3g} N, {100.0 * pull / most:.2g} % of "
            "the largest force, and the modelled one releases the sample; if it is bonded, set "
            f"{as_setting({'contact': {'release': False}})}; if not, look at the zero of the force"
        )


def _unused(facts: Mapping[str, Any], row: Mapping[str, str]) -> Iterator[str]:
    """What to say of loadings after the calibrated one, if the table does not choose."""
    count, chosen = facts["loadings"], facts["calibrated_loading"]
    if chosen < count and "cycle" not in row:
        yield (
            f"loading {chosen} of {count} is calibrated, as the first that reaches the largest "
            "displacement; if those before the last are preconditioning, write last into column "
            "cycle (or first, if the first is right)"
        )


def _no_loading(record: Record, free: Mask, facts: Mapping[str, Any]) -> Iterator[str]:
    """What to say if the calibrated loading is held out, and others are not: all but `free`."""
    others = free & (record.phase == "ramp")
    if others.any():
        widest = record.cycle[others][np.argmax(np.abs(record.displacement[others]))]
        yield (
            f"loading {facts['calibrated_loading']} of {facts['loadings']}, the one that is "
            f"calibrated, is held out; write {widest} into column cycle"
        )


def _aligned(facts: Mapping[str, Any], mode: str) -> Iterator[str]:
    """Signs, zero, ramp and doubts of a record in words."""
    if mode == "torsion":
        yield "displacement is that of the rim, angle times radius; force is torque over radius"
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
    if facts["phases"][-1]["kind"] == "ramp":
        yield "the record ends in its ramp: a hold or an unloading would tell more"
    if "strain" in facts:
        low, high = (100.0 * strain for strain in facts["strain"])
        bottom, top = (1e-3 * stress for stress in facts["stress_pa"])
        yield (
            f"nominal strain {low:z.3g} to {high:z.3g} %, nominal stress {bottom:.3g} to {top:.3g} "
            "kPa"
        )
