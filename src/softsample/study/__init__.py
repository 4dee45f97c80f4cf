"""A lab's own study: its folder, and everything that is wrong with it."""

from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

from softsample.errors import InputError
from softsample.io import read_yaml


def _root() -> Path:
    """The clone that this file lies in, or what the wheel has brought along."""
    clone = Path(__file__).resolve().parents[3]
    if (clone / "Snakefile").is_file():
        return clone
    brought = [f for f in metadata.files("softsample") or [] if f.name == "Snakefile"]
    outermost = min(brought, key=lambda f: len(f.parts))
    return Path(str(outermost.locate())).resolve().parent


ROOT = _root()
"""What holds the workflow, its settings and schemas, and the worked sample."""

TABLE, SETTINGS = "samples.tsv", "study.yaml"
"""Files of a study folder."""


def table_of(folder: Path) -> Path:
    """The table of samples of a study folder; refuses a folder without one."""
    if not (folder / TABLE).is_file():
        raise InputError(
            f"{folder / TABLE}: no such table; make a study with: softsample new {folder}"
        )
    return folder / TABLE


@cache
def schema(name: str) -> dict[str, Any]:
    """A schema of the workflow."""
    return read_yaml(ROOT / f"workflow/schemas/{name}.schema.yaml")


def columns() -> dict[str, str]:
    """Columns of the table of samples and what they mean."""
    properties = schema("samples")["properties"]
    return {
        name: about.get("description", name.replace("_", " ")) for name, about in properties.items()
    }
