"""Pages of docs/ from templates beside this file."""

from pathlib import Path
from typing import Any

import jinja2

from softsample.io import write_text

HERE = Path(__file__).parent


def write_page(name: str, **values: Any) -> None:
    """Write docs/{name}.md from {name}.md.j2."""
    template = jinja2.Template(
        (HERE / f"{name}.md.j2").read_text(encoding="utf-8"),
        trim_blocks=True,
        keep_trailing_newline=True,
        undefined=jinja2.StrictUndefined,
    )
    write_text(HERE.parent / "docs" / f"{name}.md", template.render(**values))


def recovered(true: float, fitted: float, low: float | None, high: float | None) -> str:
    """A true value, and the fitted one with its interval, which may be open."""
    ends = ("open" if end is None else f"{end:.3g}" for end in (low, high))
    return f"{true:g}, {fitted:.3g} ({' to '.join(ends)})"
