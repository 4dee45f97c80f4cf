"""Calibration as the study did it: a simulation for every evaluation of the objective."""

import time

import numpy as np
from numpy.typing import NDArray

from softsample.constitutive.ogden import unit_modulus
from softsample.fem.boundary import Boundary
from softsample.fem.explicit import ExplicitModel, Run

Array = NDArray[np.float64]


class SimulatedCurves:
    """Curves of one sample that are simulated when they are asked for, and counted.

    Parameters
    ----------
    model, boundary, travel
        Mesh, what holds it, travel of the platen [m].
    loading_time : float
        Solver time of a ramp for the reference modulus [s].
    alpha : sequence of two float
        Exponents.
    poisson_ratio : float
        Initial Poisson's ratio.
    fractions : (low, high)
        Range of r = mu1 / mu.
    """

    def __init__(
        self,
        model: ExplicitModel,
        boundary: Boundary,
        travel: float,
        loading_time: float,
        alpha: tuple[float, float],
        poisson_ratio: float,
        fractions: tuple[float, float],
    ) -> None:
        self._model, self._boundary, self._travel = model, boundary, travel
        self._loading_time, self._alpha, self._poisson_ratio = loading_time, alpha, poisson_ratio
        self.bounds = {"mu1_fraction": fractions}
        self._runs: dict[tuple[float, float], Run] = {}
        self.cpu_s = 0.0

    @property
    def simulations(self) -> int:
        """Number of simulations so far."""
        return len(self._runs)

    def force(self, displacement: Array, /, mu: float, fraction: float) -> Array:
        """Force along the travel [N]; the same material is simulated once."""
        if (mu, fraction) not in self._runs:
            before = time.process_time()
            self._runs[mu, fraction] = self._model.run(
                unit_modulus(fraction, self._alpha, self._poisson_ratio, mu),
                self._boundary,
                self._travel,
                loading_time=self._loading_time,
            )
            self.cpu_s += time.process_time() - before
        run = self._runs[mu, fraction]
        return np.interp(displacement, run.displacement, run.force)
