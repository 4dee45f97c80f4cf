"""Each part of a group left out in turn: how well a diagnosis of the others predicts it."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

from softsample.loop.ends import AssumedEnds, diagnose_ends
from softsample.loop.errors import Error, Errors, held_out_errors, white_of
from softsample.loop.posed import LoopSettings
from softsample.loop.specimen import Specimen


def left_out_errors(
    models: Sequence[AssumedEnds],
    folds: Mapping[str, Collection[str]],
    settings: LoopSettings,
    elsewhere: float = 0.0,
    progress: Callable[[str, float], None] | None = None,
) -> tuple[Errors, Errors]:
    """Errors of what is left out, by fold and test, without and with effects.

    Effects and open ends are selected anew on the rest of each fold, so that nothing of what is
    left out is known. What the study holds out of a test is no part of its error.

    Parameters
    ----------
    models : sequence of AssumedEnds
        As of `softsample.loop.ends.diagnose_ends`; every test counts.
    folds : mapping
        Names of the samples that are left out, by the name of the fold.
    settings, elsewhere
        As of `softsample.loop.ends.diagnose_ends`.
    progress : callable, optional
        Told the fold and the finished part.
    """
    before: dict[str, dict[str, Error]] = {}
    after: dict[str, dict[str, Error]] = {}
    for done, (name, samples) in enumerate(folds.items()):
        if progress is not None:
            progress(name, done / len(folds))
        rest = [replace(one, specimens=_without(one.every, samples), told=None) for one in models]
        if all(s.held_out.all() for s in rest[0].specimens):
            continue
        found = diagnose_ends(rest, settings, elsewhere)
        posed, origin = found.posed, found.origin
        white = white_of(posed.problem, posed.noises)
        plain, alike = (
            [s.with_own(contact=posed.contact, **own) for s in _only(models[k].every, samples)]
            for k, own in ((0, {}), (found.slides, {"stiffness": posed.stiffness}))
        )
        before[name] = held_out_errors(origin.posed.first, plain, white, origin.scales_before)
        after[name] = held_out_errors(found.predicting, alike, white, found.scales)
    return before, after


def _without(specimens: Sequence[Specimen], samples: Collection[str]) -> list[Specimen]:
    """Tests of which those of some samples are held out."""
    return [replace(s, held_out=s.held_out | (s.name in samples)) for s in specimens]


def _only(specimens: Sequence[Specimen], samples: Collection[str]) -> list[Specimen]:
    """Tests of which all else is, but for what the study holds out of these."""
    return [replace(s, held_out=~s.held_out & (s.name in samples)) for s in specimens]
