"""From the tests of one group to a verdict."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from scipy.special import expit

from softsample.loop.accept import Judged, objection_to
from softsample.loop.choose import Step
from softsample.loop.correction import Predictor, best_predictor, learned
from softsample.loop.effects import library
from softsample.loop.effects.base import Effect
from softsample.loop.errors import (
    Fold,
    cross_validated,
    errors,
    fold_errors,
    form_errors,
    held_out_errors,
    repeat_error,
    white_of,
)
from softsample.loop.fit import Fit
from softsample.loop.pool import Pooled, predicted
from softsample.loop.posed import LoopSettings, Posed
from softsample.loop.rounds import Candidate
from softsample.loop.scale import Scales, most_likely
from softsample.loop.select import Selection, select
from softsample.loop.specimen import Specimen
from softsample.loop.usable import doubted, driven_to_an_end, misfit_with_penalties


@dataclass(frozen=True)
class Diagnosis:
    """Everything that is known of one group after the loop.

    Parameters
    ----------
    posed : Posed
        Records and their noise.
    selection : Selection
        The path to the verdict.
    objection : str
        Why the selected effects do not hold as an explanation, or why nothing explains what is
        left; empty if there is no objection.
    before : Judged
        Errors of the plain model of one stiffness.
    plain : Judged
        Errors of the plain model with the stiffness of each specimen.
    selected : Judged
        Errors with the selected effects, whether or not they are given.
    refused : Judged or None
        Errors with what the records ask for next, if it is not given.
    correction : Predictor or None
        What folds bear out of what is left, if anything: a correction, not a cause.
    corrected : Judged or None
        Errors with it.
    told : Pooled or None
        What the other groups of the study have chosen, if the effects are theirs.
    slides : bool
        Whether the model is that of sliding ends, in place of the study's bonded ones.
    other_ends : Diagnosis or None
        That of the other ends, if the study leaves them open.
    elsewhere : float
        Evidence of the other groups for sliding ends.
    ends_are_told : bool
        Whether what is held out of the other groups has chosen the ends, whatever the evidence.
    """

    posed: Posed
    selection: Selection
    objection: str
    before: Judged
    plain: Judged
    selected: Judged
    refused: Judged | None = None
    correction: Predictor | None = None
    corrected: Judged | None = None
    told: Pooled | None = None
    slides: bool = False
    other_ends: "Diagnosis | None" = None
    elsewhere: float = 0.0
    ends_are_told: bool = False

    @property
    def origin(self) -> "Diagnosis":
        """The one whose plain model is the calibrated one, of bonded ends if they are open."""
        return self.other_ends if self.slides and self.other_ends else self

    @property
    def shows_sliding(self) -> bool:
        """Whether these records and those of the other groups show that open ends slide."""
        evidence = self.origin.left - self.left + self.elsewhere
        return self.slides and (bool(self.told) or evidence >= self.selection.steps[0].threshold)

    @property
    def verdict(self) -> str:
        """`explained`, `explained_class`, `none` or `unknown`."""
        if self.objection:
            return "explained_class" if self.correction else "unknown"
        named = self.selection.classes or self.posed.stiffness or self.shows_sliding
        return "explained" if named else "none"

    @property
    def after(self) -> Judged:
        """Errors of what is reported."""
        if self.corrected:
            return self.corrected
        return self.plain if self.objection else self.selected

    @property
    def final(self) -> Fit:
        """What is reported after: an explanation that does not hold is no better than none."""
        if self.correction:
            return self.correction.fit
        return self.selection.base if self.objection else self.selection.final

    @property
    def predicting(self) -> Fit:
        """What predicts best what is not measured: `final`, with a correction that holds."""
        return self.correction.whole if self.correction else self.final

    @cached_property
    def left(self) -> float:
        """Misfit of what is reported, with the penalties for effects and single specimens.

        Errors of geometry and mesh may look like other ends, so they are as large as is doubted.
        """
        found = self.selection.base if self.objection else self.selection.final
        specimens = max(0, len(self.posed.stiffness) - 1) * float(np.log(len(self.final.white)))
        return misfit_with_penalties(doubted(found)) + specimens

    @property
    def of_ends(self) -> "list[tuple[Diagnosis, float]]":
        """Diagnoses of both ends if they are open, the reported one first, with probabilities."""
        if self.other_ends is None or self.told:
            return [(self, 1.0)]
        told = self.elsewhere if self.slides else -self.elsewhere
        against = self.other_ends.left - self.left + told
        part = float(expit(0.5 * against))
        return [(self, part), (self.other_ends, 1.0 - part)]

    @property
    def rest(self) -> Mapping[str, float]:
        """By mode, the modulus at small strain that what is left asks for, over that of `final`.

        What folds bear out of it or, where they bear out nothing, what is likeliest; empty where
        what is left is no objection.
        """
        if not self.objection:
            return {}
        found = self.correction.learned if self.correction else learned(self.selection.base)
        return found.of_modulus if found else {}

    @property
    def scales_before(self) -> Scales:
        """Errors of the scale of what the model of one stiffness predicts."""
        return {} if self.posed.stiffness else most_likely(self.posed.first)

    @property
    def scales(self) -> Scales:
        """Errors of the scale of what `predicting` predicts."""
        if self.correction:
            return self.correction.scales
        return most_likely(self.final)


def diagnose(
    specimens: Sequence[Specimen],
    settings: LoopSettings,
    effects: Sequence[Effect] | None = None,
    told: Pooled | None = None,
) -> Diagnosis:
    """Find the residual, trace it to effects, add them, and measure the error before and after.

    Parameters
    ----------
    specimens : sequence of Specimen
        Tests that share their material and machine.
    settings : LoopSettings
        Noise, floor and rules of the selection.
    effects : sequence of Effect, optional
        Library to choose from; all by default.
    told : Pooled, optional
        What the other groups of the study have chosen, in place of what these records ask for.
    """
    found = library(tests=specimens).values() if effects is None else effects
    posed = Posed.of(specimens, settings)
    known = posed.open_to([*found], settings)
    selection = select(posed.problem, known, settings.selection)
    if told:
        named = {effect.name: effect for effect in known}
        selection = _told(selection, told, predicted(posed.plain, named, told.told, told.guesses))
    judged, first = partial(_judged, posed), posed.first
    models = [selection.base, selection.final] if selection.classes else [selection.base]
    rest, *more = (judged(fit, cross_validated(fit), most_likely(fit)) for fit in models)
    before = judged(first, cross_validated(first), {}) if posed.stiffness else rest
    selected, next_one, at_end = more[0] if more else rest, None, []
    if refused := selection.steps[-1].refused:
        asked = refused.settled
        next_one = judged(asked, cross_validated(asked), most_likely(asked))
        at_end = [asked] if driven_to_an_end(asked) else []
    objection = ""
    if not told:
        objection = objection_to(selection, rest, selected, settings.selection, settings.noise)
    correction = corrected = None
    if not told and (objection or selection.classes):
        tried = models[-1:]
        if objection:  # then folds choose among all models that were tried
            every = [*models, *selection.visited, *at_end]  # no cause, but it may predict
            tried = sorted(every, key=lambda fit: len(fit.model.effects))
        correction = best_predictor([(fit, cross_validated(fit)) for fit in tried], posed.spread)
    if correction:
        corrected = judged(correction.whole, correction.folds, correction.scales)
    return Diagnosis(
        posed, selection, objection, before, rest, selected, next_one, correction, corrected, told
    )  # fmt: skip


def _told(selection: Selection, told: Pooled, fit: Fit) -> Selection:
    """A selection with the effects that other groups have chosen in place of its own."""
    threshold = selection.steps[0].threshold
    chosen = [
        Candidate(name, fit, fit, evidence, evidence, False)
        for name, evidence in told.evidence.items()
    ]
    steps = [Step(threshold, [one], one, told.classes[one.name]) for one in chosen]
    every = [*selection.steps, *steps]
    return replace(selection, final=fit, classes=told.classes, steps=every)


def _judged(posed: Posed, fit: Fit, found: Mapping[str, Fold], scales: Scales) -> Judged:
    """Errors of a fit to a group's records, with those of the folds of its problem."""
    stiffness = {s.piece: s.stiffness for s in fit.problem.specimens}
    tests = [specimen.with_own(stiffness=stiffness) for specimen in posed.specimens]
    return Judged(
        errors(fit, posed.spread),
        fold_errors(fit.problem, found, posed.spread),
        held_out_errors(fit, tests, white_of(fit.problem, posed.noises), scales),
        *form_errors(fit, posed.spread),
        repeat_error(fit),
    )
