"""Error of the scale of a test: it belongs to the specimen, and is there in other records of it."""

from collections.abc import Iterable, Mapping

import numpy as np

from softsample.loop.fit import Fit, Problem
from softsample.loop.specimen import Specimen

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
