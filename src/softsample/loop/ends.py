"""Ends that a study leaves open: models of bonded and of sliding ends, of which one is reported.

Neither is more probable beforehand, and both may lack effects: each is diagnosed.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from softsample.constitutive.material import Material
from softsample.loop.candidates import candidates
from softsample.loop.diagnose import Diagnosis, diagnose
from softsample.loop.effects.base import Effect
from softsample.loop.held_out import specimens_of
from softsample.loop.pool import Others, Pooled, lower
from softsample.loop.posed import LoopSettings
from softsample.loop.specimen import Specimen
from softsample.records import Record
from softsample.response.elastic import Tables
from softsample.shapes import IdealShape


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
    others : Others, optional
        The other groups of the study, if all that was measured of them is known.
    """

    specimens: Sequence[Specimen]
    every: Sequence[Specimen]
    effects: Sequence[Effect]
    others: Others | None = None


@dataclass(frozen=True, eq=False)
class Recorded:
    """What a study recorded of a group, and of its other groups if these tell of it.

    Parameters
    ----------
    names : collection of str
        Samples of the group.
    rows, records, shapes : sequence
        Of every sample: row with defaults filled in, record, ideal shape.
    hold_out : sequence of mapping
        Selections of the study's settings.
    groups : mapping
        Samples of the other groups, by group.
    verdicts : tuple of sequences of mapping
        `verdict.json` of each of these on all of its records, and on what is not held out.
    """

    names: Collection[str]
    rows: Sequence[Mapping[str, str]]
    records: Sequence[Record]
    shapes: Sequence[IdealShape]
    hold_out: Sequence[Mapping[str, Any]]
    groups: Mapping[str, Collection[str]]
    verdicts: tuple[Sequence[Mapping[str, Any]], Sequence[Mapping[str, Any]]]

    def with_ends(
        self, slides: bool, tables: Sequence[Tables], settings: LoopSettings, solid: Material
    ) -> AssumedEnds:
        """Beside the responses of all samples, whose open ends are taken to slide or not."""
        samples = [*zip(self.rows, self.records, tables, self.shapes, strict=True)]
        whole, part = (
            [test for sample in samples for test in specimens_of(*sample, held)]
            for held in ([], self.hold_out)
        )
        heights = {r["sample"]: s.height for r, s in zip(self.rows, self.shapes, strict=True)}
        own = [test for test in part if test.name in self.names]
        effects = candidates(own, heights[own[0].name], solid)
        told = [_with_ends(verdict, slides) for verdict in self.verdicts[0]], self.verdicts[1]
        others = Others.of(self.groups, (whole, part), heights, told, settings, solid)
        return AssumedEnds(own, part, effects, others)


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
    found = [diagnose(one.specimens, settings, one.effects, one.others) for one in models]
    return likelier(found[0], found[1], elsewhere) if found[1:] else found[0]


def _with_ends(verdict: Mapping[str, Any], slides: bool) -> Mapping[str, Any]:
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
