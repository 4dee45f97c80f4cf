"""What goes on depending on what was: relaxation of a force, play of a drive."""

import numpy as np
from numba import njit

from softsample.loop.specimen import Array

SAME = 1e-10
"""Relative difference up to which two steps of time are one, but for rounding."""


def relaxed(time: Array, force: Array, g: float, tau: float) -> Array:
    """``F - g int (1 - exp(-(t - s)/tau)) dF(s)`` of an elastic force at increasing times.

    Exact for a force that is linear between samples, however far they are apart. One that is there
    at the first sample has come in one step before it.

    References
    ----------
    Y. C. Fung, Biomechanics: Mechanical Properties of Living Tissues, Springer 1993.
    """
    return (1.0 - g) * force + g * _remembered(time, force, tau)


@njit(cache=True)
def _remembered(time: Array, force: Array, tau: float) -> Array:
    left, before, last = 0.0, 0.0, 0.0
    decay, gain = 1.0, 1.0
    found = np.empty_like(force)
    for k in range(len(force)):
        step = (time[max(k, 1)] - time[max(k, 1) - 1]) / tau
        if abs(step - last) > SAME * step:  # exponentials cost more than all the rest
            decay, gain, last = np.exp(-step), -np.expm1(-step) / step, step
        left = decay * left + gain * (force[k] - before)
        before = force[k]
        found[k] = left
    return found


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
    return (1.0 - g) * force + g * _undrained(time, force, tau)


@njit(cache=True)
def _undrained(time: Array, force: Array, tau: float) -> Array:
    kept = np.zeros_like(force)
    for n in range(1, 2 * DRAINING, 2):
        kept += 8.0 / (np.pi * n) ** 2 * _remembered(time, force, tau / n**2)
    return kept


def turned(travel: Array) -> Array:
    """Displacement (n,) that was the largest either way so far, with its sign."""
    largest = np.maximum.accumulate(np.abs(travel))
    at = np.where(np.abs(travel) >= largest, np.arange(len(travel)), 0)
    return np.asarray(travel[np.maximum.accumulate(at)])


@njit(cache=True)
def followed(travel: Array, play: float, ahead: float = 0.0) -> Array:
    """Travel of what is driven with play [as `travel`]: it stays until the play is used up.

    At the start a part `ahead` of the play lies in the direction of loading.
    """
    found = np.empty_like(travel)
    place = travel[0]
    for k in range(len(travel)):
        place = min(max(place, travel[k] - ahead * play), travel[k] + (1.0 - ahead) * play)
        found[k] = place
    return found
