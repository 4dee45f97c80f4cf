"""What is left out in turn of tests, and how well a law predicts it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from softsample.arrays import Mask
from softsample.laws.candidates import Candidate
from softsample.laws.discrepancy import Discrepancy
from softsample.laws.fit import MOST_STARTS, LawFit, Problem
from softsample.laws.test import LawTest
from softsample.response.floor import rectangular

LAST_PART = 0.75
"""Part of the displacement from which on the last part of a loading is left out."""

LEAST_ERROR = 0.003
"""Error, as a part of the peak, below which laws are equally good: that of the responses."""


@dataclass(frozen=True, eq=False)
class Fold:
    """What is left out together.

    Parameters
    ----------
    name, kind : str
        Such as `leave_out_shear`; `mode`, `specimen` or `last_part`.
    left_out : sequence of (n,) bool
        Points of each test.
    """

    name: str
    kind: str
    left_out: Sequence[Mask]


def inner_folds(tests: Sequence[LawTest], kept: Sequence[Mask]) -> list[Fold]:
    """Each mode, each specimen if there are more than samples of one, the last part of all.

    Parameters
    ----------
    kept : sequence of (n,) bool
        Points that the choice may see.
    """
    seen = [k for k, mask in enumerate(kept) if mask.any()]
    found: list[Fold] = []
    for kind in ("mode", "specimen"):
        values = dict.fromkeys(getattr(tests[k], kind) for k in seen)
        samples = {tuple(k for k in seen if getattr(tests[k], kind) == v): v for v in values}
        if len(samples) < 2 or any(set(s) in _parts(found) for s in samples):
            continue
        for chosen, value in samples.items():
            masks = [m if k in chosen else np.zeros_like(m) for k, m in enumerate(kept)]
            found.append(Fold(f"leave_out_{value}", kind, masks))
    late = [
        mask & (test.displacement > LAST_PART * np.max(test.displacement, initial=0.0, where=mask))
        for test, mask in zip(tests, kept, strict=True)
    ]
    return [*found, Fold("last_part", "last_part", late)]


def _parts(found: Sequence[Fold]) -> list[set[int]]:
    """Tests that each fold leaves out: specimens of one mode each are no other folds."""
    return [{k for k, mask in enumerate(fold.left_out) if mask.any()} for fold in found]


def error_on(
    fit: LawFit, tests: Sequence[LawTest], left_out: Sequence[Mask], beyond_scale: bool = False
) -> float:
    """Root mean square error on what was left out over the peak of that, over all tests of it.

    Parameters
    ----------
    fit, tests
        A law, and what it predicts.
    left_out : sequence of (n,) bool
        Points of each test.
    beyond_scale : bool
        Whether an error of scale within the limits of `LawTest.scale_error` is no error of the law.
    """
    squares = []
    for test, mask in zip(tests, left_out, strict=True):
        if mask.any():
            force = fit.force(test)[mask]
            gap = test.force[mask] - force
            if beyond_scale:
                limit = test.scale_error / rectangular(1.0)
                scale = float(force @ gap) / max(float(force @ force), 1e-300)
                gap = gap - np.clip(scale, -limit, limit) * force
            squares.append(np.mean(gap**2) / np.max(np.abs(test.force[mask])) ** 2)
    return float(np.sqrt(np.mean(squares)))


class Fits:
    """Fits of laws to parts of tests; each part is fitted once."""

    def __init__(self, tests: Sequence[LawTest]) -> None:
        self.tests = tests
        self._known: dict[tuple[str, bytes], tuple[Discrepancy, LawFit]] = {}

    def of(self, candidate: Candidate, kept: Sequence[Mask]) -> tuple[Discrepancy, LawFit]:
        """Residual model and likeliest parameters of points of the tests.

        The model is that of the least-squares fit, the first of which sets out from many starts.
        """
        key = candidate.name, np.packbits(np.concatenate(kept)).tobytes()
        if key not in self._known:
            before = [
                found.fit.shape
                for (name, _), (found, _) in self._known.items()
                if name == candidate.name
            ]
            problem = Problem(self.tests, kept)
            fit = problem.fit(candidate, before[:1], 2 if before else MOST_STARTS)
            found = Discrepancy(problem, fit)
            self._known[key] = found, found.weighted.fit(candidate, [fit.shape], 1)
        return self._known[key]

    def fold_errors(self, candidate: Candidate, kept: Sequence[Mask]) -> dict[str, float]:
        """Error on each inner fold of some points, of the fit to the rest.

        Beyond an error of scale where whole tests are left out.
        """
        found = {}
        for fold in inner_folds(self.tests, kept):
            rest = [mask & ~out for mask, out in zip(kept, fold.left_out, strict=True)]
            _, fit = self.of(candidate, rest)
            whole = fold.kind != "last_part"  # what is left of a test knows its scale
            found[fold.name] = error_on(fit, self.tests, fold.left_out, beyond_scale=whole)
        return found
