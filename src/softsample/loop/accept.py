"""The one gate: whether the effects that were selected hold as an explanation, anywhere."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from softsample.loop.errors import Error
from softsample.loop.fit import Fit
from softsample.loop.select import Selection, SelectionSettings

Errors = Mapping[str, Mapping[str, Error]]

OPEN_MODULUS = float(np.log(2.0))
"""Standard deviation of ln(mu) above which a fit leaves the modulus open: a factor of two."""


@dataclass(frozen=True)
class Judged:
    """Errors of one fit.

    Parameters
    ----------
    fitted : dict
        Error by test and phase of what is fitted.
    folds : dict
        Cross-validated error by fold and test, within what is fitted.
    held_out : dict
        Error by test of what the study holds out.
    """

    fitted: Errors
    folds: Errors
    held_out: Mapping[str, Error]


def objection_to(
    selection: Selection, before: Judged, after: Judged, rules: SelectionSettings
) -> str:
    """Why a selection is no explanation; empty if it is one.

    The same for every study: what is left is within what the discrepancy allows, no test got
    worse, no size was driven to the end of its range, the modulus stays known, and the folds of
    the fitted records are predicted no worse with the effects than without.
    """
    n = len(selection.final.white)
    left, plain = selection.final.cost, selection.base.cost
    if left / n > rules.unknown_ratio and left - n > rules.unknown_share * (plain - n):
        return f"a reduced chi-square of {left / n:.3g} is left that no effect explains"
    if selection.problem.spoiled(selection.base, selection.final):
        return "the residual of the records grows"
    if selection.unserved and left / n > rules.unserved_ratio:
        return "the records ask for more than any effect explains"
    if not selection.final.model.effects:
        return ""
    if at_end := driven_to_an_end(selection.final):
        return f"{at_end} lies at the end of its range"
    if np.sqrt(selection.final.covariance[0, 0]) > OPEN_MODULUS:
        return "the modulus is open with these effects"
    ratio = fold_ratio(before.folds, after.folds)
    if ratio > rules.fold_ratio:
        return f"cross-validated errors are {ratio:.3g} times those without the effects"
    return ""


def fold_ratio(before: Errors, after: Errors) -> float:
    """Cross-validated error with effects over that without: RMS over folds and tests."""
    squares = [
        sum((e.structured / e.peak) ** 2 for tests in found.values() for e in tests.values())
        for found in (after, before)
    ]
    return float(np.sqrt(squares[0] / squares[1])) if squares[1] > 0.0 else 1.0


def driven_to_an_end(fit: Fit) -> str:
    """A size that lies at an end of its range at which it is not absent; empty if there is none."""
    for effect, p in fit.model.parameters:
        away = abs(fit.state.values[effect.name][p.name] - p.neutral)
        name = f"{effect.name}.{p.name}"
        if p.is_size and not p.physical and name in fit.at_bound and away > 0.01 * (p.high - p.low):
            return name
    return ""
