"""Forward selection of effects with a backward check, and classes that data cannot split."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Self

import numpy as np

from softsample.loop.discrepancy import ROUNDS, settled
from softsample.loop.effects.base import Effect
from softsample.loop.errors import cross_validated, log_densities, log_density, touched
from softsample.loop.fit import Fit, Problem
from softsample.loop.joint import joint_fit, law_fit, nearest
from softsample.loop.model import FIXED, Model
from softsample.loop.screen import (
    LEAST_SIGNATURE,
    Signature,
    best_of_each,
    family_wise,
    penalty,
    signatures,
)
from softsample.loop.specimen import Array

NEIGHBOURS = 10
"""Blocks over which what another law changes is alike."""

WITHIN_DOUBT = "errors of geometry and mesh, or in the form of other effects, may be this large"
"""Why an effect is not given that records ask for."""

NOT_EARNED = "what folds leave out is hardly likelier with it"
"""Why an effect beside others is not given."""

EARNED = float(np.log(20.0))
"""How much likelier an effect beside others makes what folds leave out, at least: its logarithm."""

OPEN_MODULUS = float(np.log(2.0))
"""Standard deviation of ln(mu) above which a fit leaves the modulus open: a factor of two."""

RIVAL = 0.5
"""Part of the best one's evidence from which on folds are asked whether they tell a candidate, and
below which none is chosen if the best explains nothing."""

PROMISING = 0.1
"""Candidates whose linear gain is below this part of the best one's, or of the threshold, are not
fitted."""


@dataclass(frozen=True)
class SelectionSettings:
    """Mirrors config `loop: selection:`.

    Parameters
    ----------
    most_effects : int
        Effects in a verdict, at most.
    least_gain : float
        Fall of the sum of squares beyond the penalty that counts as evidence (delta BIC).
    null_draws, seed : int
        Simulated records without effect for the family-wise threshold.
    refits : int
        Candidates that are fitted jointly with the material in each round.
    class_gain : float
        Candidates within this much evidence of the best share its class.
    class_cosine : float
        So do those whose explanation of the residual is this parallel to the best one's.
    unknown_ratio : float
        Error that is left, over the floor or scale of the settings, above which it is unknown.
    unknown_share : float
        Part of the error, with that of scale or without, that effects leave above the floor, at
        most; far above it, of the cross-validated one too.
    """

    most_effects: int = 3
    least_gain: float = 12.0
    null_draws: int = 2000
    seed: int = 1
    refits: int = 8
    class_gain: float = 12.0
    class_cosine: float = 0.95
    unknown_ratio: float = 3.0
    unknown_share: float = 0.5


@dataclass(frozen=True)
class Candidate:
    """An effect fitted jointly with the material and what was there before.

    Parameters
    ----------
    name : str
        The effect.
    fit : Fit
        Joint fit with the sizes of the discrepancy of the round.
    settled : Fit
        The same with the most likely sizes.
    gain : float
        Fall of the sum of squares, with the sizes of the round.
    evidence : float
        Fall of twice the negative logarithm of the likelihood, each model with its own sizes of
        the discrepancy, less the penalty for the parameters.
    doubted : bool
        Whether an error in its form is likelier than none.
    cosine : float
        Between its explanation and that of the best candidate.
    """

    name: str
    fit: Fit
    settled: Fit
    gain: float
    evidence: float
    doubted: bool
    cosine: float = 1.0


@dataclass(frozen=True)
class Step:
    """One round of the selection.

    Parameters
    ----------
    threshold : float
        Evidence that counts.
    candidates : list of Candidate
        The best first.
    chosen : Candidate or None
        What was added.
    members : list of str
        Its class.
    refused : Candidate or None
        What the records ask for most, if it is not given.
    why : str
        Why it is not.
    current : Fit or None
        What candidates were fitted beside.
    """

    threshold: float
    candidates: list[Candidate]
    chosen: Candidate | None
    members: list[str] = field(default_factory=list)
    refused: Candidate | None = None
    why: str = ""
    current: Fit | None = None


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

    @property
    def asked(self) -> set[str]:
        """Effects that passed the threshold in a round."""
        return {c.name for s in self.steps for c in s.candidates if c.evidence >= s.threshold}


def select(problem: Problem, effects: Sequence[Effect], settings: SelectionSettings) -> Selection:
    """Find the effects that the records ask for.

    Parameters
    ----------
    problem : Problem
        Records of a group, model and noise.
    effects : sequence of Effect
        To choose from; those that no record can show are left out.
    settings : SelectionSettings
        Of the selection.

    Returns
    -------
    Selection
        Of the likeliest model that the searches came to, penalties included. Searches set out
        from the plain model and, if their end is likelier by more than the threshold, from
        another law, from what the model is known to leave out or from what was refused by itself.
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
    fresh = _Search(
        problem, first.current, library, settings, threshold, problem, first.current,
        _Round.of(problem, first.current),
    )  # fmt: skip
    search = fresh.completed()
    opening, plain = search.steps[0], search.visited[0]
    others = (
        fresh.law_first(opening), fresh.left_out_first(opening), fresh.another_first(opening)
    )  # fmt: skip
    rivals = [fresh.completed(step) for step in others if step is not None]
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
        best.fit,
        search.steps,
        {**best.classes, **_alone(opening, best.classes, settings)},
        weak,
        strongest,
        _others(visited, best),
        list(best.beside.values()),
    )


def plain_model(problem: Problem) -> Fit:
    """The model without effects, with the most likely sizes of the discrepancy about it."""
    return _plain_round(problem).base


@dataclass(frozen=True)
class _Round:
    """Where one effect more is looked for.

    Parameters
    ----------
    base : Fit
        What was chosen before, with the most likely sizes of the discrepancy about it.
    current : Fit
        The same with sizes no larger than those of the settings, and forms that are right: a
        discrepancy that is large for want of an effect would hide it.
    """

    base: Fit
    current: Fit

    @classmethod
    def of(cls, problem: Problem, current: Fit) -> Self:
        """About a fit."""
        base = settled(problem, current, 1)
        if not current.model.effects:  # what a larger discrepancy makes of other materials
            base = settled(base.problem, base.problem.fit_material(), 1)
        sharp = base.problem.with_variances(problem.settings.sharp(base.problem.variances))
        return cls(base, sharp.fit(base.model, base.state))


@lru_cache(maxsize=2)  # of records as they are, and with the stiffness of specimens
def _plain_round(problem: Problem) -> _Round:
    """About the plain model."""
    return _Round.of(problem, problem.fit_material())


@dataclass(frozen=True)
class _Visited:
    """A model that a search came to: its fit with the most likely sizes, and classes.

    And rounds in which an effect was told from others beside those that came later.
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


def _alone(
    opening: Step, classes: Mapping[str, list[str]], settings: SelectionSettings
) -> dict[str, list[str]]:
    """Class of an effect that is alone in the end, in the round of the plain model.

    What it was chosen beside had told it from others, and was dropped.
    """
    found = [c for c in opening.candidates if [c.name] == list(classes)]
    if not found or opening.chosen is found[0] or opening.current is None:
        return {}
    candidates = _compared(opening.current, opening.candidates, found[0])
    return {found[0].name: _members(candidates, found[0], opening.threshold, settings)}


@dataclass
class _Search:
    """State of a selection: what has been chosen, and the noise with the doubt of its form.

    It sets out from `opening`, the round of the plain model.
    """

    problem: Problem
    plain: Fit
    library: list[Effect]
    settings: SelectionSettings
    threshold: float
    doubting: Problem
    current: Fit
    opening: _Round
    steps: list[Step] = field(default_factory=list)
    classes: dict[str, list[str]] = field(default_factory=dict)
    doubted: dict[str, bool] = field(default_factory=dict)
    visited: list[_Visited] = field(default_factory=list)

    def completed(self, step: Step | None = None) -> Self:
        """Another search from here, that sets out from a step, or from nothing.

        It adds effects until no more are asked for, and exchanges what was a wrong choice.
        """
        other = replace(self, steps=[], classes={}, doubted={}, visited=[])
        if step is None:
            other._visit()
        else:
            other.begin(step)
        other.forward()
        been = {frozenset(other.current.model.names)}
        while other.exchange() and (here := frozenset(other.current.model.names)) not in been:
            been.add(here)
            other.forward()
        if step is not None:
            other._tell_beside_others()
        return other

    def _tell_beside_others(self) -> None:
        """Evidence of the first step beside what came later, if it had too little alone."""
        first, best = self.steps[0], self.likeliest
        assert first.chosen is not None
        name, effects = first.chosen.name, {e.name: e for e in best.fit.model.effects}
        if name not in effects or first.chosen.evidence >= self.threshold:
            return
        problem = best.fit.problem
        less = settled(problem, problem.fit(best.fit.model.without(name), best.fit.state))
        gain = less.misfit - best.fit.misfit - penalty(effects[name], len(best.fit.white))
        told = replace(first.chosen, evidence=gain)
        self.steps[0] = replace(first, chosen=told)

    def law_first(self, opening: Step) -> Step | None:
        """A first step to another law, if the records ask for one but for something else more.

        Without the right law a history may have most of the evidence and the wrong times.
        """
        laws = {e.name: e for e in self.library if e.is_law}
        asked = any(c.evidence >= self.threshold for c in opening.candidates if c.name in laws)
        if opening.chosen is None or opening.chosen.name in laws or not asked:
            return None
        step = _round(self.opening, list(laws.values()), self.threshold, self.settings)
        return step if step.chosen else None

    def left_out_first(self, opening: Step) -> Step | None:
        """A first step to what the model is known to leave out, unless it came first anyway.

        Alone it may explain little that another effect does not, which is plain beside it.
        """
        known = [effect for effect in self.library if effect.idealised]
        if opening.chosen and opening.chosen.name in [effect.name for effect in known]:
            return None
        found = _fitted(self.opening, known, self.threshold, self.settings)
        usable = [c for c in found if not unusable(c.settled)]
        return Step(self.threshold, usable, usable[0], [usable[0].name]) if usable else None

    def another_first(self, opening: Step) -> Step | None:
        """A first step to what was refused by itself or lowers the misfit most, if any was chosen.

        What was refused may have the size of two effects. Where several are missing, the likeliest
        sizes of the discrepancy may be so large that they hide the one that explains most.
        """
        refused = [c for c in (opening.refused,) if c and unusable(c.settled)]
        usable = [c for c in opening.candidates if not unusable(c.settled)]
        first = max(usable if opening.chosen else refused, key=lambda c: c.gain, default=None)
        if first is None or first.name in opening.members:
            return None
        near = first.evidence + self.settings.class_gain
        candidates = [c for c in opening.candidates if c.evidence < near]
        candidates = _compared(self.opening.current, candidates, first)
        members = _members(candidates, first, self.threshold, self.settings)
        return Step(self.threshold, candidates, first, members)

    def begin(self, step: Step) -> None:
        """Set out from a step."""
        assert step.chosen is not None
        self.steps.append(step)
        self._take(self.doubting, step.chosen, step.members)

    def forward(self) -> None:
        """One effect after the other, until no more are asked for.

        What makes others superfluous may be superfluous beside what comes next: a search that is
        where it was before has ended.
        """
        been = {frozenset(self.current.model.names)}
        while len(self.current.model.effects) < self.settings.most_effects:
            step = self._round(self.doubting, self.current)
            if step.chosen is None:
                self.steps.append(step)
                break
            self.begin(step)
            if (here := frozenset(self.current.model.names)) in been:
                self.steps.append(Step(self.threshold, [], None))
                break
            been.add(here)

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
        here = self.opening if current is self.plain else _Round.of(problem, current)
        return _round(here, left, self.threshold, self.settings)

    def _take(self, problem: Problem, chosen: Candidate, members: list[str]) -> None:
        """Add what was chosen, doubt its form if need be, and drop what it has made superfluous."""
        self.classes[chosen.name] = members
        self.doubted[chosen.name] = chosen.doubted
        self.doubting = self._doubting(problem, chosen.settled)
        self.current = _pruned(self.doubting, chosen.settled, self.settings)
        self.classes = {name: self.classes[name] for name in self.current.model.names}
        if len(self.classes) == len(chosen.settled.model.effects):  # as it was when it was taken
            self.visited.append(_Visited(chosen.settled, dict(self.classes)))
        self._visit()

    def _visit(self) -> None:
        """Remember where the search is.

        A form that was doubted without what came later may be right beside it.
        """
        here = [(self.doubting, self.current)]
        if self.doubting is not self.problem and len(self.current.model.effects) > 1:
            exact = _Round.of(self.problem, self.current)
            here.append((self.problem, _restarted(exact.current, self.settings)))
        for problem, fit in here:
            model = _settled(problem, self.plain, fit, self.settings.class_gain)
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


def misfit_with_penalties(fit: Fit) -> float:
    """Twice the negative logarithm of the likelihood, with the penalties for all effects."""
    return fit.misfit + sum(penalty(e, len(fit.white)) for e in fit.model.effects)


def doubted(fit: Fit, doubt: Mapping[str, float] | None = None) -> Fit:
    """A model fitted with errors of at least the sizes that are doubted.

    By default those of geometry and mesh that no record may show.
    """
    if doubt is None:
        doubt = fit.problem.settings.doubt({}, floor=True)
    return fit.problem.with_least(doubt).fit(fit.model, fit.state)


def driven_to_an_end(fit: Fit) -> str:
    """A size, exponent or period at an end of its range at which it is not absent; else empty.

    One that the records do not show, as an exponent of no modulus, may lie anywhere.
    """
    shown = np.linalg.norm(fit.jacobian[:, FIXED:], axis=0) >= LEAST_SIGNATURE
    for (effect, p), seen in zip(fit.model.parameters, shown, strict=True):
        value, name = fit.state.values[effect.name][p.name], f"{effect.name}.{p.name}"
        allowed = any(abs(value - end) < 0.01 * (p.high - p.low) for end in (p.neutral, *p.limits))
        if seen and (p.is_size or p.inside) and not allowed and name in fit.at_bound:
            return name
    return ""


def unusable(fit: Fit) -> str:
    """Why a fit explains nothing; empty if it may."""
    if at_end := driven_to_an_end(fit):
        return f"{at_end} lies at the end of its range"
    for effect in fit.model.effects:
        if effect.exceeds_the_whole(fit.state.values[effect.name]):
            return f"the parts of {effect.name} together exceed the whole"
    if np.sqrt(fit.covariance[0, 0]) > OPEN_MODULUS:
        return "the modulus is open with these effects"
    return ""


def _round(
    here: _Round,
    effects: Sequence[Effect],
    threshold: float,
    settings: SelectionSettings,
    again: bool = True,
) -> Step:
    """One effect more, if the records ask for it.

    Where the best one has found another fit that is far better without it, the round begins anew
    from there.
    """
    candidates = _fitted(here, effects, threshold, settings)
    if not candidates:
        return Step(threshold, [], None)
    alone = _without(here, candidates[0])
    over = here.base.misfit - alone.misfit
    if over > settings.least_gain and again:
        return _round(_Round.of(alone.problem, alone), effects, threshold, settings, again=False)
    candidates = [replace(c, evidence=c.evidence - max(over, 0.0)) for c in candidates]
    step = _chosen(here, candidates, threshold, settings)
    return replace(step, current=here.current)


def _chosen(
    here: _Round, candidates: Sequence[Candidate], threshold: float, settings: SelectionSettings
) -> Step:
    """The choice among candidates."""
    acceptable = [c for c in candidates if c.evidence >= threshold]
    nothing = Step(threshold, _one_of_each(candidates), None)
    if not acceptable:
        return nothing
    inside = [c for c in acceptable if not unusable(c.settled)]
    refused = None if acceptable[0] in inside else acceptable[0]
    why = unusable(refused.settled) if refused else ""
    if not inside:
        return replace(nothing, refused=refused, why=why)
    best = min(inside, key=_comes_later)
    if refused and _comes_later(best) and best.evidence < RIVAL * refused.evidence:
        return replace(nothing, refused=refused, why=why)
    if best.fit.model.effects[-1].is_law:
        best = _nearest_law(here, best, inside, settings)
    held = _held(here, best, inside, threshold)
    if held is None:
        return replace(nothing, refused=best, why=WITHIN_DOUBT)
    best = held
    if not _earned(here, best):
        return replace(nothing, refused=best, why=NOT_EARNED)
    candidates = _compared(here.current, _one_of_each([best, *candidates]), best)
    members = _members(candidates, best, threshold, settings)
    return Step(threshold, candidates, best, members, refused, why)


def _fitted(
    here: _Round, effects: Sequence[Effect], threshold: float, settings: SelectionSettings
) -> list[Candidate]:
    """Promising effects fitted jointly with the material, the one of most evidence first."""
    current, n = here.current, len(here.current.white)
    found = best_of_each(signatures(current, effects), current.white)
    ranked = sorted(
        found.values(), key=lambda pair: pair[0] - penalty(pair[1].effect, n), reverse=True
    )
    candidates: list[Candidate] = []
    least = PROMISING * max([threshold, *(gain for gain, _ in ranked)])
    smooth = _smooth_excess(current.problem.by_test(current.white[: current.problem.count]))
    promising = [s for gain, s in ranked[: settings.refits] if gain >= least]
    others = [
        s for _, s in ranked if s not in promising and s.basis.size
        and (s.effect.starts or (s.effect.idealised and s.strength >= LEAST_SIGNATURE))
    ]  # fmt: skip
    for signature in [*promising, *others]:
        # of others a linear gain says little; laws and relaxation gain what is smooth at most
        asked = max([threshold, *(c.evidence - settings.class_gain for c in candidates)])
        smoothing = signature.effect.is_law or signature.effect.of_time
        if signature in others and smoothing and smooth < asked:
            continue
        joint = joint_fit(current, signature, settings.class_gain)
        candidates.append(_candidate(here, joint, settings))
    if _loses_on_return(here.base.problem):
        laws = [effect for effect in effects if effect.is_law]
        candidates += [_beside_hysteresis(here, law, settings) for law in laws]
    candidates.sort(key=lambda c: c.evidence, reverse=True)
    if candidates and current.model.effects:
        again = _restarted(candidates[0].fit, settings)
        if again is not candidates[0].fit:
            candidates[0] = max(
                candidates[0], _candidate(here, again, settings), key=lambda c: c.evidence
            )
    return candidates


def _loses_on_return(problem: Problem) -> bool:
    """Whether fitted loading and unloading differ by more than the settings allow for."""
    unloaded = any(((s.phase == "unloading") & ~s.held_out).any() for s in problem.specimens)
    return unloaded and problem.variances.get("history", 0.0) > 1.0


def _beside_hysteresis(here: _Round, law: Effect, settings: SelectionSettings) -> Candidate:
    """A law fitted with the sizes of the discrepancy that the plain model has left.

    With smaller ones, records that go back ask for a law whose loading and unloading differ least,
    as no law explains that they do.
    """
    fit = law_fit(here.base, law, settings.class_gain)
    return _candidate(here, here.current.problem.at(fit.model, fit.state), settings)


def _candidate(here: _Round, fit: Fit, settings: SelectionSettings) -> Candidate:
    """What a joint fit with one effect more is worth."""
    effect, n = fit.model.effects[-1], len(here.current.white)
    problem, tie = here.current.problem, settings.class_gain
    exact, doubtful = (
        _settled(posed, here.base, fit, tie, 1) for posed in (problem, problem.doubting(fit))
    )
    is_doubted = doubtful.misfit < exact.misfit
    likely = doubtful if is_doubted else exact
    evidence = here.base.misfit - likely.misfit - penalty(effect, n)
    gain = here.current.cost - fit.cost
    return Candidate(effect.name, fit, likely, gain, evidence, is_doubted)


def _settled(problem: Problem, base: Fit, fit: Fit, tie: float, rounds: int = ROUNDS) -> Fit:
    """`settled`; a law stays where it was if it is as good there and nearer to what was before."""
    moved = settled(problem, fit, rounds)
    if not problem.unseen or not fit.model.effects or not fit.model.effects[-1].is_law:
        return moved
    unmoved = moved.problem.at(fit.model, fit.state)
    return nearest(base, [moved, unmoved] if unmoved.cost < moved.cost + tie else [moved])


def _restarted(fit: Fit, settings: SelectionSettings) -> Fit:
    """The fit, or a better one from new initial guesses of the earlier effects.

    What was found without the last effect may be far off beside it.
    """
    problem = fit.problem
    for effect in fit.model.effects[:-1]:
        without = problem.fit(fit.model.without(effect.name), fit.state)
        found = best_of_each(signatures(without, [effect]), without.white)
        joint = joint_fit(without, found[effect.name][1], settings.class_gain)
        again = problem.fit(fit.model, joint.state)
        fit = min(fit, again, key=lambda one: one.cost)
    return fit


def _in_class(candidate: Candidate, best: Candidate, settings: SelectionSettings) -> bool:
    """Whether records hardly tell a candidate from the best: of as much evidence, or alike."""
    near = candidate.evidence > best.evidence - settings.class_gain
    alike = candidate.cosine > settings.class_cosine and candidate.gain > 0.7 * best.gain
    return candidate.evidence > 0.0 and (near or alike)


def _members(
    candidates: Sequence[Candidate], best: Candidate, threshold: float, settings: SelectionSettings
) -> list[str]:
    """The class of the best candidate, itself first."""
    others = [c for c in candidates if c.name != best.name]
    members = {c.name for c in others if _in_class(c, best, settings)}
    least = max(threshold, RIVAL * best.evidence)
    rivals = [c for c in others if c.name not in members and c.evidence >= least]
    if rivals:
        most = _densities(best)
        members |= {c.name for c in rivals if _as_likely(_densities(c), most)}
    return [best.name, *(c.name for c in others if c.name in members)]


def _densities(candidate: Candidate) -> Array:
    """Logarithm of the predictive density of what each fold leaves out."""
    return log_densities(candidate.settled, cross_validated(candidate.settled))


def _as_likely(one: Array, most: Array) -> bool:
    """Whether what folds leave out tells one model from another by no standard error."""
    apart = most - one
    return len(apart) > 1 and bool(apart.sum() <= np.sqrt(len(apart)) * np.std(apart, ddof=1))


def _comes_later(candidate: Candidate) -> bool:
    """Whether what the model is known to leave out comes before a candidate."""
    return not candidate.fit.model.effects[-1].idealised


def _held(
    here: _Round, best: Candidate, inside: Sequence[Candidate], threshold: float
) -> Candidate | None:
    """The best candidate or, if errors may be as large as it, the next beyond them.

    None if that has far less evidence. After a law, that is the next beyond the same errors: what
    is smooth looks like another law first.
    """
    others = [c for c in inside if c.name != best.name and c.evidence >= RIVAL * best.evidence]
    smooth = False
    for candidate in [best, *others]:
        effect = candidate.fit.model.effects[-1]
        smooth = smooth or effect.is_law
        if _beyond_doubt(here, candidate, threshold, smooth or effect.like_floor):
            return candidate
    return None


def _beyond_doubt(here: _Round, candidate: Candidate, threshold: float, floor: bool) -> bool:
    """Whether a candidate is more than errors along it may be that no record shows.

    Those in the form of effects chosen before and, with `floor`, of geometry, mesh and elements.
    """
    effect, posed = candidate.fit.model.effects[-1], candidate.settled.problem
    doubt = posed.settings.doubt(posed.variances, floor)
    doubt = {name: least for name, least in doubt.items() if name in here.base.problem.variances}
    before = min(doubted(fit, doubt).misfit for fit in (here.base, _without(here, candidate)))
    after = doubted(candidate.settled, doubt).misfit
    return before - after - penalty(effect, len(here.base.white)) >= threshold


def _earned(here: _Round, candidate: Candidate) -> bool:
    """Whether an effect beside others makes likelier what those folds leave out that it changes."""
    if not here.base.model.effects:
        return True
    names = touched(candidate.settled, candidate.name)
    before, after = (
        log_density(fit, cross_validated(fit, names)) for fit in (here.base, candidate.settled)
    )
    return bool(names) and after > before + EARNED


def _smooth_excess(white: Sequence[Array]) -> float:
    """Sum of squares of what is alike in neighbours of white residuals, beyond that of noise."""
    excess = 0.0
    for part in white:
        groups = np.array_split(part, max(1, len(part) // NEIGHBOURS))
        excess += sum(float(g.sum()) ** 2 / max(len(g), 1) - 1.0 for g in groups)
    return excess


def _without(here: _Round, candidate: Candidate) -> Fit:
    """The fit without a candidate, from the material that it has found.

    What only finds a better material explains nothing.
    """
    problem = here.current.problem
    return settled(problem, problem.fit(here.current.model, candidate.settled.state), 1)


def _one_of_each(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Of several fits of one effect the first, the one of most evidence first of all."""
    first = {c.name: c for c in reversed(candidates)}
    return sorted(first.values(), key=lambda c: c.evidence, reverse=True)


def _nearest_law(
    here: _Round, best: Candidate, inside: Sequence[Candidate], settings: SelectionSettings
) -> Candidate:
    """A candidate for a law, or another of its class, see `softsample.loop.joint.nearest`."""
    laws = [c for c in _compared(here.current, inside, best) if c.fit.model.effects[-1].is_law]
    alike = [c for c in laws if c.fit is best.fit or _in_class(c, best, settings)]
    taken = nearest(here.base, [c.settled for c in alike])
    return next(c for c in inside if c.settled is taken)


def _compared(current: Fit, candidates: Sequence[Candidate], best: Candidate) -> list[Candidate]:
    """Candidates with the cosine to the best one."""
    cosines = [explained_alike(current, c.fit, best.fit) for c in candidates]
    return [replace(c, cosine=x) for c, x in zip(candidates, cosines, strict=True)]


def explained_alike(current: Fit, one: Fit, other: Fit) -> float:
    """Cosine between two explanations of the same residual; 0 if one of them explains nothing."""
    n = len(current.white)  # what is known of sizes that `current` does not have comes after
    a, b = (current.white - explanation.white[:n] for explanation in (one, other))
    lengths = np.sqrt((a @ a) * (b @ b))
    return float(a @ b / lengths) if lengths > 0.0 else 0.0


def _pruned(problem: Problem, fit: Fit, settings: SelectionSettings) -> Fit:
    """The fit without effects that later ones have made superfluous, or no more than doubtful."""
    if len(fit.model.effects) < 2:
        return fit
    best = settled(problem, fit)
    for effect in fit.model.effects[:-1]:
        less = problem.fit(fit.model.without(effect.name), fit.state)
        alone = settled(problem, less)
        gain = alone.misfit - best.misfit
        if effect.like_floor:
            doubt = problem.settings.doubt(best.problem.variances, floor=True)
            gain = min(gain, doubted(alone, doubt).misfit - doubted(best, doubt).misfit)
        if gain - penalty(effect, len(fit.white)) < settings.least_gain:
            return _pruned(problem, less, settings)
    return best
