"""How far the parameters of a fit may be off.

References
----------
R. T. Birge, Physical Review 40 (1932) 207, doi:10.1103/PhysRev.40.207.
"""

from collections.abc import Mapping

import numpy as np

from softsample.loop.effects.base import Effect
from softsample.loop.fit import DIFFERENCE, Fit
from softsample.loop.model import Packing
from softsample.loop.scale import scatter
from softsample.loop.specimen import Array
from softsample.response.floor import rectangular

NOTHING = 1e-9
"""Part of the variance of the discrepancy below which a fit takes all of it."""


def birge_ratio(fit: Fit) -> float:
    """Root mean square of what a fit leaves over that which its discrepancy predicts, at least 1.

    Sizes of the discrepancy are estimated from how rough residuals are, and have limits. What a
    fit leaves may be larger as a whole, and its parameters are then further off by as much. Every
    test counts in parts of its peak.
    """
    problem, found, expected, stated = fit.problem, 0.0, 0.0, 0.0
    of_tests = problem.each(fit.residual, fit.slopes, problem.variance)
    for specimen, w, left, slope, variance in of_tests:
        if w.keep.any():
            taken = np.einsum("ij,jk,ik->i", slope, fit.covariance, slope)
            found += float(np.mean(left**2)) / specimen.peak**2
            expected += float(np.mean(variance - taken)) / specimen.peak**2
            stated += float(np.mean(variance)) / specimen.peak**2
    return float(np.sqrt(max(1.0, found / expected))) if expected > NOTHING * stated else 1.0


def deviations(fit: Fit) -> Array:
    """Standard deviations (p,) of the packed parameters of a fit."""
    return np.asarray(birge_ratio(fit) * np.sqrt(np.diag(fit.covariance)))


def log_modulus_deviation(fit: Fit, stiffness: Mapping[str, float]) -> float:
    """Standard deviation of ln(mu): of the fit, and of a scale that all tests share.

    Where the stiffness of specimens scatters, the modulus is their geometric mean.
    """
    return _with_shared(float(deviations(fit)[0]), fit, stiffness)


def relaxing(fit: Fit) -> list[Effect]:
    """Effects of a model with which the modulus falls in the course of time."""
    return [effect for effect in fit.model.effects if effect.of_time and effect.whole]


def relaxed_modulus(fit: Fit, stiffness: Mapping[str, float]) -> tuple[float, float] | None:
    """Modulus [Pa] that is left at the end of the longest record, and deviation of its logarithm.

    None if nothing in the model relaxes.
    """
    effects = relaxing(fit)
    if not effects:
        return None
    packing = Packing(fit.model, fit.problem.fractions)

    def log_left(vector: Array) -> float:
        state = packing.unpack(vector)
        lost = sum(e.whole(state.values[e.name]) for e in effects if e.whole)
        return float(np.log(state.material.mu * max(1.0 - lost, NOTHING)))

    vector = packing.pack(fit.state)
    found = log_left(vector)
    steps = DIFFERENCE * np.eye(len(vector))
    slope = np.array([log_left(vector + step) - found for step in steps]) / DIFFERENCE
    own = birge_ratio(fit) * float(np.sqrt(slope @ fit.covariance @ slope))
    return float(np.exp(found)), _with_shared(own, fit, stiffness)


def _with_shared(own: float, fit: Fit, stiffness: Mapping[str, float]) -> float:
    """Standard deviation of the logarithm of a modulus, with what its fit does not know."""
    found = float(np.hypot(own, 0.01 * fit.problem.settings.scale_percent))
    if stiffness:
        found = float(np.hypot(found, scatter(stiffness) / np.sqrt(len(stiffness))))
    return found


def bond_deviation(fit: Fit) -> float:
    """Standard deviation of ln(mu) by what the bonded area leaves open.

    The step from the model's bonded area to that of the other rule, the same part of it in all
    tests, is one parameter more, linearly; either rule is a limit (`rectangular`). Records that
    show it, as tension beside compression may, leave less open.
    """
    problem = fit.problem
    forces = problem.predicted(fit.model, fit.state)
    change = problem.white([s.bond * f for s, f in zip(problem.specimens, forces, strict=True)])
    beside = fit.jacobian[: problem.count].T @ change
    known = float(change @ change) + rectangular(1.0) ** -2
    with_it = fit.information - np.outer(beside, beside) / known
    more = np.linalg.inv(with_it)[0, 0] - fit.covariance[0, 0]
    return float(np.sqrt(max(more, 0.0)))
