"""Each part of a group left out in turn: how well a diagnosis of the others predicts it."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from softsample.loop.diagnose import diagnose
from softsample.loop.effects.base import Effect
from softsample.loop.errors import Error, held_out_errors
from softsample.loop.posed import LoopSettings
from softsample.loop.specimen import Specimen

Errors = dict[str, dict[str, Error]]


def left_out_errors(
    specimens: Sequence[Specimen],
    folds: Mapping[str, Collection[str]],
    settings: LoopSettings,
    effects: Sequence[Effect],
    progress: Callable[[str, float], None] | None = None,
) -> tuple[Errors, Errors]:
    """Errors of what is left out, by fold and test, without and with effects.

    The effects are selected anew on the rest of each fold, so that nothing of what is left out is
    known. What the study holds out of a test is no part of its error.

    Parameters
    ----------
    specimens : sequence of Specimen
        All tests.
    folds : mapping
        Names of the samples that are left out, by the name of the fold.
    settings, effects
        As of `softsample.loop.diagnose.diagnose`.
    progress : callable, optional
        Told the fold and the finished part.
    """
    before: Errors = {}
    after: Errors = {}
    for done, (name, samples) in enumerate(folds.items()):
        if progress is not None:
            progress(name, done / len(folds))
        rest = [replace(s, held_out=_all(s)) if s.name in samples else s for s in specimens]
        if all(s.held_out.all() for s in rest):
            continue
        found = diagnose(rest, settings, effects)
        judged = [
            replace(s, held_out=~s.held_out if s.name in samples else ~_all(s)) for s in specimens
        ]
        noise = found.noises[0].white
        alike = [specimen.of_stiffness(found.stiffness) for specimen in judged]
        before[name] = held_out_errors(found.first[1], judged, noise, found.scales_before)
        after[name] = held_out_errors(found.predicting, alike, noise, found.scales)
    return before, after


def _all(specimen: Specimen) -> np.ndarray:
    return np.ones(len(specimen.force), bool)
