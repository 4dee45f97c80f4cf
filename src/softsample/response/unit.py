"""The builder of unit-modulus responses, from runs of the solver or in closed form.

Without body force the force is linear in the moduli at a fixed fraction, F(d; k mu) = k F(d; mu),
so that one run per modulus fraction mu1 / mu serves every modulus.
"""

import logging
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from softsample.arrays import Array
from softsample.constitutive.homogeneous import homogeneous_force, homogeneous_normal
from softsample.constitutive.material import Material
from softsample.constitutive.ogden import unit_modulus
from softsample.errors import SimulationError, TooFarError
from softsample.fem.boundary import Boundary
from softsample.fem.explicit import ExplicitModel, Run
from softsample.protocol import travel_sign
from softsample.shapes import IdealShape

Test = tuple[ExplicitModel, Boundary]
Progress = Callable[[str, float], None]
Response = tuple[dict[str, Array], dict[str, Any]]

HEIGHT = 13e-3
"""Height [m] of the samples that the shortest loading time of the settings is meant for."""

CLOSED_FORM = "closed form"
"""`method` of a response that was not simulated."""

REACHED = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5)
"""Parts of the platen displacement that are tried, the largest first: elements at the edge of a
bonded sample invert where the record goes very far."""


GIVES_WAY = 0.1
"""Fall of the force over its peak at which a response ends: elements have given way.

Bonded cylinders whose mesh folded at 80 % of a compression by 67 % fell by 63 and 94 %. Only there
does a solid itself soften, by 19 % in closed form (exponent -8 alone, Poisson's ratio 0.49)."""


@dataclass(frozen=True)
class ResponseSettings:
    """Mirrors config `family:`.

    Parameters
    ----------
    nodes : int
        Modulus fractions mu1 / mu that are computed, from 0 to 1: Chebyshev-Lobatto points in
        sqrt(1 - mu1/mu), where the force is smooth. Between 6 it is within 0.25 % of its peak,
        between 8 within 0.1 % (three samples, one of each mode, to their strains). With 6 the
        moduli of the cohort change by 0.1 %, but the diagnosis of one cuboid loses its cause.
    """

    nodes: int = 8


def modulus_fractions(settings: ResponseSettings) -> Array:
    """Ascending fractions mu1 / mu (nodes,) at which the curves are computed."""
    # ASSUME: both moduli are at least zero, so that mu1/mu lies between 0 and 1.
    root = 0.5 + 0.5 * np.cos(np.pi * np.arange(settings.nodes) / (settings.nodes - 1))
    return np.asarray(1.0 - root**2)


EXACT = modulus_fractions(ResponseSettings(nodes=64))
"""Modulus fractions of a response in closed form, which costs nothing.

Pulled to twice its length, a sample is stiffened a hundredfold by a thousandth of exponent 16:
between 8 fractions the force is up to 42 % off (stretch 2.2, exponents -8 and 16), between 64 less
than 1e-4 %; at three times its length 0.3 %.
"""

TINY = 1e-9
"""Error [%] below which two curves are the same."""

PRELIMINARY_SHARE = 0.6
"""Part of the wanted error that preliminary runs on a coarser mesh may show.

With elements of twice the size their errors were 0.6 to 1.4 times those of the mesh (five samples,
three modes)."""


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
    TooFarError
        If 32 times the first loading time is still too fast, as where a sample folds, or elements
        are crushed in 4 times `shortest`.
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
    raise TooFarError(
        f"inertia still changes the force by {error:.2g} % of its peak in a loading time of "
        f"{0.5 * time:.2g} s; raise solver: curve_error_percent or loading_time_s"
    )


def shortest_loading_time(model: ExplicitModel) -> float:
    """Loading time [s] from which the search for a good one sets out.

    Waves cross a small sample in less time. The search doubles, and so does this.
    """
    doublings = round(np.log2(model.mesh.highest / HEIGHT))
    return float(model.settings.loading_time_s * 2.0**doublings)


def paced(model: ExplicitModel, material: Material, boundary: Boundary, reach: float) -> Pace:
    """Loading time at which the model's curve to a travel [m] is as good as its settings ask."""
    return find_pace(
        lambda t: model.run(material, boundary, reach, loading_time=t),
        shortest_loading_time(model),
        model.settings.curve_error_percent,
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


def unit_runs(
    model: ExplicitModel,
    boundary: Boundary,
    travel: float,
    solids: Sequence[Material],
    loading_time: float,
    progress: Progress | None = None,
) -> Iterator[tuple[Run, float]]:
    """Runs of several unit-modulus solids in one test, each with its CPU time [s]."""
    for done, solid in enumerate(solids):
        label = f"run {done + 1} of {len(solids)} ({_named(solid)})"
        before = time.process_time()
        try:
            run = model.run(
                solid,
                boundary,
                travel,
                loading_time=loading_time,
                progress=progress and _part_of(progress, label, done, len(solids)),
            )
            check_stands(run)
        except SimulationError as error:
            raise type(error)(f"{label}: {error}") from error
        yield run, time.process_time() - before


def check_stands(run: Run) -> None:
    """Refuse a run whose force falls, as where a bonded sample folds at its edge."""
    highest = np.maximum.accumulate(run.force)
    fall = (highest - run.force) / max(float(highest[-1]), TINY)
    if fall.max() > GIVES_WAY:
        place = 1e3 * run.displacement[run.force[: fall.argmax()].argmax()]
        raise TooFarError(
            f"the force falls by {100.0 * fall.max():.0f} % of its peak beyond {place:.2f} mm of "
            "displacement: elements give way; use smaller elements, or a shorter part of the record"
        )


def _named(solid: Material) -> str:
    """What tells a solid from the others of a response: the modulus fraction, or its laws."""
    if solid.mu:
        return f"mu1/mu = {solid.mu1_fraction:.3f}"
    return " + ".join(term.law for term in solid.terms)


def _part_of(progress: Progress, label: str, done: int, of: int) -> Callable[[float], None]:
    return lambda fraction: progress(label, (done + fraction) / of)


def simulated_response(
    model: ExplicitModel,
    boundary: Boundary,
    travel: float,
    fractions: Sequence[float],
    alpha: Sequence[float],
    poisson_ratio: float,
    progress: Progress | None = None,
    preliminary: Test | None = None,
) -> Response:
    """Force per modulus against displacement for each modulus fraction, and how exact it is.

    The loading time is found with the middle fraction, at best on a coarser mesh: inertia is that
    of the shape, and errors agree with those of the mesh itself within `PRELIMINARY_SHARE`.

    Parameters
    ----------
    model, boundary, travel
        Mesh, what holds it, displacement of the platen [m].
    fractions : sequence of float
        mu1 / mu of each curve; 1 stands for the first term alone.
    alpha : sequence of float
        Exponents of the two terms.
    poisson_ratio : float
        Initial Poisson's ratio.
    progress : callable, optional
        Told what is being computed and the finished fraction of all runs.
    preliminary : tuple, optional
        Coarser mesh of the same sample and what holds it, on which the loading time is found.

    Returns
    -------
    curves : dict of (n_fractions * n_points,) float64
        `mu1_fraction`, `displacement` [m] along the travel (>= 0), `force`, `platen_force`,
        `base_force`, `normal_force` (along +z) per unit modulus [m2].
    report : dict
        Figures of every run, and `error_bound_percent` of the peak force.

    Raises
    ------
    TooFarError
        If elements do not stand the displacement, or the loading is too fast at 32 times the first
        loading time.
    """
    modulus, part = model.settings.reference_modulus_pa, PRELIMINARY_SHARE if preliminary else 1.0
    solids = [unit_modulus(r, alpha, poisson_ratio, modulus) for r in fractions]
    middle = solids[sorted(range(len(solids)), key=lambda k: fractions[k])[len(solids) // 2]]
    share, started = 3.0 / (3.0 + len(fractions)), time.process_time()
    searched, held = preliminary or (model, boundary)
    try:
        pace = find_pace(
            lambda duration: searched.run(
                middle,
                held,
                travel,
                loading_time=duration,
                progress=progress and (lambda done: progress("loading time", share * done)),
            ),
            shortest_loading_time(model),
            part * model.settings.curve_error_percent,
        )
    except SimulationError as error:
        raise type(error)(f"loading time: {error}") from error
    search_s = time.process_time() - started
    told = progress and (lambda label, done: progress(label, share + (1.0 - share) * done))
    runs = list(unit_runs(model, boundary, travel, solids, pace.loading_time, told))
    return _curves(fractions, [run for run, _ in runs], modulus), {
        "method": "finite elements",
        "error_bound_percent": pace.error_percent / part,
        "loading_time_s": pace.loading_time,
        "elements": len(model.mesh.hexes),
        "travel_mm": 1e3 * travel,
        "cpu_s": round(search_s + sum(seconds for _, seconds in runs), 2),
        "runs": [
            {"mu1_fraction": float(r), **run_report(run), "cpu_s": round(seconds, 2)}
            for r, (run, seconds) in zip(fractions, runs, strict=True)
        ],
    }


def as_far_as_elements_stand(simulate: Callable[[float], Response], travel: float) -> Response:
    """A response to the largest of the `REACHED` parts of a displacement [m] that comes through.

    Its report has that part as `reached`.

    Raises
    ------
    TooFarError
        If half of the displacement is too far.
    """
    for part in REACHED:
        try:
            curves, report = simulate(part * travel)
            return curves, {**report, "reached": part}
        except TooFarError as error:
            logging.getLogger(__name__).warning("ends before %.0f %%: %s", 100.0 * part, error)
            last = error
    raise type(last)(
        f"{last}; if the ends slide, or lie far apart as those of a strip, state ends: sliding, "
        "which an ideal shape needs no elements for"
    )


def homogeneous_response(
    shape: IdealShape,
    mode: str,
    travel: float,
    fractions: Sequence[float],
    alpha: Sequence[float],
    poisson_ratio: float,
    points: int,
) -> Response:
    """The same in closed form where sliding ends leave the deformation of an ideal shape uniform.

    Parameters
    ----------
    shape : IdealShape
        Cuboid or cylinder.
    mode, travel
        Of the test; displacement of the platen [m].
    fractions, alpha, poisson_ratio
        As of `simulated_response`.
    points : int
        Evenly spaced displacements, zero not counted.
    """
    displacement = np.linspace(0.0, travel, points + 1)
    parts = []
    for r in fractions:
        solid = unit_modulus(r, alpha, poisson_ratio, 1.0)
        force = homogeneous_area(shape, mode, displacement, solid)
        normal = homogeneous_area(shape, mode, displacement, solid, normal=True)
        parts.append((np.full(len(force), r), displacement, force, force, -force, normal))
    return _joined(parts), {
        "method": CLOSED_FORM,
        "error_bound_percent": 0.0,
        "travel_mm": 1e3 * travel,
        "reached": 1.0,
        "cpu_s": 0.0,
        "runs": [],
    }


def response_table(curves: dict[str, Array], mode: str) -> dict[str, Array]:
    """Columns of the file of a response, in mm and mm2, from those of a builder."""
    sign = travel_sign(mode)
    return {
        "mu1_fraction": curves["mu1_fraction"],
        "displacement_mm": sign * 1e3 * curves["displacement"],
        "force_per_mu_mm2": sign * 1e6 * curves["force"],
        "platen_force_per_mu_mm2": sign * 1e6 * curves["platen_force"],
        "base_force_per_mu_mm2": sign * 1e6 * curves["base_force"],
        "normal_force_per_mu_mm2": 1e6 * curves["normal_force"],
    }


def homogeneous_area(
    shape: IdealShape, mode: str, displacement: Array, solid: Material, normal: bool = False
) -> Array:
    """Force (n,) along the displacement [m], or along +z, over the shear modulus [m2]."""
    strain = displacement / shape.height
    if normal and mode == "shear":
        stress = homogeneous_normal(strain, solid)
    else:
        stress = homogeneous_force(mode, strain, solid)
        stress = stress * (travel_sign(mode) if normal else 1.0)
    return np.asarray(shape.area * stress / solid.shear_modulus)


COLUMNS = (
    "mu1_fraction", "displacement", "force", "platen_force", "base_force", "normal_force",
)  # fmt: skip


def _joined(parts: Iterable[tuple[Array, ...]]) -> dict[str, Array]:
    """The `COLUMNS` of several fractions, one after the other."""
    return dict(zip(COLUMNS, map(np.concatenate, zip(*parts, strict=True)), strict=True))


def _curves(fractions: Sequence[float], runs: list[Run], modulus: float) -> dict[str, Array]:
    return _joined(
        (
            np.full(len(run.displacement), float(r)),
            run.displacement,
            run.force / modulus,
            run.platen_force / modulus,
            run.base_force / modulus,
            run.force_vector[:, 2] / modulus,
        )
        for r, run in zip(fractions, runs, strict=True)
    )


def run_report(run: Run) -> dict[str, Any]:
    """Figures by which a run is judged; ratios dimensionless, percent of peak force."""
    peak = np.abs(run.force).max()
    difference = np.abs(run.platen_force + run.base_force).max()
    return {
        "steps": run.steps,
        "smallest_step_us": 1e6 * run.smallest_step_s,
        "energy_imbalance": run.energy["imbalance"],
        "hourglass_ratio": run.energy["hourglass_ratio"],
        "platen_against_base_percent": 100.0 * float(difference / peak),
    }
