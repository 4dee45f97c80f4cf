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
from softsample.fem.explicit import ExplicitModel, Run

Array = NDArray[np.float64]
Test = tuple[ExplicitModel, Boundary]


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


TINY = 1e-9
"""Error [%] below which two curves are the same."""

PILOT_SHARE = 0.6
"""Part of the wanted error that pilots on a coarser mesh may show. With elements of twice the size
their errors were 0.6 to 1.4 times those of the mesh (five samples, three modes)."""


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


def curve_difference(force: Array, reference: Array) -> float:
    """Largest difference of two curves of force over the peak of the second."""
    return float(np.abs(force - reference).max() / np.abs(reference).max())


def pace_error(fast: Run, slow: Run, ratio: float) -> float:
    """Error of the faster of two curves [% of peak], its loading time `ratio` of the other's.

    Errors fall with the square of the loading time, so that the slow run shares ``ratio^2`` of it.
    """
    return 100.0 * curve_difference(fast.force, slow.force) / (1.0 - ratio**2)


def find_pace(simulate: Callable[[float], Run], shortest: float, wanted: float) -> Pace:
    """The shortest loading time whose curve has an error of `wanted` % of peak at most.

    T starts at `shortest`, or where a first run comes through, and is doubled until curves in T and
    2 T differ by little enough. How the error fell in the last doubling says how much shorter than
    T the loading may be; the run in that time is judged by the slow one again, and T is kept if it
    was too fast after all.

    Parameters
    ----------
    simulate : callable
        Simulation in a given loading time [s].
    shortest : float
        First loading time [s]; if it is long enough, half of it is the shortest result.
    wanted : float
        Largest error [% of the peak force].

    Raises
    ------
    SimulationError
        If 32 times the first loading time is still too fast, or elements are crushed in 4 times
        `shortest`.
    """
    time, fast = _first_run(simulate, shortest)
    before = None
    for _ in range(6):
        slow = simulate(2.0 * time)
        error = pace_error(fast, slow, 0.5)
        if error <= wanted:
            order = 2.0 if before is None else max(1.0, np.log2(before / max(error, TINY)))
            better = time * max(0.5, float((error / (0.8 * wanted)) ** (1.0 / order)))
            run = _attempt(simulate, better) if better < time else None
            if run:
                shorter = Pace(better, run, pace_error(run, slow, 0.5 * better / time))
                if shorter.error_percent <= wanted:
                    return shorter
            return Pace(time, fast, error)
        time, fast, before = 2.0 * time, slow, error
    raise SimulationError(
        f"inertia still changes the force by {error:.2g} % of its peak in a loading time of "
        f"{0.5 * time:.2g} s; raise solver: curve_error_percent or loading_time_s"
    )


def _first_run(simulate: Callable[[float], Run], shortest: float) -> tuple[float, Run]:
    """The first of `shortest` and its next two doubles [s] in which a run comes through."""
    for loading_time in (shortest, 2.0 * shortest):
        if run := _attempt(simulate, loading_time):
            return loading_time, run
    return 4.0 * shortest, simulate(4.0 * shortest)


def _attempt(simulate: Callable[[float], Run], loading_time: float) -> Run | None:
    """A run that may be too fast: inertia can crush elements."""
    try:
        return simulate(loading_time)
    except SimulationError:
        return None


def simulate_family(
    model: ExplicitModel,
    boundary: Boundary,
    travel: float,
    fractions: Sequence[float],
    alpha: Sequence[float],
    poisson_ratio: float,
    progress: Callable[[str, float], None] | None = None,
    pilot: Test | None = None,
) -> tuple[dict[str, Array], dict[str, Any]]:
    """Force per modulus against displacement for each mixture, and how exact it is.

    The loading time is found with the middle mixture, at best on a coarser mesh: inertia is that
    of the shape, and errors were within a factor of `PILOT_SHARE` of those of the mesh itself.

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
    pilot : tuple, optional
        Coarser mesh of the same sample and what holds it, on which the loading time is found.

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

    def simulate(
        test: Test, r: float, loading_time: float, label: str, start: float, end: float
    ) -> Run:
        before = time.process_time()
        try:
            run = test[0].run(
                unit_modulus(r, alpha, poisson_ratio, modulus),
                test[1],
                travel,
                loading_time=loading_time,
                progress=progress and (lambda done: progress(label, start + done * (end - start))),
            )
        except SimulationError as error:
            raise SimulationError(f"{label}: {error}") from error
        seconds.append(time.process_time() - before)
        return run

    part = PILOT_SHARE if pilot else 1.0
    share = 1.0 / (3.0 + len(fractions))
    pace = find_pace(
        lambda duration: simulate(
            pilot or (model, boundary), middle, duration, "loading time", 0.0, share
        ),
        model.settings.loading_time_s,
        part * model.settings.curve_error_percent,
    )
    steps = np.linspace(share, 1.0, len(fractions) + 1)
    found = {}
    for k, r in enumerate(fractions):
        label = f"run {k + 1} of {len(fractions)} (mu1/mu = {r:.3f})"
        run = simulate((model, boundary), r, pace.loading_time, label, steps[k], steps[k + 1])
        found[r] = run, seconds[-1]
    runs = [found[r][0] for r in fractions]
    reports = [
        {"mu1_fraction": float(r), **run_report(found[r][0]), "cpu_s": round(found[r][1], 2)}
        for r in fractions
    ]
    return _curves(fractions, runs, modulus), {
        "error_bound_percent": pace.error_percent / part,
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
