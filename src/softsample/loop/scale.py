"""Stiffness of specimens: scales of their tests, which are there in other records of them too."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from softsample.loop.discrepancy import scaled
from softsample.loop.fit import Fit
from softsample.loop.noise import KINDS
from softsample.loop.same_piece import numbered, same_piece
from softsample.loop.specimen import Array, Specimen
from softsample.protocol import ALIKE

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


def relative_stiffness(fit: Fit) -> dict[str, float]:
    """Modulus of each specimen over the geometric mean of those that had the same test.

    That is one of the same mode, along the same directions of the material if these are stated, to
    about the same strain at about the same speed. What had no test in common says nothing of
    stiffness: scales may differ for other reasons.

    Parameters
    ----------
    fit : Fit
        Of a model of one stiffness; its discrepancy counts, but for that of scale.
    """
    found: dict[str, float] = {}
    for _ in range(ROUNDS):
        found = _relative(fit.problem.with_own(stiffness=found).fit(fit.model, fit.state))
        if not found:
            break
    return found


def _relative(fit: Fit) -> dict[str, float]:
    """Stiffness that each specimen's records ask for, all else as it is, over the mean."""
    problem = fit.problem
    asked: dict[int, dict[str, Array]] = {}
    forces, tests = problem.predicted(fit.model, fit.state), same_tests(problem.specimens)
    common = _common_phases(problem.specimens, tests)
    for specimen, w, force, test in problem.each(forces, tests):
        apart, there = w.without_scale, np.isin(specimen.phase, common[test])
        one, measured = apart(there * force), apart(there * specimen.force)
        more = np.array([one @ measured, one @ one / specimen.stiffness])
        sums = asked.setdefault(test, {})
        nothing = np.array([0.0, 1e-300])  # a test without force asks for no stiffness
        sums[specimen.piece] = sums.get(specimen.piece, nothing) + more
    logs: dict[str, list[float]] = {}
    for sums in (of for of in asked.values() if len(of) > 1):
        own = {piece: np.log(np.clip(a / b, *RANGE)) for piece, (a, b) in sums.items()}
        mean = float(np.mean(list(own.values())))
        for piece, log in own.items():
            logs.setdefault(piece, []).append(float(log) - mean)
    return {piece: float(np.exp(np.mean(parts))) for piece, parts in logs.items()}


def _common_phases(specimens: Sequence[Specimen], tests: Sequence[int]) -> dict[int, list[str]]:
    """By test, phases with force that all its fitted records have: one's own may be history."""
    found: dict[int, set[str]] = {test: set(KINDS) for test in tests}
    for specimen, test in zip(specimens, tests, strict=True):
        found[test] &= {*specimen.phase[~specimen.held_out]} or found[test]
    return {test: [*of] if of - {"baseline"} else [] for test, of in found.items()}


def same_tests(specimens: Sequence[Specimen]) -> list[int]:
    """A number for each test, the same for those of one mode, direction, channel, strain, speed."""
    return numbered(specimens, _alike)


def _alike(one: Specimen, other: Specimen) -> bool:
    """Whether two tests are the same but for the specimen."""
    ratios = [one.strain / other.strain]
    if one.timed and other.timed:
        ratios.append(one.reach / other.reach * other.loading_time / one.loading_time)
    near = all(1.0 / ALIKE < ratio < ALIKE for ratio in ratios)
    return near and (one.way, one.channel) == (other.way, other.channel)


def scatter(stiffness: Mapping[str, float]) -> float:
    """Standard deviation of the logarithm of the stiffness of specimens; 0 of fewer than two."""
    logs = np.log(list(stiffness.values()))
    return float(np.std(logs, ddof=1)) if len(logs) > 1 else 0.0


def most_likely(fit: Fit) -> dict[Key, float]:
    """Posterior means of the errors of scale of fitted tests.

    Its residual has to be one that the discrepancy of its problem is made for: of a model without
    a correction.
    """
    problem = scaled(fit.problem, fit)
    forces = problem.predicted(fit.model, fit.state)
    variance = (0.01 * problem.settings.sizes(problem.variances).get("scale", 0.0)) ** 2
    left = problem.white([s.force - f for s, f in zip(problem.specimens, forces, strict=True)])
    pieces = same_piece(problem.specimens)
    errors = []
    for k, (specimen, piece) in enumerate(zip(problem.specimens, pieces, strict=True)):
        with_it = [
            j == k or (piece is not None and piece == other) for j, other in enumerate(pieces)
        ]
        column = problem.white([f * of for f, of in zip(forces, with_it, strict=True)])
        errors.append((specimen, variance * float(column @ left)))
    return by_specimen(errors)


def _key(specimen: Specimen) -> Key:
    return specimen.piece, specimen.mode, specimen.channel
