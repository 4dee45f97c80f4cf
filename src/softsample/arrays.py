"""Types of arrays that every part of the package names."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ids = NDArray[np.int64]
"""Numbers of nodes, elements, groups."""
Mask = NDArray[np.bool_]
