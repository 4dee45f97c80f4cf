"""A lab's own study: its folder, and everything that is wrong with it."""

from pathlib import Path

from softsample.errors import InputError

ROOT = Path(__file__).resolve().parents[3]
"""The checkout, which holds configuration, schemas and the worked sample."""

TABLE, SETTINGS = "samples.tsv", "study.yaml"
"""Files of a study folder."""


def table_of(folder: Path) -> Path:
    """The table of samples of a study folder; refuses a folder without one."""
    if not (folder / TABLE).is_file():
        raise InputError(
            f"{folder / TABLE}: no such table; make a study with: make new-study DIR={folder}"
        )
    return folder / TABLE
