"""Pages of reference that are made from schemas and from the command line itself."""

import argparse
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from softsample.__main__ import command_line

Schema = Mapping[str, Any]

PAGES = {
    "config": ("Settings", "Every key of `config.yaml`, with its default."),
    "samples": ("Columns of the table of samples", "Each row of `samples.tsv` follows this."),
    "results": ("results.json", "Main numbers of a study, in `results/results.json`."),
}


MARK = re.compile(r"# ASSUME: (.*(?:\n *# .*)*)")
"""An assumption and the lines of comment that go on with it."""

SIGNS = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}
"""How the bounds of a schema are written."""


def write_reference(root: Path, folder: Path) -> None:
    """Write a page of Markdown for each schema, one for the command line and one for the code."""
    folder.mkdir(exist_ok=True)
    defaults = yaml.safe_load((root / "config/config.yaml").read_text(encoding="utf-8"))
    for name, (title, about) in PAGES.items():
        file = f"workflow/schemas/{name}.schema.yaml"
        schema = yaml.safe_load((root / file).read_text(encoding="utf-8"))
        shown = defaults if name == "config" else None
        page = [f"# {title}", "", f"{about} From `{file}`.", "", *schema_table(schema, shown), ""]
        (folder / f"{name}.md").write_text("\n".join(page), encoding="utf-8")
    page = ["# Command line", "", *command_pages(command_line())]
    (folder / "commands.md").write_text("\n".join(page), encoding="utf-8")
    (folder / "assumptions.md").write_text("\n".join(assumptions(root / "src")), encoding="utf-8")
    (folder / "code.md").write_text("\n".join(code_page(root / "src")), encoding="utf-8")


def schema_table(schema: Schema, defaults: Schema | None = None) -> list[str]:
    """Lines of a table: key, what it may be, what it means, and its default if there are any."""
    head = ["key", "may be", "meaning"] + (["default"] if defaults is not None else [])
    rows = [head, ["---"] * len(head)]
    for place, part in keys(schema, schema):
        cells = [f"`{': '.join(place)}`", _allowed(part), part.get("description", "")]
        if defaults is not None:
            value = "" if "properties" in part else _lookup(defaults, place)
            cells.append("" if value == "" else f"`{value}`")
        rows.append([cell.replace("|", "\\|").replace("\n", " ") for cell in cells])
    return [f"| {' | '.join(row)} |" for row in rows]


def keys(
    schema: Schema, whole: Schema, place: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], Schema]]:
    """Every key of a schema with its description, `...` for names that are free."""
    parts = {(*place, name): part for name, part in schema.get("properties", {}).items()}
    if isinstance(free := schema.get("additionalProperties"), Mapping):
        parts[*place, "..."] = free
    if isinstance(items := schema.get("items"), Mapping) and "properties" in items:
        parts |= {(*place, name): part for name, part in items["properties"].items()}
    for at, part in parts.items():
        resolved = {**_referred(part, whole), **part}
        yield at, resolved
        yield from keys(resolved, whole, at)


def command_pages(parser: argparse.ArgumentParser) -> Iterator[str]:
    """What the command line and each of its commands say when asked for help."""
    yield from ["```text", parser.format_help().rstrip(), "```", ""]
    for action in parser._actions:  # argparse has no public list of its commands
        if isinstance(action, argparse._SubParsersAction):
            for name, command in action.choices.items():
                yield from [f"## {name}", "", "```text", command.format_help().rstrip(), "```", ""]


def assumptions(sources: Path) -> Iterator[str]:
    """Every comment that begins with `ASSUME:`, with the module that it stands in."""
    yield from ["# Assumptions", "", "Where the code assumes what no source fixes.", ""]
    yield from ["| module | assumption |", "|---|---|"]
    for path in sorted(sources.rglob("*.py")):
        module = ".".join(path.relative_to(sources).with_suffix("").parts)
        for text in MARK.findall(path.read_text(encoding="utf-8")):
            words = " ".join(line.strip().removeprefix("#").strip() for line in text.splitlines())
            yield f"| `{module}` | {words} |"
    yield ""


def code_page(sources: Path) -> Iterator[str]:
    """Every module, described by its docstrings on a page of its own."""
    yield from ["# Code", "", "Shapes, units, errors and sources are in the descriptions.", ""]
    yield from ["```{eval-rst}", ".. autosummary::", "   :toctree: code", ""]
    for path in sorted(sources.rglob("*.py")):
        parts = path.relative_to(sources).with_suffix("").parts
        if parts[-1] not in ("__init__", "__main__"):
            yield f"   {'.'.join(parts)}"
    yield from ["```", ""]


def _referred(part: Schema, whole: Schema) -> Schema:
    """The definition that a part refers to, if it does."""
    reference = part.get("$ref", "")
    return whole["$defs"][reference.rsplit("/", 1)[1]] if reference else {}


def _allowed(part: Schema) -> str:
    """Type and bounds in words."""
    if "enum" in part:
        return ", ".join(f"`{value}`" for value in part["enum"])
    kinds = part.get("type", "")
    kind = " or ".join(kinds) if isinstance(kinds, list) else str(kinds)
    bounds = [f"{sign} {part[key]}" for key, sign in SIGNS.items() if key in part]
    return " ".join([kind, ", ".join(bounds)]).strip()


def _lookup(config: Schema, place: tuple[str, ...]) -> Any:
    value: Any = config
    for key in place:
        if not isinstance(value, Mapping) or key not in value:
            return ""
        value = value[key]
    return value
