"""A sample's curves for all mixtures of two Ogden terms, from a few runs of unit modulus.

Without body force the force is linear in the moduli at a fixed ratio, F(d; k mu) = k F(d; mu), so
that one run per ratio r = mu1 / (mu1 + mu2) serves every modulus.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsample.constitutive.ogden import unit_modulus
from softsample.errors import SimulationError
from softsample.fem.boundary import Boundary
from softsample.fem.explicit import ExplicitModel, Run, SolverSettings

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FamilySettings:
    """Range of the mixtures; mirrors config `family:`.

    Parameters
    ----------
    mu1_fraction_min, mu1_fraction_max : float
        Bounds of r = mu1 / mu, dimensionless, within (0, 1).
    nodes : int
        Number of runs; Chebyshev-Lobatto points in sqrt(1 - r), where the force is smooth.
    """

    mu1_fraction_min: float = 0.02
    mu1_fraction_max: float = 0.98
    nodes: int = 6


def family_fractions(settings: FamilySettings) -> Array:
    """Ascending fractions r (nodes,) at which the curves are computed."""
    ends = np.sqrt(1.0 - np.array([settings.mu1_fraction_max, settings.mu1_fraction_min]))
    unit = np.cos(np.pi * np.arange(settings.nodes) / (settings.nodes - 1))
    root = ends.mean() + 0.5 * (ends[1] - ends[0]) * unit
    return 1.0 - root**2


@dataclass(frozen=True)
class Pace:
    """A solver time for a loading, and what its curve is worth.

    Parameters
    ----------
    loading_time : float
        Solver time of a ramp for the reference modulus [s].
    run : Run
        The simulation in this time.
    error_percent : float
        Error of its curve [% of the peak force], estimated from a slower one.
    """

    loading_time: float
    run: Run
    error_percent: float


def curve_difference(run: Run, reference: Run) -> float:
    """Largest difference of two force curves over the peak of the second."""
    difference = np.abs(run.force - reference.force).max()
    return float(difference / np.abs(reference.force).max())


def pace_error(fast: Run, slow: Run, ratio: float) -> float:
    """Error of the faster of two curves [% of peak], its loading time `ratio` of the other's.

    Errors fall with the square of the loading time, so that the slow run shares ``ratio^2`` of it.
    """
    return 100.0 * curve_difference(fast, slow) / (1.0 - ratio**2)


def find_pace(simulate: Callable[[float], Run], settings: SolverSettings) -> Pace:
    """The shortest loading time whose curve has an error of ``curve_error_percent`` at most.

    Pilots in T and 2 T give the error e(T), four thirds of their difference, and with its fall as
    1/T^2 a time with a margin of a fifth. The run in that time is judged by the slower pilot
    again; where the loading was too fast for the law, T is doubled.

    Parameters
    ----------
    simulate : callable
        Simulation in a given loading time [s].
    settings : SolverSettings
        First guess of the loading time, wanted error.

    Raises
    ------
    SimulationError
        If 32 times the first guess is still too fast.
    """
    time, wanted = settings.loading_time_s, settings.curve_error_percent
    fast = simulate(time)
    for _ in range(5):
        slow = simulate(2.0 * time)
        error = pace_error(fast, slow, 0.5)
        better = time * float(np.sqrt(error / (0.8 * wanted)))
        if better < 1.8 * time:
            better = max(better, 0.5 * time)
            run = simulate(better)
            error = pace_error(run, slow, better / (2.0 * time))
            if error <= wanted:
                return Pace(better, run, error)
        time, fast = 2.0 * time, slow
    raise SimulationError(
        f"inertia still changes the force by {error:.2g} % of its peak in a loading time of "
        f"{time:.2g} s; raise solver: curve_error_percent or loading_time_s"
    )


def simulate_family(
    model: ExplicitModel,
    boundary: Boundary,
    travel: float,
    fractions: Sequence[float],
    alpha: Sequence[float],
    poisson_ratio: float,
    progress: Callable[[str, float], None] | None = None,
) -> tuple[dict[str, Array], dict[str, Any]]:
    """Force per modulus against displacement for each mixture, and how exact it is.

    The loading time is found with the middle mixture and bounds the error of its curve.

    Parameters
    ----------
    model, boundary, travel
        Mesh, what holds it, travel of the platen [m].
    fractions : sequence of float
        r = mu1 / mu of each curve; 1 stands for the first term alone.
    alpha : sequence of float
        Exponents of the two terms.
    poisson_ratio : float
        Initial Poisson's ratio.
    progress : callable, optional
        Told what is being computed and the finished fraction of all runs.

    Returns
    -------
    curves : dict of (n_fractions * n_points,) float64
        `mu1_fraction`, `displacement` [m] along the travel (>= 0), `force`, `platen_force`,
        `base_force` per unit modulus [m2].
    report : dict
        Figures of every run and `error_bound_percent` of the peak force.
    """
    modulus = model.settings.reference_modulus_pa
    middle = sorted(fractions)[len(fractions) // 2]
    seconds: list[float] = []

    def simulate(r: float, loading_time: float, label: str, start: float, end: float) -> Run:
        before = time.process_time()
        try:
            run = model.run(
                unit_modulus(r, alpha, poisson_ratio, modulus),
                boundary,
                travel,
                loading_time=loading_time,
                progress=progress and (lambda done: progress(label, start + done * (end - start))),
            )
        except SimulationError as error:
            raise SimulationError(f"{label}: {error}") from error
        seconds.append(time.process_time() - before)
        return run

    order = [middle, *(r for r in fractions if r != middle)]
    share = 4.0 / (3.0 + len(fractions))
    pace = find_pace(
        lambda duration: simulate(middle, duration, "loading time", 0.0, share), model.settings
    )
    steps = np.linspace(share, 1.0, len(fractions))
    found = {middle: (pace.run, seconds[-1])}
    for k, r in enumerate(order[1:]):
        label = f"run {k + 2} of {len(fractions)} (mu1/mu = {r:.3f})"
        run = simulate(r, pace.loading_time, label, steps[k], steps[k + 1])
        found[r] = run, seconds[-1]
    runs = [found[r][0] for r in fractions]
    reports = [
        {"mu1_fraction": float(r), **run_report(found[r][0]), "cpu_s": round(found[r][1], 2)}
        for r in fractions
    ]
    return _curves(fractions, runs, modulus), {
        "error_bound_percent": pace.error_percent,
        "loading_time_s": pace.loading_time,
        "elements": len(model.mesh.hexes),
        "travel_mm": 1e3 * travel,
        "cpu_s": round(sum(seconds), 2),
        "runs": reports,
    }


def _curves(fractions: Sequence[float], runs: list[Run], modulus: float) -> dict[str, Array]:
    points = len(runs[0].displacement)
    columns = {
        name: np.concatenate([getattr(run, name) for run in runs]) / scale
        for name, scale in (
            ("displacement", 1.0),
            ("force", modulus),
            ("platen_force", modulus),
            ("base_force", modulus),
        )
    }
    return {"mu1_fraction": np.repeat(np.asarray(fractions, float), points), **columns}


def run_report(run: Run) -> dict[str, Any]:
    """Figures by which a run is judged; ratios dimensionless, percent of peak force."""
    peak = np.abs(run.force).max()
    difference = np.abs(run.platen_force + run.base_force).max()
    return {
        "steps": run.steps,
        "smallest_step_us": 1e6 * run.smallest_step_s,
        "energy_imbalance": run.energy["imbalance"],
        "hourglass_ratio": run.energy["hourglass_ratio"],
        "kinetic_ratio": run.energy["kinetic"] / run.energy["strain"],
        "platen_against_base_percent": 100.0 * float(difference / peak),
    }
