"""Quasi-linear relaxation of a force."""

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
