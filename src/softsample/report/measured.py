"""Verdicts on the public measured sets as tables."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from softsample.arrays import root_mean_square
from softsample.report.loop import held_out_percent

Verdict = Mapping[str, Any]

SUMMARY = (
    "set", "rule", "group", "verdict", "law", "effects", "held_out_before_percent",
    "held_out_after_percent", "fitted_before_percent", "fitted_after_percent",
)  # fmt: skip
OVERVIEW = (
    "set", "rule", "groups", "verdicts", "found", "held_out_before_percent",
    "held_out_after_percent",
)  # fmt: skip
FAILED = "failed"
"""Stands for the verdict of a group whose run did not come through."""


def summary_table(found: Iterable[tuple[str, str, Verdict | None]]) -> pd.DataFrame:
    """One row a group of a study.

    Parameters
    ----------
    found
        Study, group and the content of its `verdict.json`, None if there is none.

    Returns
    -------
    DataFrame
        Columns `SUMMARY`: names that cannot be told apart joined by ``|``, effects by ``; ``,
        after a class those that its correction is given with. Errors are root mean squares over
        tests [% of peak], those of held-out parts over the tests of all declared folds; NaN where
        there are none.
    """
    rows = [
        (study, *_cells(group, verdict))
        if verdict is not None
        else (study, "", group, FAILED, "", "", *(np.nan,) * 4)
        for study, group, verdict in found
    ]
    return pd.DataFrame(rows, columns=list(SUMMARY))


def _cells(group: str, verdict: Verdict) -> tuple[Any, ...]:
    effects = "; ".join("|".join(effect["class"]) for effect in verdict["effects"])
    if verdict["verdict"] == "explained_class":
        correction = verdict["correction"]
        effects = "; ".join([f"class: {correction['class']}", *correction["with"]])
    errors = (
        *(root_mean_square([*held_out_percent(verdict, when).values()]) for when in WHEN),
        *(root_mean_square([*fitted(verdict[f"error_{when}"])]) for when in WHEN),
    )
    law = (verdict["elastic_law"] or {}).get("name", "")
    return verdict["rule"], group, verdict["verdict"], law, effects, *errors


WHEN = ("before", "after")


def fitted(tests: Mapping[str, Mapping[str, Mapping[str, float]]] | None) -> Iterator[float]:
    """Errors [% of peak] of the fitted tests, all phases together."""
    for phases in (tests or {}).values():
        if "all" in phases:
            yield phases["all"]["rms_percent"]


def overview_table(summary: pd.DataFrame) -> pd.DataFrame:
    """One row a study: groups, how many of each verdict and effect, medians of held-out errors.

    An effect counts where it is the first of those that cannot be told apart.

    Parameters
    ----------
    summary
        As of `summary_table`.

    Returns
    -------
    DataFrame
        Columns `OVERVIEW`.
    """
    rows = [
        (
            study,
            next(filter(None, part["rule"]), ""),
            len(part),
            _counted(part["verdict"]),
            _counted(_first_names(part["effects"])),
            part["held_out_before_percent"].median(),
            part["held_out_after_percent"].median(),
        )
        for study, part in summary.groupby("set", sort=False)
    ]
    return pd.DataFrame(rows, columns=list(OVERVIEW))


def _counted(names: pd.Series) -> str:
    """How often each name occurs, the most frequent first."""
    return ", ".join(f"{n} {name}" for name, n in names.value_counts().items())


def _first_names(effects: pd.Series) -> pd.Series:
    """First members of the classes in a column of `summary_table`."""
    classes = effects.str.split("; ").explode()
    return classes[classes != ""].str.split("|").str[0]
