"""The choice of one effect more among candidates, and the class that data cannot split."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from softsample.loop.effects.base import Effect
from softsample.loop.errors import cross_validated, log_densities, touched
from softsample.loop.fit import Fit
from softsample.loop.joint import nearest
from softsample.loop.rounds import Candidate, Round, SelectionSettings, fitted, without
from softsample.loop.screen import penalty
from softsample.loop.specimen import Array
from softsample.loop.usable import doubted, unusable

WITHIN_DOUBT = "errors of geometry and mesh, or in the form of other effects, may be this large"
"""Why an effect is not given that records ask for."""

FARTHER = "it changes far more of what is held out than another law that is hardly less likely"
"""Why another law is given than the one that records ask for."""

NOT_EARNED = "what folds leave out is hardly likelier with it"
"""Why an effect beside others is not given."""

EARNED = float(np.log(20.0))
"""How much likelier an effect beside others makes what folds leave out, at least: its logarithm."""

RIVAL = 0.5
"""Part of the best one's evidence from which on folds are asked whether they tell a candidate, and
below which none is chosen if the best explains nothing."""


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
    here : Round or None
        Where it was looked for.
    """

    threshold: float
    candidates: list[Candidate]
    chosen: Candidate | None
    members: list[str] = field(default_factory=list)
    refused: Candidate | None = None
    why: str = ""
    here: Round | None = None


def one_more(here: Round, effects: Sequence[Effect], again: bool = True) -> Step:
    """One effect more, if the records ask for it.

    Where the best one has found another fit that is far better without it, the round begins anew
    from there.
    """
    candidates = fitted(here, effects)
    if not candidates:
        return Step(here.threshold, [], None, here=here)
    alone = without(here, candidates[0])
    over = here.base.misfit - alone.misfit
    if over > here.settings.least_gain and again:
        return one_more(here.about(alone.problem, alone), effects, again=False)
    candidates = [replace(c, evidence=c.evidence - max(over, 0.0)) for c in candidates]
    return chosen_of(here, candidates)


def chosen_of(here: Round, candidates: Sequence[Candidate]) -> Step:
    """The choice among candidates, one of each effect, that of most evidence first."""
    acceptable = [c for c in candidates if c.evidence >= here.threshold]
    nothing = Step(here.threshold, [*candidates], None, here=here)
    if not acceptable:
        return nothing
    inside = [c for c in acceptable if not unusable(c.settled)]
    refused = None if acceptable[0] in inside else acceptable[0]
    why = unusable(refused.settled) if refused else ""
    if not inside:
        return replace(nothing, refused=refused, why=why)
    # what the model is known to leave out comes first
    best = min(inside, key=lambda candidate: not candidate.effect.idealised)
    if refused and not best.effect.idealised and best.evidence < RIVAL * refused.evidence:
        return replace(nothing, refused=refused, why=why)
    near = _nearest_law(here, best, inside) if best.effect.is_law else best
    held = _held(here, near, inside)
    if held is None:
        return replace(nothing, refused=near, why=WITHIN_DOUBT)
    if held is not best and not refused:
        refused, why = best, WITHIN_DOUBT if held is not near else FARTHER
    best = held
    if not _earned(here, best):
        return replace(nothing, refused=best, why=NOT_EARNED)
    candidates = _compared(here, candidates, best)
    members = _members(here, candidates, best)
    return Step(here.threshold, candidates, best, members, refused, why, here)


def _in_class(candidate: Candidate, best: Candidate, settings: SelectionSettings) -> bool:
    """Whether records hardly tell a candidate from the best: of as much evidence, or alike."""
    near = candidate.evidence > best.evidence - settings.class_gain
    alike = candidate.cosine > settings.class_cosine and candidate.gain > 0.7 * best.gain
    return candidate.evidence > 0.0 and (near or alike)


def class_of(here: Round, candidates: Sequence[Candidate], best: Candidate) -> list[str]:
    """The class of the best of candidates, itself first."""
    return _members(here, _compared(here, candidates, best), best)


def _members(here: Round, candidates: Sequence[Candidate], best: Candidate) -> list[str]:
    """The same of candidates that have been compared with it."""
    others = [c for c in candidates if c.name != best.name]
    members = {c.name for c in others if _in_class(c, best, here.settings)}
    least = max(here.threshold, RIVAL * best.evidence)
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


def _held(here: Round, best: Candidate, inside: Sequence[Candidate]) -> Candidate | None:
    """The best candidate or, if errors may be as large as it, the next beyond them.

    None if that has far less evidence. After a law, that is the next beyond the same errors: what
    is smooth looks like another law first.
    """
    others = [c for c in inside if c.name != best.name and c.evidence >= RIVAL * best.evidence]
    smooth = False
    for candidate in [best, *others]:
        smooth = smooth or candidate.effect.is_law
        if _beyond_doubt(here, candidate, smooth or candidate.effect.like_geometry):
            return candidate
    return None


def _beyond_doubt(here: Round, candidate: Candidate, geometry: bool) -> bool:
    """Whether a candidate is more than errors along it may be that no record shows.

    Those in the form of effects chosen before and, with `geometry`, of that, mesh and elements.
    """
    posed = candidate.settled.problem
    doubt = posed.settings.doubt(posed.variances, geometry)
    doubt = {name: least for name, least in doubt.items() if name in here.base.problem.variances}
    before = min(doubted(fit, doubt).misfit for fit in (here.base, without(here, candidate)))
    after = doubted(candidate.settled, doubt).misfit
    return before - after - penalty(candidate.effect, len(here.base.white)) >= here.threshold


def _earned(here: Round, candidate: Candidate) -> bool:
    """Whether an effect beside others makes likelier what those folds leave out that it changes."""
    if not here.base.model.effects:
        return True
    names = touched(candidate.settled, candidate.name)
    before, after = (
        log_densities(fit, cross_validated(fit, names)).sum()
        for fit in (here.base, candidate.settled)
    )
    return bool(names and after > before + EARNED)


def _nearest_law(here: Round, best: Candidate, inside: Sequence[Candidate]) -> Candidate:
    """A candidate for a law, or another of its class, see `softsample.loop.joint.nearest`."""
    laws = [c for c in _compared(here, inside, best) if c.effect.is_law]
    alike = [c for c in laws if c.fit is best.fit or _in_class(c, best, here.settings)]
    taken = nearest(here.base, [c.settled for c in alike])
    return next(c for c in inside if c.settled is taken)


def _compared(here: Round, candidates: Sequence[Candidate], best: Candidate) -> list[Candidate]:
    """Candidates with the cosine to the best one."""
    cosines = [explained_alike(here.current, c.fit, best.fit) for c in candidates]
    return [replace(c, cosine=x) for c, x in zip(candidates, cosines, strict=True)]


def explained_alike(current: Fit, one: Fit, other: Fit) -> float:
    """Cosine between two explanations of the same residual; 0 if one of them explains nothing."""
    n = len(current.white)  # what is known of sizes that `current` does not have comes after
    a, b = (current.white - explanation.white[:n] for explanation in (one, other))
    lengths = np.sqrt((a @ a) * (b @ b))
    return float(a @ b / lengths) if lengths > 0.0 else 0.0
