"""The one gate: whether the effects that were selected hold as an explanation, anywhere."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from softsample.loop.choose import EARNED, WITHIN_DOUBT
from softsample.loop.errors import Error, Errors, cross_validated, log_densities
from softsample.loop.noise import NoiseSettings
from softsample.loop.rounds import SelectionSettings
from softsample.loop.select import Selection
from softsample.loop.usable import unusable


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
    form, form_of_phase : float
        Error of the form of the records, whatever their scale, and the largest of that and of a
        phase in which the platen moves [% of peak].
    repeats : float
        Difference in scale of tests of one piece [%].
    """

    fitted: Errors
    folds: Errors
    held_out: Mapping[str, Error]
    form: float
    form_of_phase: float
    repeats: float

    @property
    def total(self) -> float:
        """Error of what is fitted, with that of scale and without noise [% of peak]."""
        squares = [(of["all"].structured / of["all"].peak) ** 2 for of in self.fitted.values()]
        return float(100.0 * np.sqrt(np.mean(squares)))


def fold_ratio(before: Errors, after: Errors) -> float:
    """Cross-validated error with effects over that without: the geometric mean over folds.

    One fold whose rest tells nothing of what it leaves out does not decide alone.
    """
    logs = []
    for name, tests in before.items():
        squares = [
            sum((e.structured / e.peak) ** 2 for e in of.values()) for of in (after[name], tests)
        ]
        if min(squares) > 0.0:
            logs.append(0.5 * np.log(squares[0] / squares[1]))
    return float(np.exp(np.mean(logs))) if logs else 1.0


def objection_to(
    selection: Selection,
    before: Judged,
    after: Judged,
    rules: SelectionSettings,
    noise: NoiseSettings,
) -> str:
    """Why a selection is no explanation; empty if it is one.

    The same for every study. A selection is an explanation if

    - the error that is left, also in a ramp or an unloading, is not far above the floor, or effects
      take away most of what folds leave out;
    - beside effects it is not both above the floor and most of what was there, with the error of
      scale and without;
    - the scales of the tests are as well known as the settings say; beside effects, whose evidence
      counts with free scales, they are not at the end of their range;
    - no size was driven to the end of its range, and the modulus stays known;
    - what folds leave out of the fitted records is not far less likely (`EARNED`) with the effects;
    - the rest before loading is not missed by more than the floor because of them.

    Parameters
    ----------
    selection : Selection
        Effects that were chosen, and the rounds.
    before, after : Judged
        Errors of the plain model and of the selected one.
    rules : SelectionSettings
        `unknown_ratio` and `unknown_share`.
    noise : NoiseSettings
        Floor and scale.
    """
    last, named = selection.steps[-1], bool(selection.final.model.effects)
    if last.refused and last.why != WITHIN_DOUBT and not named:
        return last.why
    scale = max(after.repeats, noise.sizes(selection.final.problem.variances)["scale"])
    enough = named and fold_ratio(before.folds, after.folds) <= rules.unknown_share
    pairs = (after.form, before.form), (after.total, before.total)
    little = named and all(left > rules.unknown_share * was for left, was in pairs)
    over, far = after.form / noise.floor_percent, after.form_of_phase / noise.floor_percent
    if (far > rules.unknown_ratio and not enough) or (over > 1.0 and little):
        left = f"an error of {after.form_of_phase:.3g} % of the peak is left"
        return f"{left} that no effect explains"
    usual = noise.largest_scale if named else rules.unknown_ratio * noise.scale_percent
    if not enough and scale > usual:
        return f"the scales of the tests differ by {scale:.3g} %, which no effect explains"
    if not named:
        return ""
    if why := unusable(selection.final):
        return why
    fits = selection.base, selection.final
    without, beside = (log_densities(fit, cross_validated(fit)).sum() for fit in fits)
    if (less := without - beside) > EARNED:
        return f"what folds leave out is exp({less:.3g}) times less likely with the effects"
    return _spoilt_rest(before.fitted, after.fitted, noise.floor_percent)


def _spoilt_rest(before: Errors, after: Errors, most: float) -> str:
    """A test whose rest before loading is missed by `most` more [% of peak] in the second.

    There the instrument alone acts, and no error of the model excuses it.
    """
    for test, phases in after.items():
        if error := phases.get("baseline"):
            was = before[test]["baseline"]
            off = 100.0 * error.structured / error.peak
            if off > 100.0 * was.structured / was.peak + most:
                return f"with the effects the rest before {test} is off by {off:.2g} % of the peak"
    return ""
