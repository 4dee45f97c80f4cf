"""How often a selection comes out again when the records are made anew from what it left over."""

import numpy as np
from numpy.typing import NDArray

from softsample.loop.fit import Fit, Problem
from softsample.loop.rounds import SelectionSettings
from softsample.loop.select import Selection, select

BLOCKS = 10.0
"""Mean length of the stretches that are drawn, in blocks of the record."""


def confidence(
    problem: Problem, selection: Selection, settings: SelectionSettings, draws: int
) -> float:
    """Share of resampled groups whose first class holds the first effect of the selection.

    Parameters
    ----------
    problem : Problem
        Records with their noise, without doubt of form.
    selection : Selection
        What was found in them, with one effect at least.
    settings : SelectionSettings
        As of `select`.
    draws : int
        Resampled groups; each is a selection of its own.

    References
    ----------
    D. N. Politis, J. P. Romano, J. Am. Stat. Assoc. 89 (1994) 1303,
    doi:10.1080/01621459.1994.10476870.
    """
    random = np.random.default_rng([settings.seed, draws])
    first = selection.final.model.names[0]
    again = [
        select(resampled(problem, selection.final, random), selection.library, settings)
        for _ in range(draws)
    ]
    return float(np.mean([first in next(iter(s.classes.values()), []) for s in again]))


def resampled(problem: Problem, fit: Fit, random: np.random.Generator) -> Problem:
    """The group with every record replaced by the fit plus stretches of its white residual."""
    forces = problem.predicted(fit.model, fit.state)
    left = [s.force - force for s, force in zip(problem.specimens, forces, strict=True)]
    white = problem.by_test(problem.white(left))
    drawn = [part[stretches(len(part), BLOCKS, random)] for part in white]
    noise = problem.coloured(np.concatenate(drawn))
    for force, means, whitener in zip(forces, noise, problem.whiteners, strict=True):
        every = np.zeros(len(whitener.keep))
        every[whitener.keep] = means
        force[: len(every) * whitener.size] += np.repeat(every, whitener.size)
    return problem.with_forces(forces)


def stretches(n: int, mean: float, random: np.random.Generator) -> NDArray[np.int64]:
    """Places (n,) of the stationary bootstrap: stretches of random start and geometric length."""
    starts = random.integers(0, n, n)
    places = np.empty(n, np.int64)
    new = random.uniform(size=n) < 1.0 / mean
    for k in range(n):
        places[k] = starts[k] if new[k] or k == 0 else (places[k - 1] + 1) % n
    return places
