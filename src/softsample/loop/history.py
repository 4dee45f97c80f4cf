"""Quasi-linear relaxation of a force, of the tissue or by what drains from it."""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]


def relaxed(time: Array, force: Array, g: float, tau: float) -> Array:
    """``F - g int (1 - exp(-(t - s)/tau)) dF(s)`` of an elastic force at even times.

    Exact for a force that is linear between samples.

    References
    ----------
    Y. C. Fung, Biomechanics: Mechanical Properties of Living Tissues, Springer 1993.
    """
    step = float(time[-1] - time[0]) / (len(time) - 1)
    decay = np.exp(-step / tau)
    gain = tau / step * (1.0 - decay)
    growth = force.copy()
    growth[1:] -= force[:-1]
    remembered = lfilter([gain], [1.0, -decay], growth)
    return np.asarray((1.0 - g) * force + g * remembered)


DRAINING = 8
"""Terms of the consolidation series; the last one is 225 times as fast as the first."""


def drained(time: Array, force: Array, g: float, tau: float) -> Array:
    """`relaxed` by the consolidation of a layer: ``g sum 8/(pi n)^2 (1 - exp(-n^2 t/tau))``, n odd.

    It begins with the square root of time. `tau` is the slowest of its times; terms faster than
    the last one that is taken, a fortieth of it all, relax at once.

    References
    ----------
    K. Terzaghi, Theoretical Soil Mechanics, Wiley 1943, doi:10.1002/9780470172766.
    """
    odd = np.arange(1, 2 * DRAINING, 2)
    kept = [8.0 / (np.pi * n) ** 2 * relaxed(time, force, 1.0, tau / n**2) for n in odd]
    return np.asarray((1.0 - g) * force + g * np.sum(kept, axis=0))
