"""Forward selection of effects with a backward check, from several first steps."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Self

import numpy as np

from softsample.loop.choose import Step, chosen_of, class_of, one_more
from softsample.loop.discrepancy import settled
from softsample.loop.effects.base import Effect
from softsample.loop.fit import SETTLED, Fit, Problem
from softsample.loop.model import Model
from softsample.loop.rounds import Candidate, Round, SelectionSettings, restarted, settled_near
from softsample.loop.screen import (
    LEAST_SIGNATURE,
    Signature,
    family_wise,
    penalty,
    signatures,
)
from softsample.loop.usable import doubted, misfit_with_penalties, unusable


@dataclass(frozen=True)
class Selection:
    """Outcome of the selection.

    Parameters
    ----------
    library : list of Effect
        What was chosen from.
    base, final : Fit
        Plain model and model with all chosen effects, each with the sizes of the discrepancy about
        it; the latter with room for error in the form of what was chosen.
    steps : list of Step
        Every round, the last one without a choice.
    classes : dict of list of str
        Names that the data cannot tell from each chosen effect, itself first.
    weak : list of str
        Effects that were not chosen and whose nominal size these records would not show.
    strongest : dict of Signature
        Of each effect in the plain model.
    visited : list of Fit
        Every other model with effects that a search came to and that may explain something, the
        one of fewest effects first.
    beside : list of Step
        Rounds in which an effect was told from others beside those that came later.
    """

    library: list[Effect]
    base: Fit
    final: Fit
    steps: list[Step]
    classes: dict[str, list[str]]
    weak: list[str]
    strongest: dict[str, Signature]
    visited: list[Fit] = field(default_factory=list)
    beside: list[Step] = field(default_factory=list)


def select(problem: Problem, effects: Sequence[Effect], settings: SelectionSettings) -> Selection:
    """Find the effects that the records ask for.

    Parameters
    ----------
    problem : Problem
        Records of a group, model and noise.
    effects : sequence of Effect
        To choose from; those that no record can show are left out.

    Returns
    -------
    Selection
        Of the likeliest model that the searches came to, penalties included. Searches set out
        from the plain model and, if their end is likelier by more than the threshold, from
        another first step, see `first_steps`.
    """
    first = _plain_round(problem)
    library = [e for e in effects if e.identifiable]
    found = signatures(first.current, library)
    strongest = {
        e.name: max((s for s in found if s.effect is e), key=lambda s: s.strength) for e in library
    }
    threshold = family_wise(
        found, len(first.current.white), settings.null_draws, settings.seed, settings.least_gain
    )
    opening = Round.of(problem, first.current)
    opening = replace(opening, settings=settings, threshold=threshold)
    fresh = _Search(problem, library, opening, problem, first.current)
    search = fresh.completed()
    step, plain = search.steps[0], search.visited[0]
    rivals = [fresh.completed(other) for other in first_steps(step)]
    asked = [one for one in rivals if one.likeliest.left < plain.left - threshold]
    visited = [model for one in (search, *rivals) for model in one.visited]
    if asked:
        search = min([search, *asked], key=lambda one: one.likeliest.doubted)
    best = search.likeliest
    weak = [
        name for name, signature in strongest.items()
        if signature.strength < LEAST_SIGNATURE and name not in best.fit.model.names
    ]  # fmt: skip
    return Selection(
        library,
        first.base,
        best.fit if best.classes else first.base,
        search.steps,
        {**best.classes, **_alone(step, best.classes)},
        weak,
        strongest,
        _others(visited, best),
        list(best.beside.values()),
    )


def plain_model(problem: Problem) -> Fit:
    """The model without effects, with the most likely sizes of the discrepancy about it."""
    return _plain_round(problem).base


@lru_cache(maxsize=2)  # of records as they are, and with the stiffness of specimens
def _plain_round(problem: Problem) -> Round:
    """About the plain model."""
    return Round.of(problem, problem.fit_material())


@dataclass(frozen=True)
class _Visited:
    """A model that a search came to: its fit with the most likely sizes, classes, and rounds in
    which an effect was told from others beside those that came later.
    """

    fit: Fit
    classes: dict[str, list[str]]
    beside: dict[str, Step] = field(default_factory=dict)

    @cached_property
    def left(self) -> float:
        """Misfit with the penalties for all effects; infinite if it explains nothing."""
        effects = self.fit.model.effects
        if effects and unusable(self.fit):
            return np.inf
        return misfit_with_penalties(self.fit)

    @property
    def doubted(self) -> float:
        """The same with errors of geometry and mesh that no record may show."""
        return misfit_with_penalties(doubted(self.fit))


def _others(visited: Sequence[_Visited], best: _Visited) -> list[Fit]:
    """Models with other effects than the best has, the likeliest of each, that may explain it."""
    of: dict[frozenset[str], _Visited] = {}
    for model in sorted(visited, key=lambda model: model.left):
        if model.classes and np.isfinite(model.left):
            of.setdefault(frozenset(model.classes), model)
    of.pop(frozenset(best.classes), None)
    return [of[names].fit for names in sorted(of, key=len)]


def _alone(step: Step, classes: Mapping[str, list[str]]) -> dict[str, list[str]]:
    """Class of an effect that is alone in the end, in the round of the plain model.

    What it was chosen beside had told it from others, and was dropped.
    """
    found = [c for c in step.candidates if [c.name] == list(classes)]
    if not found or step.chosen is found[0] or step.here is None:
        return {}
    return {found[0].name: class_of(step.here, step.candidates, found[0])}


def first_steps(step: Step) -> list[Step]:
    """Other first steps than that of the plain model's round, from its candidates.

    To a law, if the records ask for one but for something else more: without the right law a
    history may have most of the evidence and the wrong times. To what the model is known to
    leave out: alone it may explain little that another effect does not, which is plain beside
    it. And to what was refused by itself, which may have the size of two effects, or lowers
    the misfit most: where several effects are missing, the likeliest sizes of the discrepancy
    may be so large that they hide the one that explains most.
    """
    here, chosen = step.here, step.chosen
    if here is None:
        return []
    usable = [c for c in step.candidates if not unusable(c.settled)]
    laws = [c for c in step.candidates if c.effect.is_law]
    known = [c for c in usable if c.effect.idealised]
    steps = []
    if chosen and not chosen.effect.is_law and any(c.evidence >= here.threshold for c in laws):
        steps.append(chosen_of(here, laws))
    if known and not (chosen and chosen.effect.idealised):
        steps.append(replace(step, chosen=known[0], members=[known[0].name]))
    refused = [c for c in (step.refused,) if c and unusable(c.settled)]
    most = max(usable if chosen else refused, key=lambda c: c.gain, default=None)
    if most and most.name not in step.members:
        near = most.evidence + here.settings.class_gain
        alike = [c for c in step.candidates if c.evidence < near]
        members = class_of(here, alike, most)
        steps.append(replace(step, chosen=most, members=members))
    return [one for one in steps if one.chosen]


@dataclass(frozen=True)
class _Place:
    """Where a search was: what was left there, and what it visited, so many models before."""

    left: float
    visited: list[_Visited]
    count: int


@dataclass
class _Search:
    """State of a selection: what has been chosen, and the noise with the doubt of its form.

    It sets out from `opening`, the round of the plain model, and knows where others have `been`.
    """

    problem: Problem
    library: list[Effect]
    opening: Round
    doubting: Problem
    current: Fit
    steps: list[Step] = field(default_factory=list)
    classes: dict[str, list[str]] = field(default_factory=dict)
    doubted: dict[str, bool] = field(default_factory=dict)
    visited: list[_Visited] = field(default_factory=list)
    been: dict[frozenset[str], _Place] = field(default_factory=dict)

    def completed(self, step: Step | None = None) -> Self:
        """Another search from here, that sets out from a step, or from nothing.

        It adds effects until no more are asked for, and exchanges what was a wrong choice.
        """
        other = replace(self, steps=[], classes={}, doubted={}, visited=[])
        if step is None:
            other._visit()
        else:
            other.begin(step)
        while other.forward() and other.exchange():
            pass
        if step is not None:
            other._tell_beside_others()
        return other

    def _tell_beside_others(self) -> None:
        """Evidence of the first step beside what came later, if it had too little alone."""
        first, best = self.steps[0], self.likeliest
        assert first.chosen is not None
        name, effects = first.chosen.name, {e.name: e for e in best.fit.model.effects}
        if name not in effects or first.chosen.evidence >= first.threshold:
            return
        problem = best.fit.problem
        less = settled(problem, problem.fit(best.fit.model.without(name), best.fit.state))
        gain = less.misfit - best.fit.misfit - penalty(effects[name], len(best.fit.white))
        told = replace(first.chosen, evidence=gain)
        self.steps[0] = replace(first, chosen=told)

    def begin(self, step: Step) -> None:
        """Set out from a step."""
        assert step.chosen is not None
        self.steps.append(step)
        self._take(self.doubting, step.chosen, step.members)

    def forward(self) -> bool:
        """One effect more after the other, until no more are asked for; whether it came so far.

        What makes others superfluous may be superfluous beside what comes next: a search that
        comes to where it or an earlier one was, and is no likelier, has ended as that goes on.
        """
        while not (before := self._before()):
            if len(self.current.model.effects) == self.opening.settings.most_effects:
                return True
            step = self._round(self.doubting, self.current)
            if step.chosen is None:
                self.steps.append(step)
                return True
            self.begin(step)
        self.steps.append(Step(self.opening.threshold, [], None))
        if before.visited is not self.visited:
            self.visited += before.visited[before.count :]
        return False

    def _before(self) -> _Place | None:
        """Where a search had these effects, if this one is no likelier; else it is remembered."""
        here, left = frozenset(self.current.model.names), self.visited[-1].left
        before = self.been.get(here)
        if before and left >= before.left - SETTLED:
            return before
        self.been[here] = _Place(left, self.visited, len(self.visited))
        return None

    def exchange(self) -> bool:
        """Replace the first effect for which another is better beside those that came later.

        The first choice has to explain what a second effect does as well, and can be the wrong one.
        """
        for effect in self.current.model.effects[:-1]:
            problem, others = self._doubting_others(effect.name)
            step = self._round(problem, others)
            if step.chosen is None:
                continue
            if step.chosen.name != effect.name:
                self.steps.append(step)
                del self.classes[effect.name]
                self._take(problem, step.chosen, step.members)
                return True
            self._tell(effect.name, step)
        return False

    def _tell(self, name: str, step: Step) -> None:
        """Keep those of a class that a round beside what came later does not tell from it."""
        here = frozenset(self.current.model.names)
        for model in self.visited:
            if frozenset(model.classes) == here:
                model.classes[name] = [n for n in model.classes[name] if n in step.members]
                model.beside[name] = step

    @property
    def likeliest(self) -> _Visited:
        """The likeliest of the models that it came to, of those that may explain something."""
        return min(self.visited, key=lambda model: model.left)

    def _round(self, problem: Problem, current: Fit) -> Step:
        """One effect more; another law in place of one that is there is left to an exchange."""
        left = [effect for effect in self.library if current.model.admits(effect)]
        fresh = problem is self.problem and not current.model.effects
        return one_more(self.opening if fresh else self.opening.about(problem, current), left)

    def _take(self, problem: Problem, chosen: Candidate, members: list[str]) -> None:
        """Add what was chosen, doubt its form if need be, and drop what it has made superfluous."""
        self.classes[chosen.name] = members
        self.doubted[chosen.name] = chosen.doubted
        self.doubting = self._doubting(problem, chosen.settled)
        self.current = _pruned(self.doubting, chosen.settled, self.opening.settings)
        self.classes = {name: self.classes[name] for name in self.current.model.names}
        if len(self.classes) == len(chosen.settled.model.effects):  # as it was when it was taken
            self.visited.append(_Visited(chosen.settled, dict(self.classes)))
        self._visit()

    def _visit(self) -> None:
        """Remember where the search is.

        A form that was doubted without what came later may be right beside it.
        """
        here, settings = [(self.doubting, self.current)], self.opening.settings
        if self.doubting is not self.problem and len(self.current.model.effects) > 1:
            exact = self.opening.about(self.problem, self.current)
            here.append((self.problem, restarted(exact.current, settings)))
        for problem, fit in here:
            model = settled_near(problem, self.opening.base, fit, settings.class_gain)
            self.visited.append(_Visited(model, dict(self.classes)))

    def _doubting(self, problem: Problem, fit: Fit) -> Problem:
        """With room for error in the form of the last effect, if the records show one."""
        return problem.doubting(fit) if self.doubted[fit.model.names[-1]] else problem

    def _doubting_others(self, name: str) -> tuple[Problem, Fit]:
        """All effects but one, each in the noise with the doubt of those before it."""
        problem, fit = self.problem, self.current
        model = Model()
        for effect in self.current.model.without(name).effects:
            model = model.with_effect(effect)
            fit = problem.fit(model, self.current.state)
            problem = self._doubting(problem, fit)
        return problem, problem.fit(model, fit.state)


def _pruned(problem: Problem, fit: Fit, settings: SelectionSettings) -> Fit:
    """The fit without effects that later ones have made superfluous, or no more than doubtful."""
    if len(fit.model.effects) < 2:
        return fit
    best = settled(problem, fit)
    for effect in fit.model.effects[:-1]:
        less = problem.fit(fit.model.without(effect.name), fit.state)
        alone = settled(problem, less)
        gain = alone.misfit - best.misfit
        if effect.like_geometry:
            doubt = problem.settings.doubt(best.problem.variances, geometry=True)
            gain = min(gain, doubted(alone, doubt).misfit - doubted(best, doubt).misfit)
        if gain - penalty(effect, len(fit.white)) < settings.least_gain:
            return _pruned(problem, less, settings)
    return best
