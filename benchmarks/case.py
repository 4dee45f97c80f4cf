"""The nominal cuboid of the study that all benchmarks and solver comparisons share."""

from collections.abc import Callable

import numpy as np

from machine import best_cpu_seconds
from softsample.constitutive.laws import LAWS
from softsample.constitutive.material import Material, Term
from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.boundary import Boundary, ContactSettings, glued_boundary, platen_boundary
from softsample.fem.denormals import flushed_denormals
from softsample.fem.explicit import JACOBI_SWEEPS, ExplicitModel, SolverSettings, _March
from softsample.fem.forces import internal_force
from softsample.fem.schedule import Schedule
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.mesh import HexMesh
from softsample.protocol import History

EDGES = 23e-3, 20e-3, 13e-3
"""Length, width and height [m]."""

TRAVEL = {"tension": 3.25e-3, "compression": 3.9e-3, "shear": 3.9e-3, "contact": 3.9e-3}
"""Travel of the platen [m]; `contact` is compression by a platen that meets the top."""

MATERIAL = OgdenMaterial((1196.8, 113.1), (-8.0, 16.0), 0.49)


def cuboid(size: float) -> HexMesh:
    """The cuboid in elements of `size` [m]."""
    return mesh_cuboid(*EDGES, size)


def boundary_of(mesh: HexMesh, mode: str) -> Boundary:
    """What holds the cuboid in a mode of `TRAVEL`."""
    if mode == "contact":
        return platen_boundary(mesh, ContactSettings())
    return glued_boundary(mesh, mode, mesh.glued(0.0))


def law_materials() -> dict[str, Material]:
    """The modulus of the case in each elastic law alone, in the solid of fibres, and in a sum."""
    mu, nu = MATERIAL.shear_modulus, MATERIAL.poisson_ratio
    defaults = {name: tuple(p.default for p in law.shape) for name, law in LAWS.items()}
    fibres = Term("fibre", mu, defaults["fibre"])
    alone = {
        name: Material((Term(name, mu, shape),), nu)
        for name, shape in defaults.items()
        if name != "fibre"
    }
    return {
        **alone,
        "ogden": OgdenMaterial((mu,), (-7.3,), nu),
        "fibre": alone["neo_hooke"].plus(fibres),
    }


def rates(
    size: float,
    precision: str,
    spectral: bool = False,
    repeats: int = 8,
    material: Material = MATERIAL,
) -> dict[str, float]:
    """Elements per CPU second of one thread, the best of some repeats.

    `element_steps_per_cpu_s` counts whole time steps (element forces, platens, motion of the
    nodes), `element_forces_per_cpu_s` the element forces alone; `spectral`: by eigenvalues, for
    even exponents too.
    """
    mesh = cuboid(size)
    model = ExplicitModel(mesh, SolverSettings(precision=precision))
    schedule = Schedule(History.ramp(TRAVEL["tension"]), 0.1)
    loading = _March(model, material, boundary_of(mesh, "tension"), schedule, None)
    if spectral:
        loading.solid = loading.solid._replace(sweeps=JACOBI_SWEEPS[precision])
    dt = 0.5 * loading._critical_step()
    steps = max(10, 300_000 // len(mesh.hexes))
    slices = iter(dt * (steps * np.arange(repeats)[:, None] + np.arange(steps + 1)))
    with flushed_denormals():
        loading._advance(np.array([0.0, 0.0]), dt)
        whole = best_cpu_seconds(lambda: loading._advance(next(slices), dt), repeats) / steps
        forces = best_cpu_seconds(_forces(loading, steps), repeats) / steps
    return {
        "element_steps_per_cpu_s": len(mesh.hexes) / whole,
        "element_forces_per_cpu_s": len(mesh.hexes) / forces,
    }


def _forces(loading: _March, steps: int) -> Callable[[], None]:
    """The element forces of some time steps."""
    motion, state = loading.motion, loading.motion.state
    none = np.empty((2, 0)), motion.viscous

    def work() -> None:
        for _ in range(steps):
            internal_force(
                motion.u, loading.elements, loading.solid, *none, motion.force, state, False, None
            )

    return work
