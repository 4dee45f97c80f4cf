"""Parts of the report of a study: one HTML file that needs nothing outside itself."""

import base64
import json
import re
from collections.abc import Iterator, Mapping
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any, BinaryIO

import jinja2
import pandas as pd
from docutils.core import publish_parts
from markdown_it import MarkdownIt
from markupsafe import Markup, escape
from PIL import Image

from softsample.report.page import MISSING
from softsample.report.template import render
from softsample.wording import DIGITS, significant, true_minus

WEBP_QUALITY = 86
"""Of embedded pictures: at a fifth of a PNG's size, text and contours stay crisp."""

WIDE = 10
"""A table of more columns is printed on a page of its own across."""

EXACT = 12
"""Digits of a setting, as it is in its file."""

NUMBER = r"−?[\d.]+|< ([\d.]+|noise)"
"""What a cell aligns as a number though it is text."""

UNITS = {
    "pa": "Pa", "mm": "mm", "mm2": "mm²", "mm3": "mm³", "N": "N", "s": "s", "hz": "Hz",
    "deg": "°", "percent": "%", "points": "points",
}  # fmt: skip
"""Unit by the last part of a column's name."""


def render_report(template: Path, **parts: Any) -> str:
    """The page; in the template a value is escaped unless it is HTML made by this module.

    Raises
    ------
    jinja2.UndefinedError
        If the template uses a part that is not given.
    """
    return render(template, parts, html=True, table=table, written=written)


def caption(template: Path, config: Mapping[str, Any], **wildcards: str) -> Markup:
    """A caption in reStructuredText as HTML.

    Parameters
    ----------
    template
        Jinja template of reStructuredText, in which `snakemake.config` and
        `snakemake.wildcards` are known. Files that it includes are relative to the working
        directory.
    config, wildcards
        What the template is filled with.

    Raises
    ------
    docutils.utils.SystemMessage
        If a number that the caption quotes is not defined, or the text is not well-formed.
    """
    snakemake = SimpleNamespace(config=config, wildcards=SimpleNamespace(**wildcards))
    text = jinja2.Template(template.read_text(encoding="utf-8"), undefined=jinja2.StrictUndefined)
    settings = {"halt_level": 3, "report_level": 3, "initial_header_level": 1, "raw_enabled": False}
    settings |= {"doctitle_xform": False}
    source = text.render(snakemake=snakemake)
    parts = publish_parts(source, writer="html5", settings_overrides=settings)
    return Markup(parts["body"])


def markdown(text: str, pictures: Mapping[str, Path]) -> Markup:
    """Markdown with tables as HTML; tags in the text are shown, not obeyed.

    Headings go down by three levels, to fit below a sample's; `pictures` that the text links are
    put in.
    """
    deeper = re.sub(r"^(#+) ", r"###\1 ", text, flags=re.MULTILINE)
    html = MarkdownIt("commonmark", {"html": False}).enable("table").render(deeper)
    for name, path in pictures.items():
        link = re.compile(rf'<img src="{re.escape(name)}" alt="([^"]*)" />')
        if found := link.search(html):
            html = link.sub(picture(path, found[1]), html)
    return Markup(html)


def picture(path: Path | BinaryIO, description: str) -> Markup:
    """A picture inside the page, as WebP."""
    buffer = BytesIO()
    with Image.open(path) as image:
        width, height = image.size
        image.convert("RGB").save(buffer, "WEBP", quality=WEBP_QUALITY, method=2)
    data = base64.b64encode(buffer.getvalue()).decode()
    return Markup('<img src="data:image/webp;base64,{}" width="{}" height="{}" alt="{}">').format(
        data, width, height, description
    )


def table(frame: pd.DataFrame) -> Markup:
    """A table as HTML: units in the head, columns without any value left out."""
    if frame.empty:
        return Markup("<p>No rows: nothing of this is known of the samples.</p>")
    frame = frame.dropna(axis="columns", how="all")
    head = "".join(f"<th>{escape(heading(str(name)))}</th>" for name in frame.columns)
    body = "".join(
        "<tr>{}</tr>\n".format("".join(map(_cell, row)))
        for row in frame.itertuples(index=False, name=None)
    )
    kind = ' class="wide"' if len(frame.columns) > WIDE else ""
    return Markup(f"<table{kind}><thead><tr>{head}</tr></thead><tbody>\n{body}</tbody></table>")


def download(path: Path) -> Markup:
    """A link that saves a text file out of the page."""
    data = base64.b64encode(path.read_bytes()).decode()
    return Markup('<a download="{}" href="data:text/csv;base64,{}">{}</a>').format(
        path.name, data, path.name
    )


def as_json(data: Mapping[str, Any]) -> Markup:
    """Data for a script element, in which no text can end it."""
    return Markup(json.dumps(data, separators=(",", ":")).replace("<", "\\u003c"))


def heading(column: str) -> str:
    """Name of a column with its unit in brackets: `mu_real_pa` is `mu real [Pa]`."""
    name, _, last = column.rpartition("_")
    if name and last in UNITS:
        return f"{name.replace('_', ' ')} [{UNITS[last]}]"
    return column.replace("_", " ")


def written(value: Any, digits: int = DIGITS) -> str:
    """A value for people: rounded to significant digits, a true minus sign, a dash for none."""
    if value is None or (isinstance(value, float) and value != value):
        return MISSING
    if isinstance(value, float):
        return true_minus(significant(value, digits))
    if isinstance(value, list | tuple):
        return ", ".join(written(item, digits) for item in value)
    if isinstance(value, Mapping):
        parts = (f"{key}: {written(item, digits)}" for key, item in value.items())
        return "; ".join(parts) or MISSING
    return str(value)


def _cell(value: Any) -> str:
    number = isinstance(value, int | float) or re.fullmatch(NUMBER, str(value))
    kind = ' class="number"' if number else ""
    return f"<td{kind}>{escape(written(value))}</td>"


def parameters(
    config: Mapping[str, Any], schema: Mapping[str, Any], within: str = ""
) -> Iterator[tuple[str, str, str]]:
    """Every setting of a study: its path, its value, and what the schema says it means."""
    known = schema.get("properties", {})
    for key, value in config.items():
        part = known.get(key, {})
        place = f"{within}{key}"
        if isinstance(value, Mapping) and part.get("properties"):
            yield from parameters(value, part, f"{place}: ")
        else:
            yield place, written(value, EXACT), part.get("description", "")
