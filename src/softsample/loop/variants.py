"""How the elastic force changes with the model: one run of the changed model per effect."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from softsample.constitutive.ogden import Fibres, OgdenMaterial
from softsample.fem.boundary import Boundary, mode_boundary, platen_boundary
from softsample.fem.explicit import ExplicitModel, Run
from softsample.fem.family import Pace, find_pace
from softsample.loop.changes import PRESSED, PRESSED_ELSEWHERE, elsewhere
from softsample.loop.inputs import MechanicalTest, MeshedSample, VariantSettings
from softsample.meshing.bond import partial_bond
from softsample.protocol import DIRECTIONS, History

Array = NDArray[np.float64]

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
axial test both diagonals are alike, so that each test has three of these runs."""

TILTS = {"x": (1.0, 0.0), "minus_x": (-1.0, 0.0), "y": (0.0, 1.0), "minus_y": (0.0, -1.0)}
"""Axes about which the platen is turned."""

STEPS = {
    "alpha1": "exponent",
    "alpha2": "exponent",
    **dict.fromkeys((f"fibres_{name}" for name in FIBRES), "fibre_ratio"),
    **dict.fromkeys((f"platen_tilt_{way}" for way in TILTS), "tilt_deg"),
    "partial_bond_ahead": "missing_bond",
    "partial_bond_behind": "missing_bond",
    "partial_bond_beside": "missing_bond",
    "boundary_shift": "shift_mm",
    PRESSED: "precompression_mm",
    PRESSED_ELSEWHERE: "precompression_mm",
}
"""Which setting is the step of a variant, for those that have one."""


def simulate_variants(
    mesh_shifted: Callable[[float], MeshedSample],
    test: MechanicalTest,
    progress: Callable[[str, float], None] | None = None,
    normal: bool = False,
    turn: float | None = None,
) -> tuple[Array, Mapping[str, Array]]:
    """Change of the force per modulus by each variant of the model.

    Parameters
    ----------
    mesh_shifted : callable
        Meshes the sample with its surface moved out by a length [m].
    test : MechanicalTest
        What is done to it.
    progress : callable, optional
        Told what is computed and the finished part.
    normal : bool
        Whether the force along z is wanted instead of that along the travel.
    turn : float, optional
        Where the platen turns in the run that comes back [m]: where the family ends that the
        changes are for; by default the end of the travels.

    Returns
    -------
    displacement : (n,) float64
        Travels [m].
    changes : dict of (n,) float64
        Change of the force along the travel per shear modulus [m2]; names as the effects use them.
        Where a setting is the step, they are for its default, which the effects know.
        `platen_friction_0.15_loop` is what the force with this friction is more on the way back.
    """
    material, contact = test.material, test.contact
    sample, larger = mesh_shifted(0.0), mesh_shifted(1e-3 * test.variants.shift_mm)
    model, shifted = sample.model(test.solver), larger.model(test.solver)
    boundary = mode_boundary(sample.mesh, test.mode, sample.glued, contact)
    reach = MARGIN * test.travel
    pace = paced(model, material, boundary, reach)
    base = wanted_force(pace.run, normal)

    def force(on: ExplicitModel, of: OgdenMaterial, held: Boundary) -> Array:
        return wanted_force(on.run(of, held, reach, loading_time=pace.loading_time), normal)

    todo: dict[str, Callable[[], Array]] = {
        name: lambda changed=changed: force(model, changed, boundary)  # type: ignore[misc]
        for name, changed in changed_materials(test).items()
    }
    todo["boundary_shift"] = lambda: force(
        shifted,
        material,
        mode_boundary(larger.mesh, test.mode, larger.glued, contact),
    )
    for name, held in changed_boundaries(sample, test).items():
        todo[name] = lambda held=held: force(model, material, held)  # type: ignore[misc]
    changes = {}
    for done, (name, run) in enumerate(todo.items()):
        if progress is not None:
            progress(name, done / len(todo))
        changes[name] = (run() - base) / material.shear_modulus
    grid = pace.run.displacement
    if test.mode == "compression":
        there_and_back = History(np.array([0.0, 1.0, 2.0]), np.array([0.0, turn or reach, 0.0]))
        for friction in test.variants.frictions if test.contact.friction is None else ():
            cycle = model.run(
                material,
                platen_boundary(sample.mesh, replace(contact, friction=friction)),
                there_and_back,
                loading_time=CYCLE_PACE * pace.loading_time,
            )
            found = _cycle_changes(cycle.displacement, wanted_force(cycle, normal), grid, base)
            changes |= {
                f"platen_friction_{friction:g}{part}": change / material.shear_modulus
                for part, change in zip(("", "_loop"), found, strict=True)
            }
    if test.mode == "shear":
        depth = 1e-3 * test.variants.precompression_mm
        changes |= _pressed_changes(model, material, boundary, pace, depth, normal)
    return grid, {
        name: change * _to_default(name, test.variants) for name, change in changes.items()
    }


def _to_default(variant: str, settings: VariantSettings) -> float:
    """Default step of a variant over that of the settings."""
    step = STEPS.get(variant)
    return getattr(VariantSettings, step) / getattr(settings, step) if step else 1.0


def _pressed_changes(
    model: ExplicitModel,
    material: OgdenMaterial,
    boundary: Boundary,
    pace: Pace,
    depth: float,
    normal: bool,
) -> dict[str, Array]:
    """Change of the force per modulus of a glued sample that is held at a depth [m] meanwhile.

    What it is depends on the exponents so much that it is simulated at another mixture as well.
    """
    down = replace(boundary, direction=np.array(DIRECTIONS["compression"]))
    slow, there = CYCLE_PACE * pace.loading_time, float(pace.run.displacement[-1])
    start = model.run(material, down, depth, loading_time=slow).displacement_field

    def force(of: OgdenMaterial, place: Array | None) -> Array:
        run = model.run(of, boundary, there, loading_time=pace.loading_time, start=place)
        return wanted_force(run, normal)

    modulus = material.shear_modulus
    mixture = elsewhere(material.mu[0] / modulus)
    another = replace(material, mu=(mixture * modulus, (1.0 - mixture) * modulus))
    changes = {}
    for name, of, base in (
        (PRESSED, material, wanted_force(pace.run, normal)),
        (PRESSED_ELSEWHERE, another, force(another, None)),
    ):
        pressed = force(of, start)
        changes[name] = (pressed - pressed[0] - base) / modulus
    return changes


def _cycle_changes(cycle: Array, force: Array, travel: Array, stuck: Array) -> tuple[Array, Array]:
    """Changes (n,) [N] by friction while loading, and from there to the way back.

    Parameters
    ----------
    cycle, force : (m,) float64
        Travel [m] and force of a run with friction, there and back in equal steps.
    travel, stuck : (n,) float64
        Travel [m] and force of the run that sticks; changes do not go on beyond the turn.
    """
    turn = len(cycle) // 2
    loading = cycle[: turn + 1]
    there, back = force[: turn + 1], force[turn:][::-1]
    rubbing = there - np.interp(loading, travel, stuck)
    return np.interp(travel, loading, rubbing), np.interp(travel, loading, back - there)


def paced(model: ExplicitModel, material: OgdenMaterial, boundary: Boundary, reach: float) -> Pace:
    """Loading time at which the model's curve to a travel [m] is as good as its settings ask."""
    return find_pace(
        lambda t: model.run(material, boundary, reach, loading_time=t),
        model.settings.loading_time_s,
        model.settings.curve_error_percent,
    )


def wanted_force(run: Run, normal: bool) -> Array:
    """Force (n,) of a run [N] along z, or along its travel."""
    return np.asarray(run.force_vector[:, 2]) if normal else run.force


def changed_materials(test: MechanicalTest) -> dict[str, OgdenMaterial]:
    """Materials that differ in one thing, by the name of the variant."""
    material, steps = test.material, test.variants
    (first, second), k1 = material.alpha, steps.fibre_ratio * material.shear_modulus
    return {
        **{
            f"poisson_{less:g}_less": replace(material, poisson_ratio=material.poisson_ratio - less)
            for less in (0.02, 0.04)
        },
        "alpha1": replace(material, alpha=(first + steps.exponent, second)),
        "alpha2": replace(material, alpha=(first, second + steps.exponent)),
        **{
            f"fibres_{name}": replace(material, fibres=Fibres(k1, FIBRES[name]))
            for name in ("z", "ahead", "behind" if test.mode == "shear" else "x")
        },
    }


def changed_boundaries(sample: MeshedSample, test: MechanicalTest) -> dict[str, Boundary]:
    """Boundary conditions that differ in one thing, by the name of the variant."""
    contact, steps = test.contact, test.variants
    if test.mode != "compression":
        kept = partial(partial_bond, sample.mesh, sample.glued, 1.0 - steps.missing_bond)
        # towards where it peels; the glue is missing on the other side
        peels = {"ahead": (-1.0, 0.0), "behind": (1.0, 0.0), "beside": (0.0, 1.0)}
        return {
            f"partial_bond_{side}": mode_boundary(sample.mesh, test.mode, kept(way), contact)
            for side, way in peels.items()
        }
    tilts = {
        f"platen_tilt_{way}": platen_boundary(
            sample.mesh, contact, tilt_deg=(x * steps.tilt_deg, y * steps.tilt_deg)
        )
        for way, (x, y) in TILTS.items()
    }
    if contact.friction is not None:  # slip is a share of the way from sticking
        return tilts
    slip = replace(contact, friction=0.0)
    return {**tilts, "platen_slip": platen_boundary(sample.mesh, slip)}
