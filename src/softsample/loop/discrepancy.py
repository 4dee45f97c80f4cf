"""How large the error is that a model leaves: variances estimated from the records.

The residual of a fit is a sum of the cell's noise and of errors whose correlation is known and
whose size is not. The sizes have log-normal priors about those of the settings. The most likely
ones are those of the restricted likelihood, which allows for what the fit has taken away.

References
----------
H. D. Patterson, R. Thompson, Biometrika 58 (1971) 545, doi:10.1093/biomet/58.3.545.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import minimize
from scipy.sparse import csr_array

from softsample.loop.fit import Fit, Problem
from softsample.loop.noise import AT_MOST_STATED, FURTHEST, Whitener
from softsample.loop.specimen import Array, Specimen, blocks

ROUNDS = 2
"""Of estimating sizes about a fit, and fitting with these."""

MOST_GROUPS = 150
"""Means of blocks of a test from which sizes are estimated, about as many at most."""

FIXED_THERE = 1e12
"""Precision of a parameter at the end of its range: the fit takes nothing away with it."""

NOTHING = 1e-12
"""Part of the precision of a parameter that keeps a factor positive whatever the rounding."""


@dataclass(frozen=True)
class _Test:
    """Means of one test: residual (n,) [N], slopes (n, p), covariances (n, n), (k, n * n) [N2].

    The last slopes are by what tests have in common, in the order of the parts.
    """

    residual: Array
    slopes: Array
    known: Array
    parts: Array


def estimated(problem: Problem, fit: Fit) -> Problem:
    """The same records with the most likely sizes of the discrepancy about a fit.

    Parameters
    ----------
    problem : Problem
        Records whose whiteners share the parts of their discrepancy.
    fit : Fit
        Of a model to them.
    """
    names = list(problem.whiteners[0].discrepancy)
    if not names or problem.settings.spread <= 1.0:
        return problem
    problem = scaled(problem, fit)
    tests = _tests(problem, fit, names)
    of_priors, count = fit.jacobian[problem.count :], fit.jacobian.shape[1]
    shared, end = {}, count + 1
    for name, columns in problem.whiteners[0].shared.items():
        shared[names.index(name)] = slice(end, end := end + columns.shape[1])
    prior, score = np.ones(end), np.zeros(end)  # 1 is that of what all tests share
    prior[:count] = fit.flat + np.sum(of_priors**2, axis=0)
    prior[:count][fit.at_end] = FIXED_THERE
    score[:count] = of_priors.T @ fit.white[problem.count :]
    width = np.log(problem.settings.spread)
    here = problem.whiteners[0].variances
    starts = [np.zeros(len(names)), np.array([0.5 * np.log(here[name]) for name in names])]
    far = width * FURTHEST
    bounds = [(-far, 0.0 if name in AT_MOST_STATED else far) for name in names]
    found = min(
        (
            minimize(
                _restricted, start, (tests, prior, score, shared, width), jac=True,
                method="L-BFGS-B", bounds=bounds, options={"maxiter": 30, "ftol": 1e-6},
            )
            for start in starts[: 2 if starts[1].any() else 1]
        ),
        key=lambda result: result.fun,
    )  # fmt: skip
    variances = dict(zip(names, np.exp(2.0 * found.x).tolist(), strict=True))
    return problem.with_variances(variances)


def scaled(problem: Problem, fit: Fit) -> Problem:
    """The same with an error of scale that goes with the force of a fit."""
    forces = problem.predicted(fit.model, fit.state)
    whiteners = [
        w.with_scale(0.01 * problem.settings.scale_percent * blocks(force, w.size))
        for w, force in zip(problem.whiteners, forces, strict=True)
    ]
    return replace(problem, whiteners=whiteners)


def settled(problem: Problem, fit: Fit, rounds: int = ROUNDS) -> Fit:
    """A fit with the most likely sizes of the discrepancy about it."""
    for _ in range(rounds):
        problem = estimated(problem, fit)
        fit = problem.fit(fit.model, fit.state)
    return fit


def _tests(problem: Problem, fit: Fit, names: Sequence[str]) -> list[_Test]:
    """Means of groups of blocks of every test."""
    found = []
    for specimen, w, r, j, common in problem.each(fit.residual, fit.slopes, problem.common):
        if not len(r):
            continue
        to = averaging(specimen, w)
        parts = np.stack([(to @ w.kept(w.part(name)) @ to.T).ravel() for name in names])
        columns = np.column_stack([j, w.blocks(common), *(c[w.keep] for c in w.shared.values())])
        found.append(_Test(to @ r, to @ columns, to @ w.kept(w.known) @ to.T, parts))
    return found


def averaging(specimen: Specimen, whitener: Whitener) -> csr_array:
    """Matrix (m, n) that takes means of neighbours of the blocks of a test that count.

    Neighbours are near in travel and in time, of which the whole counts as one stroke.
    """
    travel, time = whitener.blocks(specimen.travel), whitener.blocks(specimen.time)
    parts = travel / specimen.reach, time / max(float(np.ptp(time)), 1e-9)
    way = np.cumsum(np.hypot(*(np.diff(part, prepend=part[0]) for part in parts)))
    place = np.floor(MOST_GROUPS * way / max(float(way[-1]), 1e-300))
    _, place, count = np.unique(place, return_inverse=True, return_counts=True)
    return csr_array((place == np.arange(len(count))[:, None]) / count[:, None])


def _restricted(
    x: Array,
    tests: Sequence[_Test],
    prior: Array,
    pulled: Array,
    shared: Mapping[int, slice],
    width: float,
) -> tuple[float, Array]:
    """Negative logarithm of the restricted posterior of log sizes (k,), and its slope.

    `prior` is the information of priors (p,), `pulled` what they ask of the parameters as the tests
    do; `shared` are the entries whose variance is that of a size.
    """
    variances = np.exp(2.0 * x)
    prior = prior.copy()
    for k, entries in shared.items():
        prior[entries] = 1.0 / variances[k]
    value, information, score = 0.0, np.diag(prior), pulled.copy()
    inverses, weighted = [], []
    for test in tests:
        total = test.known + (variances @ test.parts).reshape(test.known.shape)
        total += 1e-10 * np.trace(total) / len(total) * np.eye(len(total))
        factor = cholesky(total, lower=True, check_finite=False)
        value += float(np.log(np.diag(factor)).sum())
        half = solve_triangular(factor, np.eye(len(total)), lower=True, check_finite=False)
        inverses.append(half.T @ half)
        slopes, residual = half @ test.slopes, half @ test.residual
        weighted.append(half.T @ slopes)
        information += slopes.T @ slopes  # positive whatever the rounding, where slopes are alike
        score += slopes.T @ residual
        value += 0.5 * float(residual @ residual)
    scale = 1.0 / np.sqrt(np.diag(information))
    inner = cholesky(
        information * np.outer(scale, scale) + NOTHING * np.eye(len(scale)), lower=True
    )
    value += float(np.log(np.diag(inner) / scale).sum())
    root = solve_triangular(inner, np.diag(scale), lower=True)
    moved = root.T @ (root @ score)
    value -= 0.5 * float(score @ moved)
    slope = np.zeros(len(x))
    for test, inverse, own in zip(tests, inverses, weighted, strict=True):
        left, taken = inverse @ test.residual - own @ moved, own @ root.T
        felt = inverse - taken @ taken.T - np.outer(left, left)
        slope += variances * (test.parts @ felt.ravel())
    for k, entries in shared.items():
        felt = np.sum(root[:, entries] ** 2, axis=0) + moved[entries] ** 2
        value += x[k] * len(felt)
        slope[k] += len(felt) - float(felt.sum()) / variances[k]
    prior_part = x / width
    return value + 0.5 * float(prior_part @ prior_part), slope + prior_part / width
