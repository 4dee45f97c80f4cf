"""Pages of the documentation, rendered from tables so that no number is typed."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from softsample.report.geometry_effects import spoken as experiment
from softsample.report.template import render
from softsample.wording import significant, spoken, true_minus

MISSING = "–"


def render_page(template: Path, tables: Mapping[str, pd.DataFrame]) -> str:
    """A page of Markdown.

    Parameters
    ----------
    template
        Jinja template. In it, each table is a list of rows under its name; `figures` of a
        page are linked by their paths.
    tables
        Tables by name; those that a study does not have are absent, and the template asks
        with `is defined`.

    Raises
    ------
    jinja2.UndefinedError
        If the template uses a table or column that is not there.
    """
    rows = {name: table.to_dict("records") for name, table in tables.items()}
    values = {**rows, "spoken": experiment}
    return render(template, values, fixed=fixed, signed=signed, mean=mean, loading=spoken)


def fixed(value: Any, digits: int = 1) -> str:
    """A number with a fixed number of decimals and a true minus sign; a dash for none."""
    return _written(value, f".{digits}f")


def signed(value: Any, digits: int = 1) -> str:
    """The same with its sign."""
    return _written(value, f"+.{digits}f")


def with_interval(value: float, low: float | None, high: float | None) -> str:
    """A number and, if they are known, the ends of its interval; it may have no upper one."""
    text = significant(value)
    if low is None or not np.isfinite(low):
        return text
    if high is None or not np.isfinite(high):
        return f"{text} ({significant(low)} or more)"
    return f"{text} ({significant(low)} to {significant(high)})"


def mean(rows: list[dict[str, Any]], column: str) -> float:
    """Mean of a column, rows without a value left out; NaN if none has one."""
    values = np.array([row[column] for row in rows], dtype=float)
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")


def _written(value: Any, form: str) -> str:
    if not np.isfinite(value):
        return MISSING
    text = format(float(value), form)
    bare = text.lstrip("+-")
    if float(bare) == 0.0:
        text = bare
    return true_minus(text)
