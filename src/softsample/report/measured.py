"""Verdicts on others' records as tables, and as a page of the report."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

Verdicts = Sequence[Mapping[str, Any]]

SUMMARY = (
    "set", "record_group", "verdict", "class", "held_out_before_percent",
    "held_out_after_percent", "records",
)  # fmt: skip
EFFECTS = (
    "set", "record_group", "effect", "class", "parameter", "value", "unit", "low", "high",
    "evidence", "experiment",
)  # fmt: skip
UNDECIDED_FIRST = {"unknown": 0, "explained": 1, "none": 2}


def summary_table(verdicts: Verdicts) -> pd.DataFrame:
    """One row a group of records and model of its shape (`group/model`).

    Returns
    -------
    DataFrame
        `set`, `record_group`, `verdict`, `class` (names that cannot be told apart joined by
        ``|``, effects by ``; ``), `held_out_before_percent`, `held_out_after_percent` (RMS in %
        of the peak of the held-out part), `records`.
    """
    rows = [
        (
            verdict["set"],
            _name(group),
            group["verdict"],
            "; ".join("|".join(effect["class"]) for effect in group["effects"]),
            group["held_out_before_percent"],
            group["held_out_after_percent"],
            group["records"],
        )
        for verdict in verdicts
        for group in verdict["groups"]
    ]
    return pd.DataFrame(rows, columns=list(SUMMARY))


def effect_table(verdicts: Verdicts) -> pd.DataFrame:
    """One row a parameter of an effect that was given: size, 90 % interval, evidence."""
    rows = [
        (
            verdict["set"],
            _name(group),
            effect["name"],
            "|".join(effect["class"]),
            name,
            p["value"],
            p["unit"],
            p["low"],
            p["high"],
            effect["evidence"],
            effect["separating_experiment"],
        )
        for verdict in verdicts
        for group in verdict["groups"]
        for effect in group["effects"]
        for name, p in effect["parameters"].items()
    ]
    return pd.DataFrame(rows, columns=list(EFFECTS))


def channel_table(verdicts: Verdicts) -> pd.DataFrame:
    """Held-out error of each mode or channel that was held out apart: what predicts what.

    Returns
    -------
    DataFrame
        `set`, `record_group`, `channel`, `before_percent`, `after_percent` (RMS in % of the peak).
    """
    rows = [
        (verdict["set"], _name(group), channel, error["before_percent"], error["after_percent"])
        for verdict in verdicts
        for group in verdict["groups"]
        for channel, error in group["held_out_by"].items()
    ]
    names = ("set", "record_group", "channel", "before_percent", "after_percent")
    return pd.DataFrame(rows, columns=list(names))


def evidence_table(verdicts: Verdicts) -> pd.DataFrame:
    """What runs without a sample say: `set`, `quantity` (unit in its name), `value`."""
    rows = [
        (verdict["set"], quantity, value)
        for verdict in verdicts
        for quantity, value in verdict["independent_evidence"].items()
    ]
    return pd.DataFrame(rows, columns=["set", "quantity", "value"])


def setting_table(settings: Mapping[str, Mapping[str, Any]]) -> pd.DataFrame:
    """Settings of each set: `set`, `held_out`, `exponents`, `reach_percent`, `fitted_percent`."""
    rows = [
        (
            name,
            keys["held_out"],
            " and ".join(f"{a:g}" for a in keys["alpha"]),
            100.0 * keys["reach"],
            100.0 * keys.get("fitted_reach", keys["reach"]),
        )
        for name, keys in settings.items()
    ]
    names = ("set", "held_out", "exponents", "reach_percent", "fitted_percent")
    return pd.DataFrame(rows, columns=list(names))


def unstated_table(verdicts: Verdicts) -> pd.DataFrame:
    """What the sources do not state: `set`, `unstated`."""
    rows = [(verdict["set"], text) for verdict in verdicts for text in verdict["unstated"]]
    return pd.DataFrame(rows, columns=["set", "unstated"])


def zero_table(zeros: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Records whose zeros differ from their siblings', of all sets, the largest first."""
    parts = [table.assign(set=name) for name, table in zeros.items() if len(table)]
    if not parts:
        return pd.DataFrame(columns=["record", "effect", "class", "size", "unit", "sigmas"])
    table = pd.concat(parts)
    return table.sort_values("sigmas", key=abs, ascending=False, ignore_index=True)


def set_page(verdict: Mapping[str, Any]) -> str:
    """Page of a set in Markdown: first what stays unknown, then what was found.

    It links the figure of the held-out errors as `errors.png`.
    """
    groups = sorted(verdict["groups"], key=lambda group: UNDECIDED_FIRST[group["verdict"]])
    counts = pd.Series([group["verdict"] for group in groups]).value_counts(sort=False)
    said = ", ".join(f"{count} {name}" for name, count in counts.items())
    lines = [f"**Verdicts: {said}.**", ""]
    lines += [f"- {_sentence(group)}" for group in groups]
    lines += ["", "![Held-out error of each group, before and after](errors.png)"]
    lines += ["", "Not stated by the source:", ""]
    lines += [f"- {text}" for text in verdict["unstated"]]
    return "\n".join([*lines, ""])


def _name(group: Mapping[str, Any]) -> str:
    return f"{group['record_group']}/{group['model']}"


def _sentence(group: Mapping[str, Any]) -> str:
    """What was found in a group, with the error before and after on the held-out part."""
    before, after = group["held_out_before_percent"], group["held_out_after_percent"]
    error = f"held-out error {before:.1f} % before, {after:.1f} % after"
    if group["verdict"] != "explained":
        withheld = ", ".join(group["withheld"])
        why = f"; not supported by the fitted part: {withheld}" if withheld else ""
        return f"{_name(group)}: {group['verdict']}{why} ({error})"
    effects = "; ".join(
        f"{' or '.join(effect['class'])} (evidence {effect['evidence']:.0f}; what would tell: "
        f"{effect['separating_experiment']})"
        for effect in group["effects"]
    )
    return f"{_name(group)}: {effects} ({error})"
