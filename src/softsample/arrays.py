"""Types of arrays, and what every part of the package does with them."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Ids = NDArray[np.int64]
"""Numbers of nodes, elements, groups."""
Mask = NDArray[np.bool_]


def root_mean_square(values: ArrayLike) -> float:
    """Root mean square; NaN of nothing."""
    squares = np.square(values)
    return float(np.sqrt(np.mean(squares))) if squares.size else float("nan")
