"""Text of Jinja templates, the same way for all pages."""

import os
from collections.abc import Callable, Mapping
from typing import Any

import jinja2


def render(
    template: str | os.PathLike[str],
    values: Mapping[str, Any],
    *,
    html: bool = False,
    **filters: Callable[..., Any],
) -> str:
    """The text of a template, in which values and filters stand under their names.

    Of `html` a value is escaped unless it is marked as HTML.

    Raises
    ------
    jinja2.UndefinedError
        If the template uses what is not there.
    """
    folder, name = os.path.split(template)
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder), undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=not html, autoescape=html,
    )  # fmt: skip
    environment.filters |= filters
    return environment.get_template(name).render(values)
