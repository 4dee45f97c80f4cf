"""The loop's own model of a body: runs on another mesh and at another mixture than the records."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from softsample.blindlab.bodies import ALPHA, MODES, POISSON, Body
from softsample.blindlab.curves import MODULUS, cuboid_mesh, glued, imperfect_mesh
from softsample.constitutive.ogden import unit_modulus
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.sample import SampleMesh
from softsample.response.perturbations import simulate_perturbations
from softsample.response.pieces import MechanicalTest, MeshedSample, PerturbationSettings
from softsample.response.unit import ResponseSettings, modulus_fractions, unit_runs
from softsample.units import MM


def calibrated(body: Body) -> float:
    """Mixture at which a calibration of a body might have ended."""
    return round(body.mixture, 1)


def model_curves(
    body: Body, size_mm: float, solver: SolverSettings, variants: PerturbationSettings
) -> pd.DataFrame:
    """Curves of the loop's model of a body: its cuboid, all fractions, and the changed models.

    Returns
    -------
    DataFrame
        `curve` (a mixture as a number, or the name of a change), `mode`, `displacement_mm`,
        `area_mm2` = force, or change of the force, over shear modulus.
    """
    r = calibrated(body)
    mesh = cuboid_mesh(body, size_mm)
    rows = []
    for mode in MODES:
        solid = unit_modulus(r, ALPHA, POISSON, MODULUS)
        test = MechanicalTest(
            mode, solid, MM * body.stroke(mode), ContactSettings(), solver, variants
        )
        travel, changes = simulate_perturbations(
            lambda shift: MeshedSample.of(cuboid_mesh(body, size_mm, shift / MM)), test
        )
        curves = dict(changes)
        fractions = [*map(float, modulus_fractions(ResponseSettings()))]
        found = _curves(mesh, mode, [*fractions, r], travel, solver)
        curves |= dict(zip(map(str, fractions), found, strict=False))
        if body.imperfect:
            (real,) = _curves(imperfect_mesh(body, size_mm), mode, [r], travel, solver)
            curves["real_geometry"] = real - found[-1]
        for name, area in curves.items():
            rows += [
                {"curve": name, "mode": mode, "displacement_mm": u, "area_mm2": a}
                for u, a in zip(travel / MM, area / MM**2, strict=True)
            ]
    return pd.DataFrame(rows)


def _curves(
    mesh: SampleMesh,
    mode: str,
    fractions: Sequence[float],
    travel: np.ndarray,
    solver: SolverSettings,
) -> list[np.ndarray]:
    """Force over modulus (n,) [m2] of each fraction at displacements [m]."""
    held = mode_boundary(mesh.mesh, mode, glued(mesh), ContactSettings())
    solids = [unit_modulus(r, ALPHA, POISSON, MODULUS) for r in fractions]
    model = ExplicitModel(mesh.mesh, solver)
    runs = unit_runs(model, held, travel[-1], solids, solver.loading_time_s)
    return [np.interp(travel, run.displacement, run.force) / MODULUS for run, _ in runs]
