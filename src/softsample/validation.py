"""Closed, bounded schemas: every refusal names file, place, value and cure."""

import difflib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import pandas as pd
from jsonschema import Draft202012Validator
from jsonschema.exceptions import ValidationError

from softsample.errors import InputError

Schema = Mapping[str, Any]

NOT_SUPPORTED = {
    "shape": "the geometry has to come from an image",
    "length_mm": "the geometry has to come from an image",
    "width_mm": "the geometry has to come from an image",
    "height_mm": "the geometry has to come from an image",
    "diameter_mm": "the geometry has to come from an image",
}
"""Columns of the study table that are planned and not built yet, with what holds meanwhile."""

DEFAULT_AXES = {"loading_axis": "+z", "shear_axis": "+x"}
"""Image world axes of the test where the table does not name others."""


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
    found = list(refusals(dict(config), schema))
    if found:
        lines = [f"  {place or 'top level'}: {reason}" for place, reason in found]
        raise InputError("\n".join([f"configuration ({source}) is refused:", *lines]))


def check_samples(table: pd.DataFrame, schema: Schema, source: str) -> list[dict[str, str]]:
    """Check the table of samples, cell by cell and as a whole.

    Parameters
    ----------
    table
        Cells as text, from `softsample.io.read_samples`.
    schema
        Schema of one row.
    source
        The table's path, for the message.

    Returns
    -------
    list of dict
        One a row, empty cells left out.

    Raises
    ------
    InputError
        Naming every wrong cell at once: row (the header is row 1), column, value, cure.
    """
    if table.empty:
        raise InputError(f"{source} has no rows; add one line for each sample")
    rows = [
        {str(key): value.strip() for key, value in row.items() if str(value).strip()}
        for row in table.to_dict("records")
    ]
    lines = [*_wrong_columns(table, schema)]
    if not lines:
        lines = [*_wrong_cells(rows, schema), *_wrong_together(rows)]
    if lines:
        raise InputError("\n".join([f"table of samples {source} is refused:", *lines]))
    return rows


def _wrong_columns(table: pd.DataFrame, schema: Schema) -> Iterator[str]:
    columns = [str(column) for column in table.columns]
    for missing in (name for name in schema["required"] if name not in columns):
        yield (
            f"  column {missing!r} is missing (there are {', '.join(columns)}); "
            "the table is tab-separated, with a header"
        )
    for unknown in (name for name in columns if name not in schema["properties"]):
        yield f"  column {unknown!r}: {_unknown(unknown, schema['properties'])}"


def _wrong_cells(rows: Sequence[Mapping[str, str]], schema: Schema) -> Iterator[str]:
    for number, row in enumerate(rows, start=2):
        for column, reason in refusals(dict(row), schema):
            yield f"  row {number} ({row.get('sample', '?')}), column {column!r}: {reason}"
        for column in (name for name in NOT_SUPPORTED if name in row):
            yield (
                f"  row {number} ({row.get('sample', '?')}), column {column!r}: not supported "
                f"yet ({NOT_SUPPORTED[column]}); leave the cell empty"
            )
        if row.get("mode") == "compression" and "bond_mask" in row:
            yield (
                f"  row {number} ({row.get('sample', '?')}), column 'bond_mask': the top is not "
                "glued in compression; leave the cell empty"
            )
        loading, shear = (row.get(name, default) for name, default in DEFAULT_AXES.items())
        if loading[-1] == shear[-1]:
            yield (
                f"  row {number} ({row.get('sample', '?')}), column 'shear_axis': {shear!r} is "
                f"parallel to the loading axis {loading!r}; give two different axes"
            )


def _wrong_together(rows: Sequence[Mapping[str, str]]) -> Iterator[str]:
    seen: dict[str, int] = {}
    for number, row in enumerate(rows, start=2):
        name = row.get("sample", "")
        if name.lower() in seen:
            yield (
                f"  row {number}, column 'sample': {name!r} stands in row {seen[name.lower()]} "
                "already (upper and lower case count as the same, since ids become file "
                "names); give each sample an id of its own"
            )
        seen.setdefault(name.lower(), number)


def refusals(instance: Any, schema: Schema) -> Iterator[tuple[str, str]]:
    """Place (`mesh.element_size_mm`) and reason, with cure, of everything a schema refuses."""
    validator = Draft202012Validator(schema)
    for error in sorted(validator.iter_errors(instance), key=_in_order):
        yield from _explain(error)


def _in_order(error: ValidationError) -> list[str]:
    """Sort key of the place in a document; list positions count as numbers."""
    return [f"{part:09d}" if isinstance(part, int) else part for part in error.absolute_path]


def _explain(error: ValidationError) -> Iterator[tuple[str, str]]:
    place = [str(part) for part in error.absolute_path]
    assert isinstance(error.schema, Mapping)
    given: Any = error.instance
    wanted: Any = error.validator_value
    cure = error.schema.get("cure") or error.schema.get("description")
    if error.validator == "additionalProperties":
        known = error.schema.get("properties", {})
        for name in sorted(set(given) - set(known)):
            yield ".".join([*place, name]), _unknown(name, known)
    elif error.validator == "required":
        properties = error.schema.get("properties", {})
        for name in (n for n in wanted if n not in given):
            meaning = properties.get(name, {}).get("description", "see config/README.md")
            yield ".".join([*place, name]), f"is missing; give {meaning}"
    else:
        yield ".".join(place), f"{_reason(error)}; expected: {cure or 'see config/README.md'}"


def _unknown(name: str, known: Mapping[str, Any]) -> str:
    near = difflib.get_close_matches(name, list(known), n=1)
    hint = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(known)}"
    return f"unknown name; {hint}"


def _reason(error: ValidationError) -> str:
    value: Any = error.instance
    wanted: Any = error.validator_value
    if error.validator == "type" and isinstance(value, str) and _is_number(value):
        return f"{value!r} is read as text; write a number with a decimal point, such as 1.0e-3"
    if error.validator == "enum":
        return f"{value!r} is not one of {', '.join(map(str, wanted))}"
    if error.validator == "pattern":
        return f"{value!r} has another form"
    return str(error.message)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
