"""Ends that a study leaves open: models of bonded and of sliding ends, of which one is reported.

Neither is more probable beforehand, and both may lack effects: each is diagnosed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from softsample.loop.diagnose import Diagnosis, diagnose
from softsample.loop.effects.base import Effect
from softsample.loop.pool import Pooled, lower
from softsample.loop.posed import LoopSettings
from softsample.loop.specimen import Specimen


@dataclass(frozen=True)
class AssumedEnds:
    """Records beside the response of samples whose ends are taken to be bonded, or to slide.

    Parameters
    ----------
    specimens : sequence of Specimen
        Tests of the group.
    every : sequence of Specimen
        All tests that the diagnosis is told of.
    effects : sequence of Effect
        What may be named.
    told : Pooled, optional
        What the other groups of the study have chosen.
    """

    specimens: Sequence[Specimen]
    every: Sequence[Specimen]
    effects: Sequence[Effect]
    told: Pooled | None = None


def diagnose_ends(
    models: Sequence[AssumedEnds], settings: LoopSettings, elsewhere: float = 0.0
) -> Diagnosis:
    """Diagnosis of a group with the ends of the study; of two models, that of the likelier ends.

    Parameters
    ----------
    models : sequence of AssumedEnds
        One, or first that of bonded ends and then that of sliding ones.
    settings : LoopSettings
        Noise, floor and rules of the selection.
    elsewhere : float
        Evidence for sliding ends in the other groups of the study, which had the same platens.
    """
    found = [diagnose(one.specimens, settings, one.effects, one.told) for one in models]
    return likelier(found[0], found[1], elsewhere) if found[1:] else found[0]


def with_ends(verdict: Mapping[str, Any], slides: bool) -> Mapping[str, Any]:
    """A verdict, or what it has of the other ends if these are meant."""
    other: Mapping[str, Any] | None = verdict["other_ends"]
    return other if other and (other["ends"] == "sliding") == slides else verdict


def for_sliding(verdict: Mapping[str, Any]) -> float:
    """Evidence for sliding ends in a `verdict.json` whose study leaves them open."""
    other = verdict["other_ends"]
    return float(other["evidence"] if other["ends"] == "sliding" else -other["evidence"])


def likelier(bonded: Diagnosis, sliding: Diagnosis, elsewhere: float = 0.0) -> Diagnosis:
    """The diagnosis to report; it knows the other one.

    Where other groups have chosen the effects, they also choose the ends if the error on what is
    held out of them differs by more than a standard error. Else it is the likelihood of what is
    reported with either, penalties included, and what the other groups tell, `elsewhere`.
    """
    bonded = replace(bonded, elsewhere=elsewhere)
    sliding = replace(sliding, elsewhere=elsewhere, slides=True)
    slides = _others_choose(bonded.told, sliding.told)
    told = slides is not None
    if slides is None:
        slides = bonded.left - sliding.left + elsewhere > 0.0
    found, other = (sliding, bonded) if slides else (bonded, sliding)
    return replace(found, other_ends=other, ends_are_told=told)


def _others_choose(bonded: Pooled | None, sliding: Pooled | None) -> bool | None:
    """Whether ends slide by what is held out of the other groups; None if these cannot tell."""
    if bonded is None or sliding is None:
        return None if bonded is sliding else bonded is None
    if lower(sliding.left, bonded.left):
        return True
    return False if lower(bonded.left, sliding.left) else None
