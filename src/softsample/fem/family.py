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
    """A solver time for a loading and what is known of its error.

    Parameters
    ----------
    loading_time : float
        Solver time of a ramp for the reference modulus [s].
    slow_time : float
        Solver time of the slow run that errors are measured against [s], at least twice a pilot's.
    slow : Run
        That run.
    """

    loading_time: float
    slow_time: float
    slow: Run

    def error_percent(self, run: Run) -> float:
        """Error of the curve of a run in `loading_time` [% of the peak force].

        Errors fall with the square of the loading time, so that the difference from the slow run
        is that part of the error which the slow run does not share.
        """
        if self.loading_time >= self.slow_time:
            raise ValueError("the slow run must be slower than the run it judges")
        shared = (self.loading_time / self.slow_time) ** 2
        return 100.0 * curve_difference(run, self.slow) / (1.0 - shared)


def curve_difference(run: Run, reference: Run) -> float:
    """Largest difference of two force curves over the peak of the second."""
    difference = np.abs(run.force - reference.force).max()
    return float(difference / np.abs(reference.force).max())


def find_pace(run: Callable[[float], Run], settings: SolverSettings) -> Pace:
    """The shortest loading time whose curve is within ``curve_error_percent`` of a slow test.

    A pilot in T and one in 2 T give the error e(T) = 4/3 of their difference; it falls with 1/T^2.
    The time is chosen with a margin of a fifth, and within the span of the pilots, so that the
    slow one bounds the error of what follows.

    Parameters
    ----------
    run : callable
        Simulation in a given loading time [s].
    settings : SolverSettings
        First guess of the loading time, wanted error.

    Raises
    ------
    SimulationError
        If sixteen times the first guess is still too fast.
    """
    time = settings.loading_time_s
    fast = run(time)
    for _ in range(5):
        slow = run(2.0 * time)
        error = 100.0 * 4.0 / 3.0 * curve_difference(fast, slow)
        wanted = time * np.sqrt(error / (0.8 * settings.curve_error_percent))
        if wanted < 1.8 * time:
            return Pace(float(max(wanted, 0.5 * time)), 2.0 * time, slow)
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

    share = 3.0 / (3.0 + len(fractions))
    pace = find_pace(
        lambda duration: simulate(middle, duration, "loading time", 0.0, share), model.settings
    )
    spent = sum(seconds)
    seconds.clear()
    steps = np.linspace(share, 1.0, len(fractions) + 1)
    runs = [
        simulate(
            float(r), pace.loading_time, f"run {k + 1} of {len(fractions)} (mu1/mu = {r:.3f})",
            steps[k], steps[k + 1],
        )
        for k, r in enumerate(fractions)
    ]  # fmt: skip
    reports = [
        {"mu1_fraction": float(r), **run_report(run), "cpu_s": round(cpu, 2)}
        for r, run, cpu in zip(fractions, runs, seconds, strict=True)
    ]
    return _curves(fractions, runs, modulus), {
        "error_bound_percent": pace.error_percent(runs[list(fractions).index(middle)]),
        "loading_time_s": pace.loading_time,
        "elements": len(model.mesh.hexes),
        "travel_mm": 1e3 * travel,
        "cpu_s": round(spent + sum(seconds), 2),
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
