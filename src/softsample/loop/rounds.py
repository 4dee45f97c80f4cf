"""Where one effect more is looked for, and what each is worth there."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from softsample.loop.discrepancy import ROUNDS, settled
from softsample.loop.effects.base import Effect
from softsample.loop.fit import Fit, Problem
from softsample.loop.joint import joint_fit, nearest
from softsample.loop.screen import LEAST_SIGNATURE, best_of_each, penalty, signatures
from softsample.loop.specimen import Array

NEIGHBOURS = 10
"""Blocks over which what another law changes is alike."""

PROMISING = 0.1
"""Candidates whose linear gain is below this part of the best one's, or of the threshold, are not
fitted; the discrepancy is not estimated about those whose gain in a fit is."""


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

    @property
    def effect(self) -> Effect:
        """The effect itself."""
        return self.fit.model.effects[-1]


@dataclass(frozen=True)
class Round:
    """Where one effect more is looked for.

    Parameters
    ----------
    base : Fit
        What was chosen before, with the most likely sizes of the discrepancy about it.
    current : Fit
        The same with sizes no larger than those of the settings, and forms that are right: a
        discrepancy that is large for want of an effect would hide it.
    settings : SelectionSettings
        Of the selection.
    threshold : float
        Evidence that counts.
    """

    base: Fit
    current: Fit
    settings: SelectionSettings = SelectionSettings()
    threshold: float = 0.0

    @classmethod
    def of(cls, problem: Problem, current: Fit) -> Self:
        """About a fit."""
        base = settled(problem, current, 1)
        if not current.model.effects:  # what a larger discrepancy makes of other materials
            base = settled(base.problem, base.problem.fit_material(), 1)
        sharp = base.problem.with_variances(problem.settings.sharp(base.problem.variances))
        return cls(base, sharp.fit(base.model, base.state))

    def about(self, problem: Problem, current: Fit) -> Self:
        """The same search about another fit."""
        there = self.of(problem, current)
        return replace(there, settings=self.settings, threshold=self.threshold)


def fitted(here: Round, effects: Sequence[Effect]) -> list[Candidate]:
    """Promising effects fitted jointly with the material, the one of most evidence first."""
    settings, threshold = here.settings, here.threshold
    current, n = here.current, len(here.current.white)
    found = best_of_each(signatures(current, effects), current.white)
    ranked = sorted(
        found.values(), key=lambda pair: pair[0] - penalty(pair[1].effect, n), reverse=True
    )
    least = PROMISING * max([threshold, *(gain for gain, _ in ranked)])
    smooth = _smooth_excess(current.problem.by_test(current.white[: current.problem.count]))
    promising = [s for gain, s in ranked[: settings.refits] if gain >= least]
    others = [
        s for _, s in ranked if s not in promising and s.basis.size
        and (s.effect.starts or s.effect.is_law
             or (s.effect.idealised and s.strength >= LEAST_SIGNATURE))
    ]  # fmt: skip
    fits = [joint_fit(current, signature, settings.class_gain) for signature in promising]
    candidates = [_candidate(here, fit) for fit in fits if _may_be_chosen(here, fit, fits)]
    for signature in others:
        # of others a linear gain says little; laws and relaxation gain what is smooth at most
        asked = max([threshold, *(c.evidence - settings.class_gain for c in candidates)])
        smoothing = signature.effect.is_law or signature.effect.of_time
        if not smoothing or smooth >= asked:
            fits.append(joint_fit(current, signature, settings.class_gain))
            if _may_be_chosen(here, fits[-1], fits):
                candidates.append(_candidate(here, fits[-1]))
    candidates.sort(key=lambda c: c.evidence, reverse=True)
    if candidates and current.model.effects:
        again = restarted(candidates[0].fit, settings)
        if again is not candidates[0].fit:
            candidates[0] = max(candidates[0], _candidate(here, again), key=lambda c: c.evidence)
    return candidates


def _may_be_chosen(here: Round, fit: Fit, fits: Sequence[Fit]) -> bool:
    """Whether a joint fit gains enough beside others for its discrepancy to be estimated.

    Laws, and what the model is known to leave out, set out on searches of their own.
    """
    gain, *gains = (here.current.cost - one.cost for one in (fit, *fits))
    effect, least = fit.model.effects[-1], PROMISING * max([here.threshold, *gains])
    return gain >= (min(least, here.threshold) if effect.idealised or effect.is_law else least)


def _candidate(here: Round, fit: Fit) -> Candidate:
    """What a joint fit with one effect more is worth."""
    effect, n = fit.model.effects[-1], len(here.current.white)
    problem, tie = here.current.problem, here.settings.class_gain
    exact, doubtful = (
        settled_near(posed, here.base, fit, tie, 1) for posed in (problem, problem.doubting(fit))
    )
    is_doubted = doubtful.misfit < exact.misfit
    likely = doubtful if is_doubted else exact
    evidence = here.base.misfit - likely.misfit - penalty(effect, n)
    gain = here.current.cost - fit.cost
    return Candidate(effect.name, fit, likely, gain, evidence, is_doubted)


def settled_near(problem: Problem, base: Fit, fit: Fit, tie: float, rounds: int = ROUNDS) -> Fit:
    """`settled`; a law stays where it was if it is as good there and nearer to what was before."""
    moved = settled(problem, fit, rounds)
    if not problem.unseen or not fit.model.effects or not fit.model.effects[-1].is_law:
        return moved
    unmoved = moved.problem.at(fit.model, fit.state)
    return nearest(base, [moved, unmoved] if unmoved.cost < moved.cost + tie else [moved])


def restarted(fit: Fit, settings: SelectionSettings) -> Fit:
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


def _smooth_excess(white: Sequence[Array]) -> float:
    """Sum of squares of what is alike in neighbours of white residuals, beyond that of noise."""
    excess = 0.0
    for part in white:
        groups = np.array_split(part, max(1, len(part) // NEIGHBOURS))
        excess += sum(float(g.sum()) ** 2 / max(len(g), 1) - 1.0 for g in groups)
    return excess


def without(here: Round, candidate: Candidate) -> Fit:
    """The fit without a candidate, from the material that it has found.

    What only finds a better material explains nothing.
    """
    problem = here.current.problem
    return settled(problem, problem.fit(here.current.model, candidate.settled.state), 1)
