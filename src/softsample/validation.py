"""Closed, bounded schemas: every refusal names file, place, value and cure."""

import copy
import difflib
import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

import pandas as pd
from jsonschema import Draft202012Validator
from jsonschema.exceptions import ValidationError

from softsample.errors import InputError
from softsample.shapes import ANY_DIMENSION, DIMENSIONS, Indenter

Schema = Mapping[str, Any]

LARGEST_MM = 1000.0

INDENTER_COLUMNS = ("indenter", "indenter_radius_mm")
"""Columns that say what a sample is indented with."""

IMAGE_COLUMNS = ("loading_axis", "shear_axis", "segmentation", "bond_mask", "labels")
"""Columns that concern an image."""

OF_SHAPES = ("pure_shear", "confined_compression", "indentation", "torsion")
"""Modes that are simulated on ideal shapes only."""

FILE_COLUMNS = ("image", "surface", "record", "segmentation", "bond_mask", "labels")
"""Columns of the study table that name files of the study folder."""

SHAPE_FILES = tuple(column for column in FILE_COLUMNS if column != "record")
"""Those of them that the sample's shape comes from."""

DEFAULT_AXES = {"loading_axis": "+z", "shear_axis": "+x"}
"""Image world axes of the test where the table does not name others."""

DEFAULTS = {"shape": "cuboid", "ends": "bonded", "cycle": "largest"}
"""What an empty cell means."""


def resolved(row: Mapping[str, str]) -> dict[str, str]:
    """A row of the table of samples with what its empty cells mean: `specimen`, `shape`, ...

    `shape` is what the sample is idealised as, whether its geometry is stated or comes from an
    image or a surface.
    """
    return {"specimen": row.get("sample", ""), **DEFAULTS, **row}


def ends_of(row: Mapping[str, str]) -> str | float | Indenter:
    """What holds a sample: its indenter, or what its ends do.

    Ends are `bonded`, `sliding`, `unknown`, or have a coefficient of friction.
    """
    if indenter := Indenter.of_row(resolved(row)):
        return indenter
    cell = resolved(row)["ends"]
    return float(cell) if _is_number(cell) else cell


def has_open_ends(row: Mapping[str, str]) -> bool:
    """Whether the study leaves to the diagnosis what the ends of a sample do."""
    return ends_of(row) == "unknown"


def modelled_ends(row: Mapping[str, str]) -> str | float | Indenter:
    """The same in the model, which bonds ends that are unknown."""
    return "bonded" if has_open_ends(row) else ends_of(row)


def states_directions(row: Mapping[str, str]) -> bool:
    """Whether a row says how the material lies in its test."""
    return bool(row.get("material_z"))


def axes_of(row: Mapping[str, str]) -> dict[str, str]:
    """Image world axes of loading and shear."""
    return {name: row.get(name, default) for name, default in DEFAULT_AXES.items()}


def shape_cells(row: Mapping[str, str]) -> dict[str, str]:
    """Cells of a row about its idealised shape."""
    return {name: row[name] for name in ("shape", *ANY_DIMENSION) if name in row}


def stated_shape(row: Mapping[str, str]) -> dict[str, str]:
    """Cells that state shape and dimensions of a row; none if its geometry is measured."""
    return {} if "image" in row or "surface" in row else shape_cells(row)


def overlaid(base: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """Settings with the keys of others in place of theirs, as Snakemake does it."""
    merged = copy.deepcopy(dict(base))
    for key, value in own.items():
        both = isinstance(value, Mapping) and isinstance(merged.get(key), Mapping)
        merged[key] = overlaid(merged[key], value) if both else value
    return merged


def record_settings(config: Mapping[str, Any], row: Mapping[str, str]) -> dict[str, Any]:
    """How the record of a row is read: section `records`, with the block of its `format` over it.

    Raises
    ------
    InputError
        If there is no block of that name.
    """
    name = row.get("format")
    if not name:
        return dict(config["records"])
    if name not in config["formats"]:
        raise InputError(f"column 'format': {_no_format(name, config['formats'])}")
    return {**overlaid(config["records"], config["formats"][name]), "block": name}


def _no_format(name: str, known: Collection[str]) -> str:
    there = f"there are {', '.join(map(str, known))}" if known else "there are none"
    return f"{name!r} is no block of `formats` in the settings of the study ({there})"


def check_config(config: Mapping[str, Any], schema: Schema, source: str) -> None:
    """Refuse a configuration that does not follow its schema.

    Parameters
    ----------
    config
        The merged configuration.
    schema
        JSON Schema (draft 2020-12); `description` and the extra keyword `cure` of the part that
        refuses a value enter the message.
    source
        Where the configuration comes from, for the message.

    Raises
    ------
    InputError
        Naming every wrong key at once, with its value and its cure.
    """
    found = [*refusals(dict(config), schema), *_not_finite(config)]
    found = found or list(_contradictions(config))
    if found:
        lines = [f"  {place or 'top level'}: {reason}" for place, reason in found]
        raise InputError("\n".join([f"configuration ({source}) is refused:", *lines]))


def _contradictions(config: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Places of values that are right each for itself, but not beside another one."""
    yield from _of_accuracy(config["floor"], config["solver"], config["checks"])
    alpha = config["material"]["alpha"]
    if alpha[0] == alpha[1]:
        yield "material.alpha", f"{alpha} is one term twice; its shares cannot be told apart"
    ranges = {
        "calibration.mu_pa_min": [config["calibration"][f"mu_pa_{end}"] for end in ("min", "max")],
        **{f"exponents.{name}": config["exponents"][name] for name in ("alpha1", "alpha2")},
    }
    for place, (low, high) in ranges.items():
        if low >= high:
            yield place, f"{low} is not below the upper end, {high}; exchange or widen them"
    if config["contact"]["base_platen"] and not config["contact"]["side_walls"]:
        yield (
            "contact.base_platen",
            "true without side_walls, so that no node of a wall could touch it; set it false",
        )


def _of_accuracy(
    floor: Mapping[str, Any], solver: Mapping[str, Any], checks: Mapping[str, Any]
) -> Iterator[tuple[str, str]]:
    sizes = floor["element_size_mm"]
    if sizes != sorted(set(sizes)):
        yield "floor.element_size_mm", f"{sizes} does not ascend; sort it, with element_percent"
    for mode, percents in floor["element_percent"].items():
        if len(percents) != len(sizes):
            yield (
                f"floor.element_percent.{mode}",
                f"has {len(percents)} values for {len(sizes)} of element_size_mm; give each one",
            )
    error, bound = solver["curve_error_percent"], checks["error_bound_percent_max"]
    if error > bound:
        yield (
            "solver.curve_error_percent",
            f"{error} is above checks.error_bound_percent_max, {bound}, so that each run would "
            "fail its check; raise both",
        )


@dataclass(frozen=True)
class Fault:
    """What is wrong with one cell, or one column, of the table of samples.

    Parameters
    ----------
    line : int or None
        Line in the file; none for a whole column.
    sample, column, reason : str
        The sample's id as far as it is known, the column, and what is wrong with the cure.
    """

    line: int | None
    sample: str
    column: str
    reason: str

    def __str__(self) -> str:
        """Place and reason in words."""
        if self.line is None:
            return f"column {self.column!r}{self.reason}"
        return f"row {self.line} ({self.sample}), column {self.column!r}: {self.reason}"


Rows = dict[int, dict[str, str]]
"""Cells by line in the file and column, empty ones left out."""


def _not_finite(value: Any, place: str = "") -> Iterator[tuple[str, str]]:
    """Places of numbers that are NaN or infinite: no bound of a schema refuses NaN."""
    if isinstance(value, float) and not math.isfinite(value):
        yield place, f"{value} is no number; give a finite one"
    items = value if isinstance(value, Mapping) else {}
    for key, item in enumerate(value) if isinstance(value, list) else items.items():
        yield from _not_finite(item, f"{place}.{key}" if place else str(key))


def check_samples(
    table: pd.DataFrame, schema: Schema, source: str, formats: Collection[str] | None = None
) -> list[dict[str, str]]:
    """Check the table of samples, cell by cell and as a whole.

    Parameters
    ----------
    table
        Cells as text, from `softsample.io.read_samples`.
    schema
        Schema of one row.
    source
        The table's path, for the message.
    formats
        Names of the blocks of `formats` in the settings; not checked if they are not given.

    Returns
    -------
    list of dict
        One a row, empty cells left out (`resolved` says what they mean).

    Raises
    ------
    InputError
        Naming every wrong cell at once: row (line in the file), column, value, cure.
    """
    rows = sample_rows(table, source)
    faults = list(sample_faults(table, rows, schema, formats))
    if faults:
        lines = [f"table of samples {source} is refused:", *(f"  {fault}" for fault in faults)]
        raise InputError("\n".join(lines))
    return list(rows.values())


def sample_rows(table: pd.DataFrame, source: str) -> Rows:
    """The rows of a table of samples, unchecked; there has to be one."""
    if table.empty:
        raise InputError(f"{source} has no rows; add one line for each sample")
    columns = [str(column) for column in table.columns]
    return {
        int(line): {
            column: str(value).strip()
            for column, value in zip(columns, values, strict=True)
            if str(value).strip()
        }
        for line, values in zip(table.index, table.to_numpy().tolist(), strict=True)
    }


def sample_faults(
    table: pd.DataFrame, rows: Rows, schema: Schema, formats: Collection[str] | None = None
) -> Iterator[Fault]:
    """Everything that is wrong with a table of samples, apart from the files it names."""
    columns = [str(column) for column in table.columns]
    for missing in (name for name in schema["required"] if name not in columns):
        there = ", ".join(columns)
        reason = f" is missing (there are {there}); the table is tab-separated, with a header"
        yield Fault(None, "", missing, reason)
    for name in dict.fromkeys(columns):
        if columns.count(name) > 1:
            yield Fault(None, "", name, " stands twice in the header; keep one")
        if name not in schema["properties"]:
            yield Fault(None, "", name, f": {_unknown(name, schema['properties'])}")
    for line, row in rows.items():
        column, cell = next(iter(row.items()), ("", ""))
        if len(row) == 1 and len(cell.split()) > 2:
            reason = f"{cell!r} stands in one cell; separate cells by tabs, in place of spaces"
            yield Fault(line, "?", column, reason)
            continue
        name = row.get("format", "")
        if name and formats is not None and name not in formats:
            yield Fault(line, row.get("sample", "?"), "format", _no_format(name, formats))
        for column, reason in _wrong_cells(row, columns, schema):
            yield Fault(line, row.get("sample", "?"), column, reason)
    yield from _doubled_samples(rows)
    yield from _split_specimens(rows)


def _wrong_cells(
    row: Mapping[str, str], columns: Sequence[str], schema: Schema
) -> Iterator[tuple[str, str]]:
    """Column and reason of each wrong cell of a row, apart from columns that are wrong in all."""
    for column, reason in refusals(dict(row), schema):
        if column in columns and column in schema["properties"]:
            yield column, reason + _meant(row.get(column, ""), column, schema)
    for column in (name for name in FILE_COLUMNS if name in row):
        path = PurePosixPath(row[column].replace("\\", "/"))
        if path.is_absolute() or ".." in path.parts or re.match("[A-Za-z]:", row[column]):
            yield (
                column,
                f"{row[column]!r} lies outside the study folder; copy the file into it, or make "
                "a link to it there",
            )
        if braces := re.search("[{}]", row[column]):  # Snakemake takes them for a wildcard
            yield column, f"{row[column]!r} has a brace, {braces[0]}; rename the file without it"
    yield from _wrong_geometry(row)
    yield from _wrong_ends(row)
    yield from _wrong_indenter(row)
    if row.get("mode") == "compression" and "bond_mask" in row:
        yield "bond_mask", "the top is not bonded in compression; leave the cell empty"
    yield from _wrong_directions(row)
    loading, shear = axes_of(row).values()
    if loading[-1] == shear[-1]:
        yield (
            "shear_axis",
            f"{shear!r} is parallel to the loading axis {loading!r}; give two different axes",
        )


def _wrong_directions(row: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """What is wrong with the directions of the material in a test."""
    along, sheared = (row.get(name, "").lstrip("+-") for name in ("material_z", "material_x"))
    if row.get("mode") == "shear" and along and not sheared:
        yield "material_x", "is missing beside material_z; give the direction along the shear, too"
    if sheared and not along:
        yield "material_z", "is missing beside material_x; give the direction along the load, too"
    if along and along == sheared:
        yield (
            "material_x",
            f"{row['material_x']!r} is parallel to material_z {row['material_z']!r}; give another "
            "direction",
        )


def _meant(cell: str, column: str, schema: Schema) -> str:
    """The word that a cell is likely to mean, as a cure; empty if none is near."""
    known = schema["properties"][column].get("enum", [])
    signed = [f"+{cell.lower()}"] if f"+{cell.lower()}" in known else []
    near = signed or difflib.get_close_matches(cell.lower(), known, n=1)
    return f"; write {near[0]} into column {column}" if near else ""


def _wrong_geometry(row: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """What is wrong with where the geometry of a sample comes from."""
    sources = [name for name in ("image", "surface") if name in row]
    stated = [name for name in ANY_DIMENSION if name in row]
    if len(sources) > 1:
        yield "surface", "the row has an image as well; keep the one that the geometry is of"
    elif sources:
        for column in stated:
            yield column, f"is measured in the {sources[0]}; leave the cell empty"
    elif "shape" in row or stated:
        yield from _wrong_shape(row)
    else:
        yield (
            "image",
            "no geometry; give an image, a surface, or a shape (cuboid or cylinder) with its "
            "dimensions",
        )
    if "image" not in row:
        for column in (name for name in IMAGE_COLUMNS if name in row):
            yield column, "concerns an image, and the row has none; leave the cell empty"
    if row.get("mode") in OF_SHAPES and sources:
        yield (
            "mode",
            f"{row['mode']} is simulated on ideal shapes only; give shape and dimensions in place "
            f"of the {sources[0]}",
        )


def _wrong_shape(row: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """What is wrong with a shape that is given by its dimensions."""
    shape = row.get("shape", "")
    if not shape:
        yield "shape", "is missing beside the dimensions; give cuboid or cylinder"
    for column in ANY_DIMENSION if shape in DIMENSIONS else ():
        needed = DIMENSIONS[shape]
        if column in needed and column not in row:
            yield column, f"is missing; a {shape} needs {', '.join(needed)}{_misplaced(row, shape)}"
        elif column in row and column not in needed:
            other = _misplaced(row, shape)
            cure = other if "column shape" in other else "; leave the cell empty"
            yield column, f"a {shape} has none (it needs {', '.join(needed)}){cure}"
    for column in (name for name in ANY_DIMENSION if _is_number(row.get(name, ""))):
        if not 0.0 < float(row[column]) <= LARGEST_MM:
            yield column, f"{row[column]} mm is no size of a sample; give it in mm"
    if row.get("mode") == "pure_shear" and shape == "cylinder":
        yield "shape", "a strip in pure shear (planar tension) is a cuboid; give its three edges"
    if row.get("mode") == "torsion" and shape == "cuboid":
        yield "shape", "what is turned about its axis is a cylinder; give diameter_mm and height_mm"


def _misplaced(row: Mapping[str, str], shape: str) -> str:
    """Where a dimension that a shape lacks may stand instead, as a cure; empty if nowhere."""
    missing = [name for name in DIMENSIONS[shape] if name not in row]
    beside = {row[name] for name in ANY_DIMENSION if name in row and name not in DIMENSIONS[shape]}
    if len(missing) == len(beside) == 1:
        return f"; write {beside.pop()} into column {missing[0]}"
    other = next(name for name in DIMENSIONS if name != shape)
    stated = {name for name in ANY_DIMENSION if name in row}
    return f"; write {other} into column shape" if stated == {*DIMENSIONS[other]} else ""


def _wrong_ends(row: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """What is wrong with how the ends of a sample are held in its test."""
    ends, mode = row.get("ends", "bonded"), row.get("mode", "")
    real = "image" in row or "surface" in row
    if ends == "unknown" and mode == "indentation":
        yield ("ends", "unknown on an indenter; give bonded, sliding or a coefficient of friction")
    if ends in ("unknown", "sliding") and mode == "torsion":
        yield "ends", f"{ends!r} in torsion, where only bonded ends turn a sample; leave it empty"
    if _is_number(ends) and mode not in ("", "compression", "indentation"):
        yield (
            "ends",
            f"{ends}: Coulomb friction holds only what is pressed, and not in {mode}; give bonded "
            "or sliding",
        )
    elif ends != "bonded" and mode in ("tension", "shear") and real:
        yield (
            "ends",
            f"{ends!r} in {mode} needs a shape with dimensions; with an image or a surface the "
            "bond decides, so leave the cell empty",
        )


def _wrong_indenter(row: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """What is wrong with the indenter of a test."""
    radius = row.get("indenter_radius_mm", "")
    if row.get("mode") != "indentation":
        for column in (name for name in INDENTER_COLUMNS if name in row):
            yield column, "belongs to mode indentation; leave the cell empty, or change the mode"
        return
    for column in (name for name in INDENTER_COLUMNS if name not in row):
        yield column, "is missing; give the kind (sphere or flat) and the radius in mm"
    sizes = [float(row[name]) for name in ANY_DIMENSION if _is_number(row.get(name, ""))]
    if _is_number(radius) and sizes and not 0.0 < float(radius) <= max(sizes):
        yield "indenter_radius_mm", f"{radius} mm is no radius on this sample; give it in mm"


def _doubled_samples(rows: Rows) -> Iterator[Fault]:
    seen: dict[str, int] = {}
    for line, row in rows.items():
        name = row.get("sample", "")
        if name and name.lower() in seen:
            reason = (
                f"{name!r} stands in row {seen[name.lower()]} already (upper and lower case count "
                "as the same, since ids become file names); give each sample an id of its own"
            )
            yield Fault(line, name, "sample", reason)
        seen.setdefault(name.lower(), line)


def _split_specimens(rows: Rows) -> Iterator[Fault]:
    lines: dict[str, dict[str, int]] = {}
    for line, row in rows.items():
        of_piece = lines.setdefault(resolved(row)["specimen"], {})
        of_piece.setdefault(row.get("group", ""), line)
    for line, row in rows.items():
        groups = dict(lines[row["specimen"]]) if "specimen" in row else {}
        groups.pop(row.get("group", ""), None)
        for other, first in groups.items():
            reason = (
                f"{row['specimen']!r} is of group {other!r} in row {first}; one piece belongs to "
                "one group, so correct one of them"
            )
            yield Fault(line, row.get("sample", "?"), "specimen", reason)


def refusals(instance: Any, schema: Schema) -> Iterator[tuple[str, str]]:
    """Place (`mesh.element_size_mm`) and reason, with cure, of everything a schema refuses."""
    validator = Draft202012Validator(schema)
    errors = sorted(validator.iter_errors(instance), key=_in_order)
    # each name that is missing is an error that tells of all of them
    yield from dict.fromkeys(refusal for error in errors for refusal in _explain(error))


def _in_order(error: ValidationError) -> list[str]:
    """Sort key of the place in a document; list positions count as numbers."""
    return [f"{part:09d}" if isinstance(part, int) else str(part) for part in error.absolute_path]


def _explain(error: ValidationError) -> Iterator[tuple[str, str]]:
    place = [str(part) for part in error.absolute_path]
    assert isinstance(error.schema, Mapping)
    given: Any = error.instance
    wanted: Any = error.validator_value
    cure = error.schema.get("cure") or error.schema.get("description")
    if error.validator == "additionalProperties":
        known = error.schema.get("properties", {})
        for name in sorted(map(str, set(given) - set(known))):
            yield ".".join([*place, name]), _unknown(name, known)
    elif error.validator == "required":
        properties = error.schema.get("properties", {})
        for name in (n for n in wanted if n not in given):
            meaning = properties.get(name, {}).get("description", "see config/README.md")
            yield ".".join([*place, name]), f"is missing; give {meaning}"
    else:
        yield ".".join(place), f"{_reason(error)}; expected: {cure or 'see config/README.md'}"


KINDS = {
    "array": "a list, in brackets or with a dash before each item",
    "object": "a block of keys with values",
    "number": "a number",
    "integer": "a whole number",
    "string": "a text",
    "boolean": "true or false",
    "null": "empty",
}
"""Types of a schema in words."""


def _unknown(name: str, known: Mapping[str, Any]) -> str:
    near = [block for block, of in known.items() if name in of.get("properties", {})]
    near = [f"{block}: {name}" for block in near] or difflib.get_close_matches(name, [*known], n=1)
    hint = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(known)}"
    return f"unknown name; {hint}"


def _reason(error: ValidationError) -> str:
    value: Any = error.instance
    wanted: Any = error.validator_value
    if error.validator == "type" and isinstance(value, str) and _is_number(value):
        return f"{value!r} is read as text; write a number with a decimal point, such as 1.0e-3"
    if error.validator == "type":
        kinds = [wanted] if isinstance(wanted, str) else wanted
        return f"{value!r} is not {' or '.join(KINDS[kind] for kind in kinds)}"
    if error.validator == "not":
        return f"{value!r} is not allowed"
    if error.validator in ("anyOf", "oneOf"):
        return f"{value!r} is none of what is allowed"
    if error.validator == "minItems":
        return f"a list of {len(value)} is too short"
    if error.validator == "enum":
        return f"{value!r} is not one of {', '.join(map(str, wanted))}"
    assert isinstance(error.schema, Mapping)
    if error.validator == "pattern" and error.schema.get("names") == "file":
        ending = "a wrong" if "." in PurePosixPath(str(value)).name else "no"
        return f"{value!r} has {ending} extension"
    if error.validator == "pattern":
        return f"{value!r} has another form"
    return str(error.message)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
