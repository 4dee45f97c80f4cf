"""Test protocol: how the moving platen travels over time."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def smooth_step(fraction: ArrayLike) -> NDArray[np.float64]:
    """Quintic smooth step ``x^3 (10 - 15 x + 6 x^2)`` from 0 to 1.

    Speed and acceleration vanish at both ends, so that a fast loading excites few vibrations.

    Parameters
    ----------
    fraction : array_like
        Time over loading time, dimensionless; clipped to [0, 1].
    """
    x = np.clip(np.asarray(fraction, dtype=np.float64), 0.0, 1.0)
    return np.asarray(x**3 * (10.0 - 15.0 * x + 6.0 * x**2))
