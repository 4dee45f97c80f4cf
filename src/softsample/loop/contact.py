"""Where compression begins in each of several specimens, which need not touch at one height."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from softsample.loop.discrepancy import settled
from softsample.loop.fit import Fit
from softsample.loop.scale import same_tests, stiffness_asked
from softsample.loop.specimen import Array, Specimen

ROUNDS = 2
"""Of fitting the group's material, with the discrepancy about it, and what is each specimen's own:
an offset shows better where the discrepancy no longer has to stand for it."""

TRIED = np.linspace(-1.0, 1.0, 41)
"""Offsets that are tried first [mm]: where contact sets in late, the sum of squares has minima."""


def own_contact(first: Fit, least_gain: float) -> dict[str, float]:
    """Displacement at which the compression of each specimen begins, over the mean [mm].

    Of specimens that had the same test, each with a stiffness of its own meanwhile. Empty if the
    records do not ask for it: if the likelihood does not rise by more than the penalty for the
    offsets.

    Parameters
    ----------
    first : Fit
        Of a model in which all begin at one displacement.
    least_gain : float
        Fall of twice the negative log likelihood beyond the penalty that counts.
    """
    tests = _comparable(first.problem.specimens)
    if not tests:
        return {}
    alike, _ = _settled(first, tests, False)
    own, offsets = _settled(first, tests, True)
    zero = first.problem.settings.contact_zero_mm
    penalties = sum((x / zero) ** 2 for x in offsets.values())
    penalties += (len(offsets) - 1) * np.log(len(first.white))
    return offsets if alike.misfit - own.misfit - penalties > least_gain else {}


def _comparable(specimens: Sequence[Specimen]) -> list[list[int]]:
    """Places of tests in which a platen presses on several specimens in the same way."""
    found: dict[int, list[int]] = {}
    for k, (specimen, test) in enumerate(zip(specimens, same_tests(specimens), strict=True)):
        if specimen.elastic.contact:
            found.setdefault(test, []).append(k)
    return [of for of in found.values() if len({specimens[k].piece for k in of}) > 1]


def _settled(
    first: Fit, tests: Sequence[Sequence[int]], moved: bool
) -> tuple[Fit, dict[str, float]]:
    """Fit with the stiffness of each specimen and, if they are moved, offsets by specimen [mm]."""
    fit, offsets = first, {}
    for _ in range(ROUNDS):
        stiffness, found = _own(fit, tests, moved)
        offsets = found if moved else {}
        problem = fit.problem.of_stiffness(stiffness).of_contact(offsets)
        fit = settled(problem, problem.fit(fit.model, fit.state), 1)
    return fit, offsets


def _own(
    fit: Fit, tests: Sequence[Sequence[int]], moved: bool
) -> tuple[dict[str, float], dict[str, float]]:
    """Stiffness over its mean, and offset less its mean [mm], that each specimen asks for."""
    asked: dict[str, list[Array]] = {}
    for places in tests:
        found = [_of_test(fit, k, moved) for k in places]
        for k, own in zip(places, found, strict=True):
            piece = fit.problem.specimens[k].piece
            asked.setdefault(piece, []).append(own - np.mean(found, axis=0))
    means = {piece: np.mean(of, axis=0) for piece, of in asked.items()}
    stiffness = {piece: float(np.exp(log)) for piece, (log, _) in means.items()}
    return stiffness, {piece: float(offset) for piece, (_, offset) in means.items()}


def _of_test(fit: Fit, k: int, moved: bool) -> Array:
    """Log of the stiffness of one specimen over that of the group, and its offset [mm]."""
    specimen, zero = fit.problem.specimens[k], fit.problem.settings.contact_zero_mm
    apart = fit.problem.whiteners[k].without_scale
    measured = apart(specimen.force)

    def asked(offset: float) -> tuple[float, float]:
        """Sum of squares, and stiffness, with an offset."""
        there = replace(specimen, contact=offset, stiffness=1.0)
        one = apart(fit.model.predict(there, fit.state))
        factor = stiffness_asked(float(one @ measured), float(one @ one))
        return float(np.sum((measured - factor * one) ** 2)) + (offset / zero) ** 2, factor

    if not moved:
        return np.array([np.log(asked(0.0)[1]), 0.0])
    here = min(TRIED, key=lambda x: asked(x)[0])
    step = TRIED[1] - TRIED[0]
    best = minimize_scalar(
        lambda x: asked(x)[0], bounds=(here - step, here + step), method="bounded"
    ).x
    return np.array([np.log(asked(best)[1]), best])
