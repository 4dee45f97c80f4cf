"""The largest stable time step."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh_tridiagonal

from softsample.errors import CrushedError, SimulationError

LANCZOS_STEPS = 12
"""Enough for the critical step within 2 %, which the safety factor covers."""


def largest_eigenvalue(
    stiffness: Callable[[NDArray], NDArray], mass: NDArray, start: NDArray
) -> float:
    """Largest eigenvalue of ``M^-1 K`` [1/s2] by Lanczos' method in the inner product of M.

    The residual is added, so that the value errs on the safe side.

    Parameters
    ----------
    stiffness : callable
        K times a displacement of the shape of `start`.
    mass : (n, 1) ndarray
        Lumped masses [kg], zero for held nodes.
    start : (n, k) ndarray
        Random start vector, changed nowhere; its dtype is that of the iteration. A fresh one
        lets the estimate find a local mode that has just become the stiffest.

    Raises
    ------
    SimulationError
        If the stiffness is not positive, or no node is free.

    References
    ----------
    C. Lanczos, J. Res. Natl. Bur. Stand. 45 (1950) 255, doi:10.6028/jres.045.026.
    """
    free = mass > 0.0
    if not free.any():
        raise SimulationError("no node is free to move; lower mesh: element_size_mm")
    inverse = np.divide(1.0, mass, out=np.zeros_like(mass), where=free)
    q = start * free
    q /= np.sqrt(np.vdot(q, q * mass))
    before, beta = np.zeros_like(q), q.dtype.type(0.0)
    diagonal, off = np.empty(LANCZOS_STEPS), np.empty(LANCZOS_STEPS)
    for k in range(LANCZOS_STEPS):
        w = stiffness(q) * inverse
        diagonal[k] = np.vdot(w, q * mass)
        w -= q.dtype.type(diagonal[k]) * q + beta * before
        beta = np.sqrt(np.vdot(w, w * mass))
        off[k] = beta
        before, q = q, w / beta
    largest = bound = 0.0
    if np.isfinite([diagonal, off]).all():
        values, vectors = eigh_tridiagonal(diagonal, off[:-1])
        largest = float(values[-1])
        bound = largest + float(abs(off[-1] * vectors[-1, -1]))
    if largest <= 0.0:
        raise CrushedError(
            "the stiffness of the mesh is not positive; check the mesh quality report "
            "and lower solver: safety_factor"
        )
    return bound
