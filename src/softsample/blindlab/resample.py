"""How often a selection comes out again when the records are made anew from what it left over."""

import numpy as np

from softsample.calibration.uncertainty import resampled as of_series
from softsample.loop.diagnose import Diagnosis
from softsample.loop.fit import Fit, Problem
from softsample.loop.rounds import SelectionSettings
from softsample.loop.select import select

BLOCKS = 10.0
"""Mean length of the stretches that are drawn, in blocks of the record."""


def confidence(found: Diagnosis, settings: SelectionSettings, draws: int) -> float | None:
    """Share of resampled groups whose first class holds the first effect of a diagnosis.

    None without an effect or draws.

    Parameters
    ----------
    found : Diagnosis
        Of a group that others told nothing of.
    settings : SelectionSettings
        As of `select`.
    draws : int
        Resampled groups; each is a selection of its own.

    References
    ----------
    D. N. Politis, J. P. Romano, J. Am. Stat. Assoc. 89 (1994) 1303,
    doi:10.1080/01621459.1994.10476870.
    """
    problem, selection = found.posed.problem, found.selection
    if draws == 0 or found.objection or not selection.classes:
        return None
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
    noise = problem.coloured(np.concatenate([of_series(part, BLOCKS, random) for part in white]))
    for force, means, whitener in zip(forces, noise, problem.whiteners, strict=True):
        every = np.zeros(len(whitener.keep))
        every[whitener.keep] = means
        force[: len(every) * whitener.size] += np.repeat(every, whitener.size)
    return problem.with_forces(forces)
