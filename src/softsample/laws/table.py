"""The choice of a study's law: of each group, or of all together; its table."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from softsample.arrays import root_mean_square
from softsample.calibration.profile import normal_quantile
from softsample.laws.candidates import Candidate
from softsample.laws.choice import Choice, choose
from softsample.laws.group import ALL

Reports = Mapping[str, Mapping[str, Any]]

OF_THE_MODEL = ("geometry", "time", "bond", "mesh", "hourglass")
"""Terms of `tables/intervals.csv` that are no part of a law's residual model: they make moduli of
all laws wrong by the same percentage."""


def compared(candidates: Sequence[Candidate], reports: Reports) -> list[Candidate]:
    """Laws that were fitted to all of some groups."""
    return [c for c in candidates if all(c.name in report["laws"] for report in reports.values())]


def choice_of(candidates: Sequence[Candidate], reports: Reports, part: str = ALL) -> Choice:
    """Choice by the folds of some groups together, of what a part of each leaves to be seen.

    Parameters
    ----------
    reports : mapping
        Of each group that is asked (`group_report`).
    part : str
        Part of the groups; of one without it everything but what the study holds out.
    """
    laws = compared(candidates, reports)
    errors: dict[str, list[float]] = {c.name: [] for c in laws}
    for report in reports.values():
        for c in laws:
            folds = report["laws"][c.name]["folds"]
            errors[c.name] += folds.get(part, folds[ALL]).values()
    simpler = {
        c.name: set.intersection(*(set(r["laws"][c.name]["simpler"]) for r in reports.values()))
        for c in laws
    }
    return choose(laws, errors, simpler)


def choices(
    candidates: Sequence[Candidate], reports: Reports, pool: bool
) -> dict[str, dict[str, Any]]:
    """By group: the choice, and the held-out error of what the same choice without it predicts.

    Parameters
    ----------
    reports : mapping
        `group_report` by group.
    pool : bool
        Whether all groups choose together.

    Returns
    -------
    dict
        By group: `recommended` and `equal` laws, or `refused`; `by` whose folds, their number;
        `log_likelihood`, `behind`, `standard_error` by law; `held_out` and
        `by_other_groups`; `best`, the laws that are drawn.
    """
    found = {}
    for group, report in reports.items():
        asked = reports if pool else {group: report}
        choice = choice_of(candidates, asked)
        found[group] = {
            "recommended": choice.recommended,
            "equal": list(choice.equal),
            "refused": choice.refused,
            "by": "folds of all groups" if pool and len(reports) > 1 else "its own folds",
            "folds": choice.folds,
            "log_likelihood": choice.score,
            "behind": choice.behind,
            "standard_error": choice.standard_error,
            "held_out": _nested(partial(choice_of, candidates, asked), report),
            "by_other_groups": _by_others(candidates, reports, group),
        }
    return {g: {**c, "best": best_laws(g, reports, found)} for g, c in found.items()}


def _nested(chosen: Callable[[str], Choice], report: Mapping[str, Any]) -> dict[str, Any]:
    """By part that leaves something out: the law chosen without that, and its error on it."""
    laws, found = report["laws"], {}
    for part, error in next(iter(laws.values()))["held_out"].items():
        if error is not None:
            name = chosen(part).recommended
            left = laws[name]["held_out"][part] if name else None
            found[part] = {"law": name, "error_percent": None if left is None else 100.0 * left}
    return found


def _by_others(
    candidates: Sequence[Candidate], reports: Reports, group: str
) -> dict[str, dict[str, Any]]:
    """The same if the other groups alone choose."""
    others = {name: report for name, report in reports.items() if name != group}
    if not others:
        return {}
    choice = choice_of(compared(candidates, {group: reports[group]}), others)
    return _nested(lambda part: choice, reports[group])


def model_errors(intervals: pd.DataFrame, geometries: Mapping[str, str]) -> dict[str, float]:
    """Standard deviation of ln(mu) by group: what mesh, geometry, bond and contact leave open.

    Parameters
    ----------
    intervals : DataFrame
        `tables/intervals.csv`.
    geometries : mapping of str
        Geometry of each group on which laws are fitted.
    """
    of_mu = intervals[(intervals["modulus"] == "mu") & (intervals["model"] == "ogden2")]
    rows = of_mu.set_index(["group", "geometry"])[[f"{term}_percent" for term in OF_THE_MODEL]]
    total = 0.01 * np.sqrt((rows**2).sum(axis=1))
    return {group: float(total[group, geometry]) for group, geometry in geometries.items()}


def law_table(
    candidates: Sequence[Candidate],
    reports: Reports,
    chosen: Reports,
    errors: Mapping[str, float],
    confidence: float,
) -> pd.DataFrame:
    """One row a group and law, the best predicted first.

    Parameters
    ----------
    reports : mapping
        `group_report` by group.
    chosen : mapping
        `choices`.
    errors : mapping of float
        `model_errors` by group, in the intervals of the modulus beside the profile's.
    confidence : float
        Of all intervals.

    Returns
    -------
    DataFrame
        `group`, `law`, `chosen` (`recommended`, `as good`, `no`, or empty where refused), `by`,
        `parameters`, `mu_pa`, `mu_low_pa`, `mu_high_pa`, `shape` (values with intervals),
        `error_fitted_percent`, `error_folds_percent`, `error_held_out_percent`,
        `behind` and `standard_error` (log likelihood per point), `remark`.
    """
    rows: list[dict[str, Any]] = []
    for group, report in reports.items():
        choice, half = chosen[group], normal_quantile(confidence) * errors[group]
        known = [c for c in candidates if c.name in report["laws"]]
        for candidate in sorted(known, key=lambda c: -choice["log_likelihood"].get(c.name, -99.0)):
            rows.append(_row(group, candidate, report, choice, half))
        for name, reason in report["skipped"].items():
            rows.append({"group": group, "law": name, "remark": f"not fitted: {reason}"})
    return pd.DataFrame(rows)


def _row(
    group: str,
    candidate: Candidate,
    report: Mapping[str, Any],
    choice: Mapping[str, Any],
    half: float,
) -> dict[str, Any]:
    name, law = candidate.name, report["laws"][candidate.name]
    folds = list(law["folds"][ALL].values())
    held_out = [error for error in law["held_out"].values() if error is not None]
    mu = law["intervals"].get("mu", {"low": None, "high": None})
    return {
        "group": group,
        "law": name,
        "chosen": _standing(name, choice),
        "by": choice["by"],
        "parameters": candidate.size,
        "mu_pa": law["mu_pa"],
        "mu_low_pa": _further(law["mu_pa"], mu["low"], half),
        "mu_high_pa": _further(law["mu_pa"], mu["high"], half),
        "shape": "; ".join(
            f"{shape} = {value:.3g} ({_end(law, shape, 'low')} to {_end(law, shape, 'high')})"
            for shape, value in law["shape"].items()
        ),
        "error_fitted_percent": law["error_fitted_percent"],
        "error_folds_percent": 100.0 * root_mean_square(folds),
        "error_held_out_percent": 100.0 * root_mean_square(held_out),
        "behind": choice["behind"].get(name),
        "standard_error": choice["standard_error"].get(name),
        "remark": "; ".join(remarks(law, choice, report["reached"])),
    }


def _further(centre: float, end: float | None, half: float) -> float | None:
    """End of an interval with an independent error more, of ln(mu) within `half`."""
    if end is None:
        return None
    own = np.log(end / centre)
    return float(centre * np.exp(np.copysign(np.hypot(own, half), own)))


def _standing(name: str, choice: Mapping[str, Any]) -> str:
    if choice["refused"]:
        return ""
    if name == choice["recommended"]:
        return "recommended"
    return "as good" if name in choice["equal"] else "no"


def _end(law: Mapping[str, Any], name: str, end: str) -> str:
    value = law["intervals"].get(name, {}).get(end)
    return "open" if value is None else f"{value:.3g}"


def remarks(
    law: Mapping[str, Any], choice: Mapping[str, Any], reached: Mapping[str, float]
) -> list[str]:
    """What a reader of a fit has to know, in words."""
    found = [f"these data leave {' and '.join(law['open'])} open"] if law["open"] else []
    found += [f"these data drive {bound}" for bound in law["at_bound"]]
    found += [
        f"{sample} is fitted to {100.0 * part:.0f} % of its loading, as far as its runs go"
        for sample, part in reached.items()
    ]
    return [*found, choice["refused"]] if choice["refused"] else found


def best_laws(group: str, reports: Reports, chosen: Reports) -> list[str]:
    """The three laws of a group that predict best, the recommended one first."""
    choice, laws = chosen[group], reports[group]["laws"]
    score = {name: choice["log_likelihood"].get(name, -99.0) for name in laws}
    if choice["refused"]:
        score = {name: -law["error_fitted_percent"] for name, law in laws.items()}
    first = [name for name in (choice["recommended"],) if name in laws]
    rest = sorted((name for name in laws if name not in first), key=lambda name: -score[name])
    return [*first, *rest][:3]
