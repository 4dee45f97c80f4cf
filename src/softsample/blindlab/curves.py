"""Elastic curves of a body, plain and changed, by runs of the solver on the laboratory's mesh."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from softsample.arrays import Array, Ids
from softsample.blindlab.bodies import ALPHA, MODES, POISSON, PRESSED, Body
from softsample.blindlab.phantom import random_cuboid, signed_distance
from softsample.constitutive.material import Material
from softsample.constitutive.ogden import Fibres, OgdenMaterial, unit_modulus
from softsample.fem.boundary import Boundary, ContactSettings, mode_boundary, platen_boundary
from softsample.fem.explicit import ExplicitModel, Run, SolverSettings
from softsample.meshing.bond import partial_bond
from softsample.meshing.sample import SampleMesh, mesh_ideal, mesh_real
from softsample.protocol import History
from softsample.units import MM

Planted = tuple[str, float, str, Run]
"""Name of a curve, multiple of its size, mode, and the run that it is of."""

MODULUS = 1000.0  # Pa, of the runs
MARGIN = 1.08  # runs go on beyond the stroke, for shifts of the travel
SLOWER = 4.0  # a run that comes back, for its loop is a small difference
SLIP_BACK = "slip_back"  # the curve of the slippery platen on unloading
GRID = 0.5  # mm, of signed distances
PRELOAD = 1.0  # mm


def imperfect_mesh(body: Body, size_mm: float, bumps: float = 1.0) -> SampleMesh:
    """Mesh of the phantom behind an imperfect body."""
    shape = random_cuboid(body.number, bumps)
    half, top = shape.box[:2], shape.box[2]
    axes = [np.arange(a, b, GRID) for a, b in ((-half[0], half[0]), (-half[1], half[1]), (-2, top))]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    distance = signed_distance(shape, points.reshape(-1, 3)).reshape(points.shape[:3])
    return mesh_real(MM * distance, MM * points[0, 0, 0], MM * GRID, MM * size_mm, MM * PRELOAD)


def cuboid_mesh(body: Body, size_mm: float, shift_mm: float = 0.0) -> SampleMesh:
    """Mesh of a cuboid, its free faces moved out by a length; the base stays."""
    return mesh_ideal(body.shape.grown(MM * shift_mm), MM * size_mm)


def tissue(body: Body) -> Material:
    """Two-term solid of a body; the modulus only sets the scale."""
    return unit_modulus(body.mixture, ALPHA, POISSON, MODULUS)


def glued(mesh: SampleMesh) -> Ids:
    """Nodes glued to the moving platen in tension and shear."""
    return np.flatnonzero(mesh.point_data["glued"])


def planted_curves(
    body: Body, sizes: Sequence[float], size_mm: float, solver: SolverSettings
) -> pd.DataFrame:
    """Curves that records are made of.

    Parameters
    ----------
    body : Body
        The sample.
    sizes : sequence of float
        Multiples of an effect's nominal size.
    size_mm : float
        Edge of the elements [mm].
    solver : SolverSettings
        Its `loading_time_s` is used as it is.

    Returns
    -------
    DataFrame
        `curve` (`plain`, or the name of a change), `size` (its multiple), `mode`,
        `displacement_mm` >= 0 along the travel, `area_mm2` = force over shear modulus.
    """
    runs = _imperfect_runs if body.imperfect else _cuboid_runs
    rows = [
        {"curve": name, "size": size, "mode": mode, "displacement_mm": u, "area_mm2": area}
        for name, size, mode, run in runs(body, sizes, size_mm, solver)
        for u, area in zip(run.displacement / MM, run.force / MODULUS / MM**2, strict=True)
    ]
    return pd.DataFrame(rows)


def _imperfect_runs(
    body: Body, sizes: Sequence[float], size_mm: float, solver: SolverSettings
) -> Iterator[Planted]:
    """The phantom with bumps of each size; `plain` is not needed."""
    for size in sizes:
        mesh = imperfect_mesh(body, size_mm, bumps=size)
        model = ExplicitModel(mesh.mesh, solver)
        for mode in MODES:
            held = mode_boundary(mesh.mesh, mode, glued(mesh), ContactSettings())
            run = model.run(tissue(body), held, MARGIN * MM * body.stroke(mode))
            yield "shape", size, mode, run


def _cuboid_runs(
    body: Body, sizes: Sequence[float], size_mm: float, solver: SolverSettings
) -> Iterator[Planted]:
    mesh = cuboid_mesh(body, size_mm)
    model = ExplicitModel(mesh.mesh, solver)
    for mode in MODES:
        reach = MARGIN * MM * body.stroke(mode)
        plain = mode_boundary(mesh.mesh, mode, glued(mesh), ContactSettings())
        yield "plain", 0.0, mode, model.run(tissue(body), plain, reach)
        for size in sizes:
            for name, material in _materials(body, size).items():
                yield name, size, mode, model.run(material, plain, reach)
            for name, held in _boundaries(body, mesh, mode, size).items():
                run = model.run(tissue(body), held, reach)
                yield name, size, mode, run
                if name == "slip":
                    more = _more_on_unloading(model, body, held, run.displacement, solver)
                    yield SLIP_BACK, size, mode, replace(run, force=run.force + more)
            if mode == "shear":
                run = _from_pressed(model, body, plain, reach, PRESSED * size, solver)
                yield "pressed", size, mode, run
            for name, changed, on in _samples(body, mesh, size_mm, size, solver):
                held = mode_boundary(on.mesh, mode, glued(on), ContactSettings())
                yield name, size, mode, changed.run(tissue(body), held, reach)


def _more_on_unloading(
    model: ExplicitModel, body: Body, held: Boundary, travel: Array, solver: SolverSettings
) -> Array:
    """What the force is more on unloading from compression, by travel; friction turns round."""
    stroke = MM * body.stroke("compression")
    there_and_back = History(np.array([0.0, 1.0, 2.0]), np.array([0.0, stroke, 0.0]))
    cycle = model.run(
        tissue(body), held, there_and_back, loading_time=SLOWER * solver.loading_time_s
    )
    turn = len(cycle.displacement) // 2
    loop = cycle.force[turn:][::-1] - cycle.force[: turn + 1]
    return np.interp(travel, cycle.displacement[: turn + 1], loop)


def _from_pressed(
    model: ExplicitModel,
    body: Body,
    held: Boundary,
    reach: float,
    depth: float,
    solver: SolverSettings,
) -> Run:
    """Shear of a sample whose platen stays a depth [mm] below where it was glued."""
    down = replace(held, direction=np.array([0.0, 0.0, -1.0]))
    slow = SLOWER * solver.loading_time_s
    start = model.run(tissue(body), down, MM * depth, loading_time=slow).displacement_field
    return model.run(tissue(body), held, reach, start=start)


def _materials(body: Body, size: float) -> dict[str, Material]:
    """Changed solids: compressibility, a third term, fibres along a slanted axis."""
    plain = tissue(body)
    third = 0.033 * size * MODULUS
    slant = np.radians(15.0)
    x, y = body.toward()
    axis = (float(np.sin(slant)) * x, float(np.sin(slant)) * y, float(np.cos(slant)))
    return {
        "poisson": replace(plain, poisson_ratio=POISSON - 0.01 * size),
        "third_term": OgdenMaterial((*plain.mu, third), (*plain.alpha, -15.0), POISSON),
        "fibres": plain.plus(Fibres(0.04 * size * MODULUS, axis)),
    }


def _boundaries(body: Body, mesh: SampleMesh, mode: str, size: float) -> dict[str, Boundary]:
    """Changed boundary conditions: a strip without glue; a tilted, or a slippery platen."""
    if mode != "compression":
        left = partial_bond(mesh.mesh, glued(mesh), 1.0 - 0.125 * size, body.toward())
        return {"strip": mode_boundary(mesh.mesh, mode, left, ContactSettings())}
    x, y = body.toward()
    slippery = ContactSettings(friction=0.5 / (1.0 + size))
    return {
        "tilt": platen_boundary(mesh.mesh, ContactSettings(), tilt_deg=(size * x, size * y)),
        "slip": platen_boundary(mesh.mesh, slippery),
    }


def _samples(
    body: Body, mesh: SampleMesh, size_mm: float, size: float, solver: SolverSettings
) -> Iterator[tuple[str, ExplicitModel, SampleMesh]]:
    """Changed samples: larger all round, and with a stiff inclusion."""
    larger = cuboid_mesh(body, size_mm, 0.1 * size)
    yield "larger", ExplicitModel(larger.mesh, solver), larger
    yield "inclusion", _with_inclusion(body, mesh, size, solver), mesh


def _with_inclusion(
    body: Body, mesh: SampleMesh, size: float, solver: SolverSettings
) -> ExplicitModel:
    """A ball in the upper half, off the axis, 1 + 5 times as stiff at size 1."""
    middle = mesh.mesh.points[mesh.mesh.hexes].mean(axis=1) / MM
    x, y = body.toward()
    centre = np.array([0.2 * body.length * x, 0.2 * body.width * y, 0.65 * body.height])
    inside = np.linalg.norm(middle - centre, axis=1) < 0.3 * body.height
    return ExplicitModel(mesh.mesh, solver, np.where(inside, 1.0 + 5.0 * size, 1.0))
