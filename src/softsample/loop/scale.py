"""Stiffness of specimens: scales of their tests, which are there in other records of them too."""

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from softsample.loop.fit import Fit, Problem
from softsample.loop.specimen import Specimen

Array = NDArray[np.float64]

ROUNDS = 3
"""Of fitting the group's material and the stiffness of each specimen in turn."""

RANGE = (0.05, 20.0)
"""Of the stiffness of a specimen over that of the group."""

Key = tuple[str, str, str]
Scales = Mapping[Key, float]
"""Error of scale, as a part of the force, by specimen, mode and channel."""


def by_specimen(errors: Iterable[tuple[Specimen, float]]) -> dict[Key, float]:
    """Means over the tests that one specimen had in one mode."""
    found: dict[Key, list[float]] = {}
    for specimen, error in errors:
        found.setdefault(_key(specimen), []).append(error)
    return {key: float(np.mean(parts)) for key, parts in found.items()}


def scale_of(specimen: Specimen, known: Scales) -> float:
    """Error of the scale of a test, that of the other channel if its own is not known, or none."""
    own = _key(specimen)
    if own in known:
        return known[own]
    others = [error for key, error in known.items() if key[:2] == own[:2]]
    return float(np.mean(others)) if others else 0.0


def relative_stiffness(problem: Problem, fit: Fit) -> dict[str, float]:
    """Modulus of each specimen over their geometric mean, of those that had a test in common.

    A specimen that alone had its tests says nothing of its stiffness: their scales may differ for
    other reasons.

    Parameters
    ----------
    problem : Problem
        Records of a group.
    fit : Fit
        Of a model of one stiffness; its discrepancy counts, but for that of scale.
    """
    found: dict[str, float] = {}
    for _ in range(ROUNDS):
        known = problem.of_stiffness(found)
        found = _relative(known, known.fit(fit.model, fit.state))
    return found


def _relative(problem: Problem, fit: Fit) -> dict[str, float]:
    """Stiffness that each specimen's records ask for, all else as it is, over the mean."""
    forces = problem.predicted(fit.model, fit.state)
    tests = list(zip(problem.specimens, problem.whiteners, forces, strict=True))
    pieces: dict[tuple[str, str], set[str]] = {}
    for specimen, *_ in tests:
        pieces.setdefault((specimen.mode, specimen.channel), set()).add(specimen.piece)
    sums: dict[str, Array] = {}
    for specimen, w, force in tests:
        if len(pieces[specimen.mode, specimen.channel]) > 1:
            apart = w.with_variances({**w.variances, "scale": 0.0})
            one, measured = apart(force), apart(specimen.force)
            more = np.array([one @ measured, one @ one / specimen.stiffness])
            sums[specimen.piece] = sums.get(specimen.piece, np.zeros(2)) + more
    asked = {piece: np.clip(top / bottom, *RANGE) for piece, (top, bottom) in sums.items()}
    mean = float(np.exp(np.mean(np.log(list(asked.values()))))) if asked else 1.0
    return {piece: float(stiffness) / mean for piece, stiffness in asked.items()}


def scatter(stiffness: Mapping[str, float]) -> float:
    """Standard deviation of the logarithm of the stiffness of specimens; 0 of fewer than two."""
    logs = np.log(list(stiffness.values()))
    return float(np.std(logs, ddof=1)) if len(logs) > 1 else 0.0


def most_likely(problem: Problem, fit: Fit) -> dict[Key, float]:
    """Posterior means of the errors of scale of fitted tests.

    The residual of the fit has to be one that the discrepancy of the problem is made for: of a
    model without a correction.
    """
    forces = problem.predicted(fit.model, fit.state)
    errors = []
    for specimen, w, force in zip(problem.specimens, problem.whiteners, forces, strict=True):
        size = 0.01 * problem.settings.sizes(w.variances).get("scale", 0.0)
        errors.append((specimen, size**2 * float(w(force) @ w(specimen.force - force))))
    return by_specimen(errors)


def _key(specimen: Specimen) -> Key:
    return specimen.piece, specimen.mode, specimen.channel
