"""From the tests of one group to a verdict."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from softsample.loop.accept import Judged, objection_to
from softsample.loop.correction import Confirmed, confirmed, learned
from softsample.loop.effects import library, specimen_stiffness
from softsample.loop.effects.base import Effect
from softsample.loop.errors import (
    Fold,
    cross_validated,
    errors,
    fold_errors,
    form_error,
    held_out_errors,
    log_density,
    repeat_error,
    white_of,
)
from softsample.loop.fit import Fit, Problem
from softsample.loop.noise import Noise
from softsample.loop.pool import Group, Others, Pooled, pooled
from softsample.loop.posed import LoopSettings, Posed
from softsample.loop.resample import confidence
from softsample.loop.scale import Scales, most_likely
from softsample.loop.select import (
    Candidate,
    Selection,
    Step,
    doubted,
    misfit_with_penalties,
    select,
)
from softsample.loop.specimen import Specimen

Array = NDArray[np.float64]

STIFFNESS = specimen_stiffness.EFFECT.name
"""Effect that stands for what scattered specimens differ in."""


@dataclass(frozen=True)
class Diagnosis:
    """Everything that is known of one group after the loop.

    Parameters
    ----------
    problem : Problem
        Records and their noise.
    noises : list of Noise
        One for each test.
    selection : Selection
        The path to the verdict.
    objection : str
        Why the selected effects do not hold as an explanation, or why nothing explains what is
        left; empty if there is no objection.
    stiffness : mapping of float
        Modulus of specimens over that of the group where they scatter; empty if not.
    first : tuple of Problem, Fit
        Records and plain model of one stiffness.
    before : Judged
        Errors of that.
    plain : Judged
        Errors of the plain model with the stiffness of each specimen.
    selected : Judged
        Errors with the selected effects, whether or not they are given.
    refused : Judged or None
        Errors with what the records ask for next, if it is not given.
    correction : Confirmed or None
        What folds confirm of what is left, if anything: a correction, not a cause.
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

    problem: Problem
    noises: list[Noise]
    selection: Selection
    objection: str
    stiffness: Mapping[str, float]
    first: tuple[Problem, Fit]
    before: Judged
    plain: Judged
    selected: Judged
    refused: Judged | None = None
    correction: Confirmed | None = None
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
        named = self.selection.classes or self.stiffness or self.shows_sliding
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
    def posed(self) -> Problem:
        """The records with the sizes of the discrepancy about `final`."""
        if self.correction:
            return self.correction.problem
        return self.selection.plain if self.objection else self.selection.problem

    @property
    def predicting(self) -> Fit:
        """What predicts best what is not measured: `final`, with a correction that holds."""
        return self.correction.whole if self.correction else self.final

    @cached_property
    def left(self) -> float:
        """Misfit of what is reported, with the penalties for effects and single specimens.

        Errors of geometry and mesh may look like other ends, so they are as large as is doubted.
        """
        plain = self.selection.plain, self.selection.base
        found = plain if self.objection else (self.selection.problem, self.selection.final)
        specimens = max(0, len(self.stiffness) - 1) * float(np.log(len(self.final.white)))
        return misfit_with_penalties(*doubted(*found)) + specimens

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

        What folds confirm of it or, where they confirm nothing, what is likeliest; empty where
        what is left is no objection.
        """
        if not self.objection:
            return {}
        plain = self.selection.plain, self.selection.base
        found = self.correction.learned if self.correction else learned(*plain)
        return found.of_modulus if found else {}

    @property
    def scales_before(self) -> Scales:
        """Errors of the scale of what the model of one stiffness predicts."""
        return {} if self.stiffness else most_likely(*self.first)

    @property
    def scales(self) -> Scales:
        """Errors of the scale of what `predicting` predicts."""
        if self.correction:
            return self.correction.scales
        return most_likely(self.posed, self.final)

    def confidence(self, settings: LoopSettings, draws: int) -> float | None:
        """How often the first effect's class is found again; none without effect or draws."""
        if draws == 0 or self.objection or self.told or not self.selection.classes:
            return None
        return confidence(
            self.problem, self.selection, self.selection.library, settings.selection, draws
        )


def diagnose(
    specimens: Sequence[Specimen],
    settings: LoopSettings,
    effects: Sequence[Effect] | None = None,
    others: Others | None = None,
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
    others : Others, optional
        The other groups of the study, if all that was measured of them is known.
    """
    found = library(tests=specimens).values() if effects is None else effects
    known = [effect for effect in found if effect.name not in settings.absent]
    posed = Posed.of(specimens, settings)
    problem, noises, first, stiffness = posed.problem, posed.noises, posed.first, posed.stiffness
    if stiffness:
        known = [effect for effect in known if effect.name != STIFFNESS]
    selection, told = select(problem, known, settings.selection), None
    if others:
        own = Group.of(posed, posed, known)
        told = pooled(own, others, selection.asked, settings.selection)
        selection = _told(selection, told) if told else selection
    judged = _Judge(posed.specimens, noises)
    plain, chosen = (selection.plain, selection.base), (selection.problem, selection.final)
    models = [plain, chosen] if selection.classes else [plain]
    folds = [cross_validated(*model) for model in models]
    rest, *more = (
        judged(*model, of, most_likely(*model)) for model, of in zip(models, folds, strict=True)
    )
    before = judged(*first, cross_validated(*first), {}) if stiffness else rest
    selected = more[0] if more else rest
    refused = selection.steps[-1].refused
    next_one = None
    if refused:
        asked = refused.posed, refused.settled
        next_one = judged(*asked, cross_validated(*asked), most_likely(*asked))
    objection = ""
    if not told:
        objection = objection_to(selection, rest, selected, settings.selection, settings.noise)
    correction = corrected = None
    if not told and (objection or selection.classes):
        every = [(*model, of) for model, of in zip(models, folds, strict=True)]
        if objection:  # then folds choose among all models that were tried
            every += [(*model, cross_validated(*model)) for model in selection.visited]
            every.sort(key=lambda model: len(model[1].model.effects))
        correction = confirmed(every if objection else every[-1:], judged.spread)
    if correction:
        corrected = judged(
            correction.problem, correction.whole, correction.folds, correction.scales
        )
    return Diagnosis(
        problem, noises, selection, objection, stiffness, first, before, rest, selected,
        next_one, correction, corrected, told,
    )  # fmt: skip


def _told(selection: Selection, told: Pooled) -> Selection:
    """A selection with the effects that other groups have chosen in place of its own."""
    problem, fit, threshold = told.problem, told.fit, selection.steps[0].threshold
    chosen = [
        Candidate(name, fit, problem, fit, evidence, evidence, False)
        for name, evidence in told.evidence.items()
    ]
    steps = [Step(threshold, [one], one, told.classes[one.name]) for one in chosen]
    return replace(
        selection,
        problem=problem,
        final=fit,
        classes=told.classes,
        steps=[*selection.steps, *steps],
    )


@dataclass(frozen=True)
class _Judge:
    """Errors of models of a group's tests (all of them), with the noise of the fitted ones."""

    specimens: Sequence[Specimen]
    noises: Sequence[Noise]

    @property
    def spread(self) -> list[float]:
        """Standard deviation of a block of each test [N]."""
        return [noise.block for noise in self.noises]

    def __call__(
        self, posed: Problem, fit: Fit, found: Mapping[str, Fold], scales: Scales
    ) -> Judged:
        """Errors of a fit, with those of the folds of its problem."""
        stiffness = {s.piece: s.stiffness for s in posed.specimens}
        tests = [specimen.of_stiffness(stiffness) for specimen in self.specimens]
        return Judged(
            errors(posed, fit, self.spread),
            fold_errors(posed, found, self.spread),
            held_out_errors(fit, tests, white_of(posed, self.noises), scales),
            log_density(posed, fit, found),
            form_error(posed, fit, self.spread),
            repeat_error(posed, fit),
        )
