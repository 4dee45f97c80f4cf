"""Where compression begins in each of several specimens, which need not touch at one height."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from softsample.loop.discrepancy import settled
from softsample.loop.fit import Fit
from softsample.loop.scale import RANGE, same_tests
from softsample.loop.specimen import Array, Specimen

ROUNDS = 2
"""Of fitting the group's material, with the discrepancy about it, and what is each specimen's own:
an offset shows better where the discrepancy no longer has to stand for it."""

TRIED = np.linspace(-1.0, 1.0, 41)
"""Offsets that are tried first [mm]: where contact sets in late, the sum of squares has minima."""

NEAR = 0.01
"""Step over which the curvature of the sum of squares is taken [mm]."""


def own_contact(first: Fit, usual: float, least_gain: float) -> dict[str, float]:
    """Displacement at which the compression of each specimen begins, over the mean [mm].

    Of specimens that had the same test, each with a stiffness of its own meanwhile. Empty if the
    records do not ask for it: if they are not likelier by `least_gain` over a prior of the offsets.

    Parameters
    ----------
    first : Fit
        Of a model in which all begin at one displacement.
    usual : float
        Standard deviation of the logarithm of the stiffness of specimens, at least.
    least_gain : float
        Fall of twice the negative log likelihood that counts.
    """
    tests = _comparable(first.problem.specimens)
    if not tests:
        return {}
    free = replace(first, problem=first.problem.with_open_contact())
    settings = first.problem.settings
    alike = _settled(_Settled(free, {}, usual, 0.0), tests, usual)
    wide = settings.spread * settings.contact_zero_mm
    own = _settled(_Settled(free, {}, alike.stiffness, wide), tests, usual)
    return own.offsets if alike.left - own.left > least_gain else {}


@dataclass(frozen=True)
class _Own:
    """Of one specimen: log of its stiffness, its offset [mm], and what is known of that [1/mm2]."""

    stiffness: float
    offset: float
    known: float


@dataclass(frozen=True)
class _Settled:
    """A fit with what is each specimen's own, and standard deviations of its priors.

    Of the log of its stiffness what specimens show, `usual` at least; its offset [mm] is known less
    well than where compression begins as a whole.
    """

    fit: Fit
    own: dict[str, _Own]
    stiffness: float
    offset: float

    @property
    def offsets(self) -> dict[str, float]:
        """By specimen [mm]; none if their prior has no width."""
        return {piece: one.offset for piece, one in self.own.items()} if self.offset else {}

    @property
    def left(self) -> float:
        """Twice the negative log likelihood over the priors, by Laplace's approximation.

        One stiffness and one offset are those of the mean, which is free.
        """
        width, wide = self.stiffness, self.offset
        prices = [(one.stiffness / width) ** 2 + 2.0 * np.log(width) for one in self.own.values()]
        if wide:
            prices += [
                (one.offset / wide) ** 2 + np.log1p(one.known * wide**2)
                for one in self.own.values()
            ]
        return self.fit.misfit + float(np.sum(prices)) * (len(self.own) - 1) / len(self.own)


def _comparable(specimens: Sequence[Specimen]) -> list[list[int]]:
    """Places of tests in which a platen presses on several specimens in the same way."""
    found: dict[int, list[int]] = {}
    for k, (specimen, test) in enumerate(zip(specimens, same_tests(specimens), strict=True)):
        if specimen.elastic.contact:
            found.setdefault(test, []).append(k)
    return [of for of in found.values() if len({specimens[k].piece for k in of}) > 1]


def _settled(found: _Settled, tests: Sequence[Sequence[int]], usual: float) -> _Settled:
    """Fit of the group, and what is each specimen's own, in turn."""
    for _ in range(ROUNDS):
        own = _own(found, tests)
        shown = float(np.sqrt(np.mean([one.stiffness**2 for one in own.values()])))
        found = replace(found, own=own, stiffness=max(usual, shown))
        stiffness = {piece: float(np.exp(one.stiffness)) for piece, one in found.own.items()}
        problem = found.fit.problem.with_own(stiffness=stiffness, contact=found.offsets)
        fit = settled(problem, problem.fit(found.fit.model, found.fit.state), 1)
        found = replace(found, fit=fit)
    return found


def _own(before: _Settled, tests: Sequence[Sequence[int]]) -> dict[str, _Own]:
    """What each specimen asks for, less the means over those that had the same test."""
    asked: dict[str, list[Array]] = {}
    for places in tests:
        found = np.array([_of_test(before, k) for k in places])
        found[:, :2] -= found[:, :2].mean(axis=0)
        for k, own in zip(places, found, strict=True):
            asked.setdefault(before.fit.problem.specimens[k].piece, []).append(own)
    return {piece: _Own(*np.mean(of, axis=0).tolist()) for piece, of in asked.items()}


def _of_test(before: _Settled, k: int) -> tuple[float, float, float]:
    """Log of the stiffness, offset [mm], what is known of it [1/mm2], all else as it is."""
    fit, wide, pulled = before.fit, before.offset, before.stiffness**-2
    specimen, apart = fit.problem.specimens[k], fit.problem.whiteners[k].without_scale
    measured = apart(specimen.force)

    def asked(offset: float) -> tuple[float, float]:
        """Sum of squares with priors, and stiffness, with an offset."""
        here = replace(specimen, contact=offset, stiffness=1.0)
        one = apart(fit.model.predict(here, fit.state))
        stiffness = float(one @ measured + pulled) / float(one @ one + pulled)
        squares = np.sum((measured - stiffness * one) ** 2) + pulled * (stiffness - 1.0) ** 2
        return float(squares) + (offset / wide if wide else 0.0) ** 2, stiffness

    def left(offset: float) -> float:
        return asked(offset)[0]

    best, known = 0.0, 0.0
    if wide:
        near, step = min(TRIED, key=left), TRIED[1] - TRIED[0]
        ends = (near - step, near + step)
        best = float(minimize_scalar(left, bounds=ends, method="bounded").x)
        curvature = (left(best + NEAR) - 2.0 * left(best) + left(best - NEAR)) / NEAR**2
        known = max(0.5 * curvature - wide**-2, 0.0)
    return float(np.log(np.clip(asked(best)[1], *RANGE))), best, known
