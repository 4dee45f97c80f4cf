"""Verdicts of all groups as tables."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from softsample.arrays import root_mean_square
from softsample.loop.verdict import HELD_OUT

Verdicts = Mapping[tuple[str, str], Mapping[str, Any]]


def verdict_table(verdicts: Verdicts) -> pd.DataFrame:
    """One row a group and geometry: what was found, the modulus and the error before and after.

    Parameters
    ----------
    verdicts : mapping
        `softsample.loop.verdict.report` by group and geometry of the model.

    Returns
    -------
    DataFrame
        `group`, `geometry`, `verdict`, `effects`, `classes` (members that the records cannot tell
        apart joined by ``|``, effects by ``; ``), `evidence`; `mu_before_pa`, `mu_after_pa`, 90 %
        interval; `error_before_percent`, `error_after_percent`: root mean square over the tests of
        the structured error [% of peak]; `held_out_before_percent`, `held_out_after_percent`: its
        median over folds and tests, `held_out_worst_before_percent` and `..._after_percent` the
        largest, missing where there are no folds.
    """
    rows = []
    for (group, geometry), verdict in verdicts.items():
        effects, after = verdict["effects"], verdict["theta_after"]["mu"]
        rows.append(
            {
                "group": group,
                "geometry": geometry,
                "verdict": verdict["verdict"],
                "effects": "; ".join(effect["name"] for effect in effects),
                "classes": "; ".join("|".join(effect["class"]) for effect in effects),
                "evidence": "; ".join(f"{effect['evidence']:.0f}" for effect in effects),
                "mu_before_pa": verdict["theta_before"]["mu"]["value"],
                "mu_after_pa": after["value"],
                "mu_after_low_pa": after["low"],
                "mu_after_high_pa": after["high"],
                **{f"error_{when}_percent": _whole(verdict, when) for when in ("before", "after")},
                **{
                    f"held_out_{name}{when}_percent": _held_out(verdict, when, of)
                    for name, of in (("", np.median), ("worst_", np.max))
                    for when in ("before", "after")
                },
            }
        )
    return pd.DataFrame(rows)


def _whole(verdict: Mapping[str, Any], when: str) -> float:
    parts = [test["all"]["rms_percent_structured"] for test in verdict[f"error_{when}"].values()]
    return root_mean_square(parts)


def _held_out(verdict: Mapping[str, Any], when: str, of: Callable[[list[float]], Any]) -> float:
    folds = verdict[f"held_out_{when}"].values()
    parts = [test["rms_percent_structured"] for fold in folds for test in fold.values()]
    return float(of(parts)) if parts else float("nan")


def held_out_percent(verdict: Mapping[str, Any], when: str) -> dict[str, float]:
    """Error [% of peak] of each test that the study holds or leaves out, not of other folds."""
    found = {}
    for fold, tests in (verdict[f"held_out_{when}"] or {}).items():
        for test, error in tests.items():
            if fold == HELD_OUT:
                found[test] = error["rms_percent"]
            elif fold.startswith("leave_out_"):
                found[fold if len(tests) == 1 else f"{test} of {fold}"] = error["rms_percent"]
    return found


def error_table(verdicts: Verdicts) -> pd.DataFrame:
    """One row a group, geometry, test and part of the record: error before and after.

    Returns
    -------
    DataFrame
        `group`, `geometry`, `kind` (`fitted` or `held out`), `part` (phase or what was left out),
        `test`, then `rms_N`, `rms_percent`, the same `_structured`, each `_before` and `_after`.
    """
    return pd.DataFrame(
        [
            {"group": group, "geometry": geometry, "kind": kind, "part": part, "test": test}
            | {f"{name}_before": value for name, value in before.items()}
            | {f"{name}_after": value for name, value in after.items()}
            for (group, geometry), verdict in verdicts.items()
            for kind, part, test, before, after in _errors(verdict)
        ]
    )


def _errors(verdict: Mapping[str, Any]) -> Iterator[tuple[Any, ...]]:
    """Kind, part and test of each error of a verdict, and the error before and after."""
    for test, phases in verdict["error_before"].items():
        for phase, before in phases.items():
            yield "fitted", phase, test, before, verdict["error_after"][test][phase]
    for fold, tests in verdict["held_out_before"].items():
        for test, before in tests.items():
            yield "held out", fold, test, before, verdict["held_out_after"][fold][test]
