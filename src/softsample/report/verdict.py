"""The verdict on one page, for people: its numbers; its words are in `verdict.md.j2`."""

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any

from softsample.arrays import root_mean_square
from softsample.loop.effects import library
from softsample.report.loop import held_out_percent
from softsample.report.template import render
from softsample.wording import (
    NO_ERROR,
    distrusted,
    fitted,
    significant,
    verdict_words,
)

WORTH_A_NAME = 0.05
"""Weight of a model in the modulus to quote from which on the page names it."""

RELAXING = ("viscoelastic_relaxation", "poroelastic_drainage")
"""Effects beside which the modulus is that of a sudden load."""

SHORTEST, AT_END = "tau1_s", 1e-3
"""The shortest time of relaxation, and by what part it may lie from an end at which it is."""

LEAST_TERM = 0.005
"""Part of the modulus below which a term is none."""

NO_BETTER = 0.8
"""Part of the error without effects from which on what is held out is not predicted."""

HALF = 50.0
"""Error [% of peak] from which on it is not, whatever it was without effects."""

FAR = 3.0
"""Multiple of the stated floor up to which it is predicted all the same; of the stated scale up to
which tests differ no more than usual."""

BEST = 5
"""Effects of each round of the selection that the page names."""

MOST_DECIMALS = 4
"""Of evidence beside a threshold, which are told apart."""


def page(template: str | os.PathLike[str], group: str, verdict: Mapping[str, Any]) -> str:
    """Markdown page of a `verdict.json`.

    Parameters
    ----------
    template : path
        `verdict.md.j2`, which has the parts of the verdict and what is added here by name.
    verdict : mapping
        Report of a diagnosis, see `softsample.loop.verdict.report`.
    """
    quoted, size_of = verdict["recommended"], verdict["detection_limits"]
    models = [one for one in quoted["models"] if one["weight"] >= WORTH_A_NAME]
    in_models = {name for one in models for name in one["effects"]}
    counted = in_models.union(effect["name"] for effect in verdict["effects"])
    explained = {name for effect in verdict["effects"] for name in effect["class"]}
    explained |= {effect["name"] for effect in verdict["withheld"]}
    limits = sorted(size_of, key=lambda name: -abs(size_of[name]["modulus_percent"]))
    added = {
        "group": group,
        "title": verdict_words(verdict["verdict"]),
        "distrusted": distrusted(verdict),
        "as_expected": round(verdict["birge_ratio"]["after"], 2) == 1.0,
        "models": models,
        "all_models": round(sum(one["weight"] for one in models), 2) == 1.0,
        "possible": sorted(in_models - explained - {*_corrects(verdict)}),
        "relaxing": [name for name in RELAXING if name in in_models],
        "fastest": _is_faster(verdict),
        "relaxed": quoted.get("mu_relaxed"),
        "one_term": _has_one_term(verdict),
        "predicted": _predicted(verdict),
        "scale_percent": _scale(verdict),
        "unseen": next((name for name in limits if name not in counted), None),
        "library": library(),
        "no_error": NO_ERROR,
        "not_reported": list(_not_reported(verdict)),
        "rule": verdict.get("rule"),
        "worse": list(_worse(verdict)),
        "rounds": list(_rounds(verdict)),
        "limits": limits,
    }
    parts, code = {**verdict, **added}, "`{}`".format
    return _unwrapped(render(template, parts, significant=significant, fitted=fitted, code=code))


def _unwrapped(text: str) -> str:
    """Markdown with each paragraph on one line, and no more than one empty line between two.

    A line goes on with the next unless that is a row of a table or begins an entry of a list;
    no space comes before a mark.
    """
    text = re.sub(r"\n{2,}", "\n\n", text.strip())
    text = re.sub(r"(?<!\n)\n(?=[.,;)])", "", text)
    return re.sub(r"(?<!\n)\n(?!\n|\||\d+\. )", " ", text) + "\n"


def _predicted(verdict: Mapping[str, Any]) -> dict[str, Any] | None:
    """How well a verdict predicts what the study holds out, and what it does not.

    Parts that are left out in turn have diagnoses of their own, whatever the verdict on all is.
    """
    before, after = (held_out_percent(verdict, when) for when in ("before", "after"))
    if not verdict.get("rule") or not before:
        return None
    least = FAR * verdict["floor"]["floor_percent"]
    return {
        "before": root_mean_square([*before.values()]) if before != after else None,
        "after": root_mean_square([*after.values()]),
        "failed": [
            name
            for name, was in before.items()
            if after[name] > max(min(NO_BETTER * was, HALF), least)
        ],
    }


def _is_faster(verdict: Mapping[str, Any]) -> bool:
    """Whether relaxation has the shortest time of its range: its interval goes up from there."""
    times = (
        size
        for effect in verdict["effects"]
        for name, size in effect["parameters"].items()
        if name == SHORTEST
    )
    return any(time["value"] <= (1.0 + AT_END) * time["low"] < time["high"] for time in times)


def _has_one_term(verdict: Mapping[str, Any]) -> bool:
    """Whether one term of the study's law takes all of the modulus."""
    fraction = verdict["theta_after"]["mu1_fraction"]["value"]
    laws = (library()[effect["name"]].is_law for effect in verdict["effects"])
    return min(fraction, 1.0 - fraction) < LEAST_TERM and not any(laws)


def _scale(verdict: Mapping[str, Any]) -> float | None:
    """By how much tests differ in scale, if that is far more than usual beside effects."""
    if verdict["verdict"] != "explained":
        return None
    found = verdict["discrepancy_percent"]["after"].get("scale", 0.0)
    return found if found > FAR * verdict["floor"]["scale_percent"] else None


def _corrects(verdict: Mapping[str, Any]) -> Sequence[str]:
    """Effects of the correction, if there is one."""
    return verdict["correction"]["with"] if verdict["correction"] else ()


def _worse(verdict: Mapping[str, Any]) -> Iterator[str]:
    """Folds that are predicted worse with the effects that are named."""
    for fold, tests in verdict["folds_before"].items() if verdict["effects"] else ():
        errors = [(was["rms_N"], verdict["folds_after"][fold][test]["rms_N"])
                  for test, was in tests.items()]  # fmt: skip
        before, after = map(root_mean_square, zip(*errors, strict=True))
        if after > before:
            yield fold


def _not_reported(verdict: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """What was selected and is not given, what was refused together at once.

    Errors are with all effects up to there. What corrects the model is told with the correction.
    """
    given: list[str] = []
    for (reason, would), together in groupby(
        verdict["withheld"], key=lambda effect: (effect["reason"], effect["held_out_if_given"])
    ):
        effects = list(together)
        given = [*given, *(effect["name"] for effect in effects)]
        errors = [test["rms_percent"] for tests in would.values() for test in tests.values()]
        if shown := [effect for effect in effects if effect["name"] not in _corrects(verdict)]:
            yield {
                "effects": shown,
                "reason": reason,
                "given": given,
                "left_percent": root_mean_square(errors) if errors else None,
            }


def _rounds(verdict: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Every round of the selection: the largest evidence, the choice and what was refused."""
    found = [effect["name"] for effect in verdict["effects"]]
    for step in verdict["path"]:
        best, threshold = step["candidates"][:BEST], step["threshold"]
        told = [_apart(one["evidence"], threshold) for one in best]
        evidence, shown = _apart(step["evidence"], threshold) if step["chosen"] else (None, "")
        yield {
            **step,
            "threshold": max((f"{threshold:.0f}", *(one for _, one in told), shown), key=len),
            "candidates": [f"`{c['name']}` {e}" for c, (e, _) in zip(best, told, strict=True)],
            "evidence": evidence,
            "kept": step["chosen"] in found,
        }


def _apart(evidence: float, threshold: float) -> tuple[str, str]:
    """Evidence and threshold with the digits that tell on which side of the other each is."""
    for digits in range(MOST_DECIMALS):
        told, shown = (f"{number:.{digits}f}" for number in (evidence, threshold))
        if told != shown:
            return told, shown
    whole = f"{threshold:.0f}"
    return f"just below {whole}" if evidence < threshold else whole, whole
