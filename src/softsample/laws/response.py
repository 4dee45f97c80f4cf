"""Responses of laws: in closed form, or between runs of the solver."""

from dataclasses import dataclass

import numpy as np

from softsample.arrays import Array
from softsample.laws.candidates import Candidate
from softsample.response import law_response
from softsample.response.unit import homogeneous_area
from softsample.shapes import IdealShape

REFERRED = {**law_response.REFERRED, "torsion": "shear"}
"""Homogeneous test that one which is never uniform is referred to, at the same nominal strain."""


@dataclass(frozen=True)
class HomogeneousResponse:
    """A test that deforms an ideal shape uniformly, or what one that does not is referred to.

    Parameters
    ----------
    poisson_ratio : float
        Of laws that have none of their own.
    """

    shape: IdealShape
    mode: str
    poisson_ratio: float

    def unit_force(self, candidate: Candidate, shape: Array, displacement: Array) -> Array:
        """See `Response.unit_force`."""
        solid = candidate.material(shape, self.poisson_ratio, 1.0)
        try:
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                mode = REFERRED.get(self.mode, self.mode)
                return homogeneous_area(self.shape, mode, displacement, solid)
        except ArithmeticError:  # no equilibrium at these numbers
            return np.full(len(displacement), np.nan)
