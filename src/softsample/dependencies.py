"""Which files of the library a script rests on: its hidden inputs."""

import ast
import os
import re
from functools import cache
from itertools import accumulate, chain
from pathlib import Path

from softsample.workflow import sha256_of_files

IMPORTS_NUMBA = re.compile(r"^\s*(?:from|import) numba\b", re.MULTILINE)


@cache
def imported(path: Path, sources: Path) -> list[Path]:
    """Files below `sources` that a file imports directly, or by looking through its own folder."""
    text = path.read_text(encoding="utf-8")
    found = list(path.parent.glob("*.py")) if "iter_modules(__path__)" in text else []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        parts = (accumulate(name.split("."), "{}/{}".format) for name in names)
        for name in chain.from_iterable(parts):
            files = (sources / f"{name}.py", sources / f"{name}/__init__.py")
            found += [file for file in files if file.is_file()]
    return found


def dependencies(script: Path, sources: Path) -> list[str]:
    """Files below `sources` that a script imports, directly or not, relative to here."""
    seen: set[Path] = set()
    todo = {script}
    while todo:
        new = set(imported(todo.pop(), sources)) - seen
        seen |= new
        todo |= new
    return sorted(os.path.relpath(file) for file in seen)


def state_of_kernels(sources: Path) -> str:
    """Hash of the compiled sources, elastic laws included, of the library in `sources`.

    A compiled kernel that calls another file's text keeps the old callee after an edit.
    """
    return sha256_of_files(
        path
        for path in sorted((sources / "softsample").rglob("*.py"))
        if IMPORTS_NUMBA.search(path.read_text("utf-8")) or "constitutive" in path.parts
    )[:16]
