"""Calibration as the study did it: a simulation for every evaluation of the objective."""

import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from softsample.arrays import Array
from softsample.calibration.group import GroupCurves
from softsample.constitutive.ogden import unit_modulus
from softsample.fem.boundary import Boundary, Ends
from softsample.fem.explicit import ExplicitModel, Run
from softsample.fem.setup import Sample, set_up


@dataclass(eq=False)
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
    bounds : tuple of float
        Range of the `mu1_fraction`.
    """

    model: ExplicitModel
    boundary: Boundary
    travel: float
    loading_time: float
    alpha: tuple[float, float]
    poisson_ratio: float
    bounds: tuple[float, float]
    cpu_s: float = 0.0
    _runs: dict[tuple[float, float], Run] = field(default_factory=dict)

    @property
    def simulations(self) -> int:
        """Number of simulations so far."""
        return len(self._runs)

    def force(self, displacement: Array, /, mu: float, fraction: float) -> Array:
        """Force along the travel [N]; the same material is simulated once."""
        if (mu, fraction) not in self._runs:
            before = time.process_time()
            solid = unit_modulus(fraction, self.alpha, self.poisson_ratio, mu)
            self._runs[mu, fraction] = self.model.run(
                solid, self.boundary, self.travel, loading_time=self.loading_time
            )
            self.cpu_s += time.process_time() - before
        run = self._runs[mu, fraction]
        return np.interp(displacement, run.displacement, run.force)


def simulated_curves(
    group: GroupCurves,
    samples: Iterable[Sample],
    ends: Iterable[Ends],
    reports: Iterable[Mapping[str, Any]],
    sections: Mapping[str, Any],
) -> dict[str, SimulatedCurves]:
    """Curves of the samples of a group that are calibrated.

    Parameters
    ----------
    samples, ends, reports : iterable
        Of every sample of the group: mesh with its data, ends as of `softsample.fem.setup.set_up`,
        report of the unit-modulus response.
    sections : mapping
        `solver`, `contact` and `material` of the config.
    """
    law, found = sections["material"], {}
    each = zip(group.modes.items(), samples, ends, reports, strict=True)
    for (name, mode), sample, held, report in each:
        if name in group.measured:
            found[name] = SimulatedCurves(
                *set_up(sample, mode, sections, held),
                group.measured[name].travel,
                report["loading_time_s"],
                law["alpha"],
                law["poisson_ratio"],
                group.responses[name].bounds,
            )
    return found


def simulation_costs(simulated: Mapping[str, SimulatedCurves]) -> dict[str, float]:
    """Number of simulations so far, and their CPU time [s]."""
    return {
        "simulations": sum(curves.simulations for curves in simulated.values()),
        "simulations_cpu_s": sum(curves.cpu_s for curves in simulated.values()),
    }
