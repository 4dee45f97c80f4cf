"""How the elastic force changes with the model: one run of the changed model per effect."""

import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from softsample.arrays import Array
from softsample.constitutive.homogeneous import fibre_force
from softsample.constitutive.material import Material
from softsample.constitutive.ogden import Fibres, OgdenMaterial, unit_modulus
from softsample.errors import SimulationError, TooFarError
from softsample.fem.boundary import Boundary, mode_boundary, platen_boundary
from softsample.fem.explicit import ExplicitModel, Run
from softsample.meshing.bond import partial_bond
from softsample.protocol import DIRECTIONS, History, is_homogeneous
from softsample.response.changes import (
    LAW,
    LESS,
    MANY,
    NEARER,
    NORMAL,
    OF_MANY,
    PRESSED,
    PRESSED_ELSEWHERE,
    elsewhere,
    lower_ratio,
    table_of_changes,
)
from softsample.response.pieces import INNER, MechanicalTest, MeshedSample, PerturbationSettings
from softsample.response.unit import (
    REACHED,
    Pace,
    Progress,
    check_stands,
    homogeneous_area,
    paced,
)
from softsample.shapes import IdealShape

LOG = logging.getLogger(__name__)

MARGIN = 1.05
"""Runs go this much further than the record, for effects that shift the travel."""

CYCLE_PACE = 3.0
"""Loading time of a run that comes back, over that of the others. Its loop is a small difference of
two large forces: at their pace up to a quarter of it was inertia, at a third of it 2 %."""


FIBRES = {
    "x": (1.0, 0.0, 0.0),
    "z": (0.0, 0.0, 1.0),
    "ahead": (1.0, 0.0, 1.0),
    "behind": (-1.0, 0.0, 1.0),
}
"""Directions of fibres; shear goes along x. It does nothing to those that lie in it, and in an
axial test both diagonals are alike, so that each test has three of these runs, and three with many
fibres if directions of the material are stated."""

EXPONENTS, APART = (-35.0, -20.0, 2.0, 25.0, 40.0), 3.0
"""Exponents of the runs of single terms; one as near as that to one of the model's is left out."""

TILTS = {"x": (1.0, 0.0), "minus_x": (-1.0, 0.0), "y": (0.0, 1.0), "minus_y": (0.0, -1.0)}
"""Axes about which the platen is turned."""

STEPS = {
    **dict.fromkeys((f"fibres_{name}" for name in FIBRES), "fibre_ratio"),
    **dict.fromkeys((f"platen_tilt_{way}" for way in TILTS), "tilt_deg"),
    "partial_bond_ahead": "missing_bond",
    "partial_bond_behind": "missing_bond",
    "partial_bond_beside": "missing_bond",
    "boundary_shift": "shift_mm",
    PRESSED: "precompression_mm",
    PRESSED_ELSEWHERE: "precompression_mm",
}
"""Which setting is the step of a perturbation, for those that have one."""


def perturbations_of(
    geometry: str,
    shape: IdealShape,
    mesh_shifted: Callable[[float], MeshedSample],
    test: MechanicalTest,
    progress: Progress | None = None,
) -> pd.DataFrame:
    """File of the changes by all perturbations, in closed form where the response is.

    In closed form they are computed at two modulus fractions, else at that of the material.

    Parameters
    ----------
    geometry : str
        `real` or `ideal`.
    mesh_shifted, test, progress
        As of `simulate_perturbations`.
    """
    if geometry == "ideal" and is_homogeneous(test.mode, test.ends):
        at_both = [(r, *homogeneous_perturbations(shape, test.at_fraction(r))) for r in INNER]
        tables = [table_of_changes(test.mode, *found) for found in at_both]
        return pd.concat(tables, ignore_index=True)
    found = simulate_perturbations(mesh_shifted, test, progress, turn=test.travel)
    return table_of_changes(test.mode, test.material.mu1_fraction, *found)


def simulate_perturbations(
    mesh_shifted: Callable[[float], MeshedSample],
    test: MechanicalTest,
    progress: Progress | None = None,
    turn: float | None = None,
) -> tuple[Array, Mapping[str, Array]]:
    """Change of the force per modulus by each perturbation of the model.

    Parameters
    ----------
    mesh_shifted : callable
        Meshes the sample with its surface moved out by a length [m].
    test : MechanicalTest
        What is done to it.
    progress : callable, optional
        Told what is computed and the finished part.
    turn : float, optional
        Where the platen turns in the run that comes back [m]: where the response ends that the
        changes are for; by default the end of the displacements.

    Returns
    -------
    displacement : (n,) float64
        Displacements of the platen [m].
    changes : dict of (n,) float64
        Change of the force along the displacement per shear modulus [m2]; names as the effects
        use them, with `_normal` behind them those of the force along z, if the test has it.
        Where a setting is the step, they are for its default, which the effects know.
        `platen_friction_0.15_loop` is what the force with this friction is more on unloading.
        `law_2` is no change, but the force of a single term of exponent 2, see `_law_runs`.
        A changed model that elements do not stand is left out, and all are if the model itself
        does not come through: an effect without its change is no candidate.
    """
    material = test.material
    sample, larger = mesh_shifted(0.0), mesh_shifted(1e-3 * test.steps.shift_mm)
    model, shifted = sample.model(test.solver), larger.model(test.solver)
    boundary = test.held(sample)
    pace = _base(model, test, boundary)
    if pace is None:
        return np.linspace(0.0, test.travel, test.solver.curve_points + 1), {}
    base, reach = _forces(pace.run, test), float(pace.run.displacement[-1])

    def force(on: ExplicitModel, of: Material, held: Boundary) -> Array:
        return _forces(on.run(of, held, reach, loading_time=pace.loading_time), test)

    todo: dict[str, Callable[[], Array]] = {
        name: lambda changed=changed: force(model, changed, boundary)  # type: ignore[misc]
        for name, changed in changed_materials(test).items()
    }
    todo["boundary_shift"] = lambda: force(shifted, material, test.held(larger))
    for name, held in changed_boundaries(sample, test).items():
        todo[name] = lambda held=held: force(model, material, held)  # type: ignore[misc]
    changes = {}
    for done, (name, run) in enumerate(todo.items()):
        if progress is not None:
            progress(name, done / len(todo))
        with _left_out(name):
            changes[name] = (run() - base) / material.shear_modulus
    if lower_ratio(LESS[1]) not in changes:
        nearer = replace(material, poisson_ratio=material.poisson_ratio - NEARER)
        with _left_out(name := lower_ratio(NEARER)):
            changes[name] = (force(model, nearer, boundary) - base) / material.shear_modulus
    if test.mode == "compression" and test.platen_contact.friction is None:
        with _left_out("platen_friction"):
            changes |= _friction_changes(model, sample, test, pace, min(turn or reach, reach))
    if test.mode == "shear":
        with _left_out(PRESSED):
            changes |= _pressed_changes(model, test, boundary, pace)
    changes |= _law_runs(model, test, boundary, pace)
    return pace.run.displacement, _by_channel(changes, test.steps)


@contextmanager
def _left_out(name: str) -> Iterator[None]:
    """Goes on without a change whose simulation fails."""
    try:
        yield
    except SimulationError as error:
        LOG.warning("%s is left out: %s", name, error)


def _base(model: ExplicitModel, test: MechanicalTest, boundary: Boundary) -> Pace | None:
    """The model as far as its elements stand it; none if they do not."""
    for part in (MARGIN, *REACHED):
        try:
            return paced(model, test.material, boundary, part * test.travel)
        except TooFarError as error:
            LOG.warning("ends before %.0f %% of the record: %s", 100.0 * part, error)
        except SimulationError as error:
            LOG.warning("no changed models: %s", error)
            return None
    return None


def homogeneous_perturbations(
    shape: IdealShape, test: MechanicalTest
) -> tuple[Array, Mapping[str, Array]]:
    """The same in closed form for an ideal shape with sliding ends: material and size.

    Fibres only where directions are stated, and not in the normal force.
    """
    travel = np.linspace(0.0, test.travel, test.solver.curve_points + 1)

    def area(of: IdealShape, solid: Material) -> Array:
        channels = (False, True) if test.normal else (False,)
        return np.stack(
            [homogeneous_area(of, test.mode, travel, solid, normal=n) for n in channels], axis=1
        )

    base = area(shape, test.material)
    changed = changed_materials(test).items()
    changes = {name: area(shape, of) - base for name, of in changed if of.isotropic}
    if test.many_fibres and not test.normal:
        strain, modulus = travel / shape.height, test.material.shear_modulus
        for name, of in changed:
            if not of.isotropic:
                stress = fibre_force(test.mode, strain, of.terms[-1], modulus)
                changes[name] = (shape.area * stress / modulus)[:, None]
    changes["boundary_shift"] = area(shape.grown(1e-3 * test.steps.shift_mm), test.material) - base
    return travel, _by_channel(changes, test.steps)


def _forces(run: Run, test: MechanicalTest) -> Array:
    """Forces (n, 1) or (n, 2) of a run [N]: along its displacement, and along z if wanted."""
    columns = [run.force, run.force_vector[:, 2]] if test.normal else [run.force]
    return np.stack(columns, axis=1)


def _by_channel(changes: Mapping[str, Array], steps: PerturbationSettings) -> dict[str, Array]:
    """Changes (n, c) by default steps as columns; `NORMAL` ends names of the force along z."""
    names = ("", NORMAL)
    return {
        f"{name}{names[channel]}": column
        for name, change in changes.items()
        for channel, column in enumerate((change * _to_default(name, steps)).T)
    }


def _friction_changes(
    model: ExplicitModel, sample: MeshedSample, test: MechanicalTest, pace: Pace, turn: float
) -> dict[str, Array]:
    """Change of the force per modulus by a platen that slips, and its loop."""
    history = History(np.array([0.0, 1.0, 2.0]), np.array([0.0, turn, 0.0]))
    changes = {}
    for friction in test.steps.frictions:
        cycle = model.run(
            test.material,
            platen_boundary(sample.mesh, replace(test.contact, friction=friction)),
            history,
            loading_time=CYCLE_PACE * pace.loading_time,
        )
        found = _cycle_changes(cycle.displacement, cycle.force, pace.run)
        for part, change in zip(("", "_loop"), found, strict=True):
            per_modulus = change[:, None] / test.material.shear_modulus
            changes[f"platen_friction_{friction:g}{part}"] = per_modulus
    return changes


def _to_default(perturbation: str, settings: PerturbationSettings) -> float:
    """Default step of a perturbation over that of the settings."""
    step = STEPS.get(perturbation)
    return getattr(PerturbationSettings, step) / getattr(settings, step) if step else 1.0


def _law_runs(
    model: ExplicitModel, test: MechanicalTest, boundary: Boundary, pace: Pace
) -> dict[str, Array]:
    """Forces per modulus of single terms as far as elements stand them, not finite from there on.

    One that crushes them in half of the displacement is left out.
    """
    material, grid, found = test.material, pace.run.displacement, {}
    modulus, nu = material.shear_modulus, material.poisson_ratio
    for alpha in EXPONENTS:
        if min(abs(alpha - a) for a in material.alpha) < APART:
            continue
        solid = OgdenMaterial((modulus,), (alpha,), nu)
        for part in REACHED:
            try:
                run = model.run(solid, boundary, part * grid[-1], loading_time=pace.loading_time)
                check_stands(run)
            except TooFarError:
                continue
            columns = (_forces(run, test) / modulus).T
            there = [np.interp(grid, run.displacement, force, right=np.nan) for force in columns]
            found[f"{LAW}{alpha:g}"] = np.stack(there, axis=1)
            break
    return found


def _pressed_changes(
    model: ExplicitModel, test: MechanicalTest, boundary: Boundary, pace: Pace
) -> dict[str, Array]:
    """Change of the force per modulus of a bonded sample that is held at a depth meanwhile.

    What it is depends on the exponents so much that it is simulated at another fraction as well.
    """
    down = replace(boundary, direction=np.array(DIRECTIONS["compression"]))
    depth, material = 1e-3 * test.steps.precompression_mm, test.material
    slow, there = CYCLE_PACE * pace.loading_time, float(pace.run.displacement[-1])
    start = model.run(material, down, depth, loading_time=slow).displacement_field

    def force(of: Material, place: Array | None) -> Array:
        run = model.run(of, boundary, there, loading_time=pace.loading_time, start=place)
        return _forces(run, test)

    modulus = material.shear_modulus
    fraction = elsewhere(material.mu1_fraction)
    another = unit_modulus(fraction, material.alpha, material.poisson_ratio, modulus)
    changes = {}
    for name, of, base in (
        (PRESSED, material, _forces(pace.run, test)),
        (PRESSED_ELSEWHERE, another, force(another, None)),
    ):
        pressed = force(of, start)
        changes[name] = (pressed - pressed[0] - base) / modulus
    return changes


def _cycle_changes(cycle: Array, force: Array, stuck: Run) -> tuple[Array, Array]:
    """Changes (n,) [N] by friction while loading, and from there to unloading.

    Parameters
    ----------
    cycle, force : (m,) float64
        Displacement [m] and force of a run with friction, there and back in equal steps.
    stuck : Run
        The run that sticks; changes do not go on beyond the turn.
    """
    turn = len(cycle) // 2
    loading = cycle[: turn + 1]
    there, back = force[: turn + 1], force[turn:][::-1]
    rubbing = there - np.interp(loading, stuck.displacement, stuck.force)
    grid = stuck.displacement
    return np.interp(grid, loading, rubbing), np.interp(grid, loading, back - there)


def changed_materials(test: MechanicalTest) -> dict[str, Material]:
    """Materials that differ in one thing, by the name of the perturbation."""
    material, steps = test.material, test.steps
    nu = material.poisson_ratio
    ratios = {"": steps.fibre_ratio, **({OF_MANY: MANY} if test.many_fibres else {})}
    return {
        **{lower_ratio(less): replace(material, poisson_ratio=nu - less) for less in LESS},
        **{
            f"fibres_{name}{end}": material.plus(
                Fibres(ratio * material.shear_modulus, FIBRES[name])
            )
            for name in ("z", "ahead", "behind" if test.mode == "shear" else "x")
            for end, ratio in ratios.items()
        },
    }


def changed_boundaries(sample: MeshedSample, test: MechanicalTest) -> dict[str, Boundary]:
    """Boundary conditions that differ in one thing, by the name of the perturbation."""
    if test.mode == "compression":
        return _changed_platens(sample, test)
    if test.mode in ("tension", "shear", "pure_shear") and test.ends == "bonded":
        return _changed_bonds(sample, test)
    return {}


def _changed_bonds(sample: MeshedSample, test: MechanicalTest) -> dict[str, Boundary]:
    """Bonds that lack a strip at one side."""
    kept = partial(partial_bond, sample.mesh, sample.glued, 1.0 - test.steps.missing_bond)
    # towards where it peels; the bond is missing on the other side
    peels = {"ahead": (-1.0, 0.0), "behind": (1.0, 0.0), "beside": (0.0, 1.0)}
    return {
        f"partial_bond_{side}": mode_boundary(sample.mesh, test.mode, kept(way), test.contact)
        for side, way in peels.items()
    }


def _changed_platens(sample: MeshedSample, test: MechanicalTest) -> dict[str, Boundary]:
    """Platens that are tilted, or slip."""
    contact = test.platen_contact
    tilts = {
        f"platen_tilt_{way}": platen_boundary(
            sample.mesh, contact, tilt_deg=(x * test.steps.tilt_deg, y * test.steps.tilt_deg)
        )
        for way, (x, y) in TILTS.items()
    }
    if contact.friction is not None:  # slip is a share of the way from sticking
        return tilts
    slip = replace(contact, friction=0.0)
    return {**tilts, "platen_slip": platen_boundary(sample.mesh, slip)}
