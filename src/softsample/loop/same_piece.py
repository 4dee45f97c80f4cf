"""Errors of geometry, which tests of one piece at several speeds have in common.

Shape, mesh and glued area are the same in each of them, so that what goes with the speed shows far
more sharply than the error of any one of them would allow. Of tests at one speed nothing says
whether they were made in one direction.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from softsample.loop.noise import SIMILARITY, NoiseSettings, Similarity, Whitener, moved
from softsample.loop.specimen import Array, Specimen, blocks
from softsample.protocol import ALIKE

KNOTS = 33
"""Travels at which the error that goes with the travel is a variate: between them it is smooth."""


def same_piece(specimens: Sequence[Specimen]) -> list[int | None]:
    """A number for each test, the same for those of one piece at several speeds; none for others.

    They are of one mode and channel, and go about as far.
    """
    found = numbered(specimens, _alike)
    of = [
        [s for s, place in zip(specimens, found, strict=True) if place == k]
        for k in range(max(found, default=-1) + 1)
    ]
    several = [k for k, tests in enumerate(of) if _speeds_differ(tests)]
    return [several.index(place) if place in several else None for place in found]


def numbered(
    specimens: Sequence[Specimen], alike: Callable[[Specimen, Specimen], bool]
) -> list[int]:
    """A number for each test, the same for those that are like the first of that number."""
    firsts: list[Specimen] = []
    found = []
    for specimen in specimens:
        like = [alike(specimen, first) for first in firsts]
        found.append(like.index(True) if any(like) else len(firsts))
        firsts += [] if any(like) else [specimen]
    return found


def _alike(one: Specimen, other: Specimen) -> bool:
    near = 1.0 / ALIKE < one.reach / other.reach < ALIKE
    return near and (one.piece, one.mode, one.channel) == (other.piece, other.mode, other.channel)


def _speeds_differ(tests: Sequence[Specimen]) -> bool:
    times = [test.loading_time for test in tests if test.timed]
    return len(times) == len(tests) > 1 and max(times) > ALIKE * min(times)


def in_common(
    specimens: Sequence[Specimen], whiteners: Sequence[Whitener], settings: NoiseSettings
) -> list[Whitener]:
    """Whiteners whose smooth errors and scales are those of a piece, not of each of its tests.

    Parameters
    ----------
    specimens : sequence of Specimen
        Tests of a group.
    whiteners : sequence of Whitener
        One for each, as if it were the only test.
    settings : NoiseSettings
        Sizes of the errors.
    """
    slots = same_piece(specimens)
    count = len({slot for slot in slots if slot is not None})
    if not count:
        return list(whiteners)
    found = []
    for specimen, w, slot in zip(specimens, whiteners, slots, strict=True):
        own, shape = dict(w.discrepancy), w.known.shape
        smooth = {name: np.zeros((len(w.known), count, KNOTS)) for name in SIMILARITY}
        scale = np.zeros((len(w.known), count))
        if slot is not None:
            tests = [s for s, of in zip(specimens, slots, strict=True) if of == slot]
            for name, columns in smooth.items():
                columns[:, slot] = _smooth(specimen, w.size, tests, settings, SIMILARITY[name])
            scale[:, slot] = _column(w.part("scale"))
            own |= {name: np.zeros(shape) for name in (*smooth, "scale")}
        shared = {name: columns.reshape(len(columns), -1) for name, columns in smooth.items()}
        shared["scale"] = scale
        found.append(replace(w, discrepancy=own, shared=shared, slot=slot))
    return found


def _column(covariance: Array) -> Array:
    """What one variate adds (n,) [N], of a covariance (n, n) of rank one; its sign is open."""
    largest = int(np.argmax(np.diag(covariance)))
    return np.asarray(covariance[largest] / np.sqrt(max(covariance[largest, largest], 1e-300)))


def _smooth(
    specimen: Specimen,
    size: int,
    tests: Sequence[Specimen],
    settings: NoiseSettings,
    similarity: Similarity,
) -> Array:
    """What each variate of one smooth error of a piece adds to the blocks of a test (n, m) [N].

    It is the same force in each of its tests: one that went with their peaks would be a scale.
    """
    reach = max(test.reach for test in tests)
    peak = float(np.mean([test.peak for test in tests]))
    low = min(float(test.travel.min()) for test in tests)
    high = max(float(test.travel.max()) for test in tests)
    knots = np.linspace(low, high, KNOTS) / reach
    apart = np.subtract.outer(knots, knots)
    factor = cholesky(similarity(apart, settings.floor_length) + 1e-9 * np.eye(KNOTS), lower=True)
    way = blocks(specimen.travel, size) / reach
    alike = similarity(np.subtract.outer(knots, way), settings.floor_length)
    variates = solve_triangular(factor, alike, lower=True).T
    percents = moved(specimen, size) * peak / specimen.peak
    return np.asarray(settings.each_percent * percents[:, None] * variates)
