"""Whether groups share the parameters of a law.

References
----------
W. G. Cochran, Biometrics 10 (1954) 101, doi:10.2307/3001666 (test of homogeneity).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.special import chdtrc

from softsample.arrays import Array
from softsample.errors import CalibrationError


def shared_value(values: Sequence[Array], covariances: Sequence[Array]) -> dict[str, Any]:
    """Parameters that groups share, and whether they do.

    The weighted squares of what parts the groups from the value that suits all have chi-squared's
    distribution with k (groups - 1) degrees of freedom if the parameters are the same.

    Parameters
    ----------
    values : sequence of (k,) float64
        Parameters of each group.
    covariances : sequence of (k, k) float64
        Theirs.

    Returns
    -------
    dict
        `value` (k,), `deviance`, `degrees_of_freedom`, `p_value`, `groups`.

    Raises
    ------
    CalibrationError
        With fewer than two groups.
    """
    if len(values) < 2:
        raise CalibrationError("the parameters of one group alone cannot be compared")
    weights = [np.linalg.inv(covariance) for covariance in covariances]
    sought = sum(w @ v for w, v in zip(weights, values, strict=True))
    value = np.linalg.solve(np.sum(weights, axis=0), sought)
    parts = [v - value for v in values]
    deviance = float(sum(p @ w @ p for w, p in zip(weights, parts, strict=True)))
    freedom = len(value) * (len(values) - 1)
    return {
        "groups": len(values),
        "value": value,
        "deviance": deviance,
        "degrees_of_freedom": freedom,
        "p_value": float(chdtrc(freedom, deviance)),
    }
