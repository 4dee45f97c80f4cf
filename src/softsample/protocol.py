"""Test protocol: how the moving platen travels over time, and where its loading ramp lies."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsample.errors import InputError

Array = NDArray[np.float64]

DIRECTIONS = {"tension": (0.0, 0.0, 1.0), "compression": (0.0, 0.0, -1.0), "shear": (1.0, 0.0, 0.0)}
"""Direction of the moving platen's travel in each test mode (sample frame)."""


def smooth_step(fraction: ArrayLike) -> Array:
    """Quintic smooth step ``x^3 (10 - 15 x + 6 x^2)`` from 0 to 1.

    Speed and acceleration vanish at both ends, so that a fast loading excites few vibrations.

    Parameters
    ----------
    fraction : array_like
        Time over loading time, dimensionless; clipped to [0, 1].
    """
    x = np.clip(np.asarray(fraction, dtype=np.float64), 0.0, 1.0)
    return np.asarray(x**3 * (10.0 - 15.0 * x + 6.0 * x**2))


def travel_sign(mode: str) -> float:
    """Sign of displacement and force while loading: -1 in compression, +1 otherwise."""
    return float(sum(DIRECTIONS[mode]))


def loading_ramp(displacement: ArrayLike, window: int = 11) -> slice:
    """First loading ramp of a displacement history, from its last rest to its first top.

    Parameters
    ----------
    displacement : (n,) array_like
        Travel along the loading direction (positive while loading), evenly sampled, any unit.
    window : int
        Samples of the running mean that hides noise.

    Returns
    -------
    slice
        Samples of the ramp; a baseline before it and whatever follows its top are left out.

    Raises
    ------
    InputError
        If the platen does not travel away from its start by more than its noise.
    """
    raw = np.asarray(displacement, dtype=np.float64)
    window = max(1, min(window, len(raw) // 4))
    padded = np.pad(raw, (window // 2, window - 1 - window // 2), mode="edge")
    smooth = np.convolve(padded, np.full(window, 1.0 / window), mode="valid")
    noise = float(np.std(raw - smooth))
    rest = float(np.median(smooth[: 2 * window]))
    reach = float(smooth.max()) - min(rest, float(smooth[0]))
    if not reach > 20.0 * noise:
        raise InputError(
            f"the platen travels {reach:g} against a noise of {noise:g}; "
            "give a record that holds a loading ramp (sign as in the table's mode)"
        )
    highest = np.maximum.accumulate(smooth)
    turned = np.flatnonzero(smooth < highest - 0.05 * reach)
    top = highest[turned[0]] if len(turned) else highest[-1]
    end = int(np.argmax(smooth >= top - max(noise, 1e-3 * reach))) + 1
    low = rest + 0.002 * reach
    below = np.flatnonzero(smooth[:end] <= low)
    start = int(below[-1]) if len(below) else 0
    return slice(start, max(end, len(raw)) if end >= len(raw) - window else end)
