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

    The error of the finite loading time is bounded by a run at half speed with the middle
    mixture: inertia errors fall with the square of the loading time, so four thirds of the
    difference estimate the error itself.

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
    jobs = [(float(r), 1.0) for r in fractions] + [(float(middle), 2.0)]
    shares = np.cumsum([0.0] + [slowdown for _, slowdown in jobs])
    runs: list[Run] = []
    seconds: list[float] = []
    for k, (r, slowdown) in enumerate(jobs):
        material = unit_modulus(r, alpha, poisson_ratio, modulus)
        label = f"run {k + 1} of {len(jobs)} (mu1/mu = {r:.3f})"

        def tell(done: float, k: int = k, label: str = label) -> None:
            if progress is not None:
                progress(label, (shares[k] + done * (shares[k + 1] - shares[k])) / shares[-1])

        start = time.process_time()
        try:
            runs.append(model.run(material, boundary, travel, slowdown=slowdown, progress=tell))
        except SimulationError as error:
            raise SimulationError(f"{label}: {error}") from error
        seconds.append(time.process_time() - start)
    reports = [
        {"mu1_fraction": r, "slowdown": slowdown, **run_report(run), "cpu_s": round(cpu, 2)}
        for (r, slowdown), run, cpu in zip(jobs, runs, seconds, strict=True)
    ]
    doubled, same = runs[-1], runs[list(fractions).index(middle)]
    bound = 4.0 / 3.0 * np.abs(doubled.force - same.force).max() / np.abs(doubled.force).max()
    return _curves(fractions, runs[:-1], modulus), {
        "error_bound_percent": 100.0 * float(bound),
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
