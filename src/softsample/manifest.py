"""Shipped files against their manifest."""

import os
from collections.abc import Iterable
from pathlib import Path

import pandas as pd

from softsample.errors import InputError
from softsample.files import sha256


def check_files(
    manifest: pd.DataFrame, source: str | os.PathLike[str], files: Iterable[str]
) -> None:
    """Compare files with the manifest's hashes.

    Parameters
    ----------
    manifest
        Columns `file` (relative to the manifest) and `sha256`.
    source
        The manifest's path.
    files
        Paths of the files to compare.

    Raises
    ------
    InputError
        Naming every file that is not listed or differs.
    """
    root = Path(source).resolve().parent
    listed = dict(zip(manifest["file"], manifest["sha256"], strict=True))
    wrong = []
    for path in map(Path, files):
        name = path.resolve().relative_to(root).as_posix()
        found = sha256(path)
        if listed.get(name) != found:
            state = "has changed" if name in listed else "is not listed"
            wrong.append(f"  {name} {state} (sha256 {found[:12]}...)")
    if wrong:
        head = (
            f"files do not agree with {source}; restore them, or copy the folder and give "
            "the copy with --config samples=PATH:"
        )
        raise InputError("\n".join([head, *wrong]))
