"""The one gate: whether the effects that were selected hold as an explanation, anywhere."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from softsample.loop.errors import Error
from softsample.loop.noise import NoiseSettings
from softsample.loop.select import Selection, SelectionSettings, driven_to_an_end

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
    density : float
        Logarithm of the predictive density of what the folds leave out, summed over them.
    """

    fitted: Errors
    folds: Errors
    held_out: Mapping[str, Error]
    density: float


def left_over(errors: Errors) -> float:
    """Root mean square of the errors of all tests but the cell's noise [% of peak]."""
    parts = [tests["all"].structured / tests["all"].peak for tests in errors.values()]
    return float(100.0 * np.sqrt(np.mean(np.square(parts))))


def objection_to(
    selection: Selection,
    before: Judged,
    after: Judged,
    rules: SelectionSettings,
    noise: NoiseSettings,
) -> str:
    """Why a selection is no explanation; empty if it is one.

    The same for every study: what is left is not far above the floor, no size was driven to the
    end of its range, the modulus stays known, and what folds leave out of the fitted records is no
    less likely with the effects than without.
    """
    refused, named = selection.steps[-1].refused, bool(selection.final.model.effects)
    if refused and not named:
        return f"{driven_to_an_end(refused.settled)} lies at the end of its range"
    left = left_over(after.fitted)
    if left > rules.unknown_ratio * noise.floor_percent:
        return f"an error of {left:.3g} % of the peak is left that no effect explains"
    if not named:
        return ""
    if at_end := driven_to_an_end(selection.final):
        return f"{at_end} lies at the end of its range"
    if np.sqrt(selection.final.covariance[0, 0]) > OPEN_MODULUS:
        return "the modulus is open with these effects"
    if after.density < before.density:
        less = before.density - after.density
        return f"what folds leave out is exp({less:.3g}) times less likely with the effects"
    return ""
