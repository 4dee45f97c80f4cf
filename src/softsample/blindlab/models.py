"""The loop's own model of a body: runs on another mesh and at another mixture than the records."""

import numpy as np
import pandas as pd

from softsample.blindlab.bodies import ALPHA, MODES, POISSON, Body
from softsample.blindlab.curves import MM, MODULUS, cuboid_mesh, glued, imperfect_mesh
from softsample.constitutive.ogden import unit_modulus
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.fem.family import FamilySettings, family_fractions
from softsample.loop.inputs import MechanicalTest, MeshedSample, VariantSettings
from softsample.loop.variants import simulate_variants
from softsample.meshing.sample import SampleMesh


def calibrated(body: Body) -> float:
    """Mixture at which a calibration of a body might have ended."""
    return round(body.mixture, 1)


def model_curves(
    body: Body, size_mm: float, solver: SolverSettings, variants: VariantSettings
) -> pd.DataFrame:
    """Curves of the loop's model of a body: its cuboid, all mixtures, and the changed models.

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
        travel, changes = simulate_variants(
            lambda shift: MeshedSample.of(cuboid_mesh(body, size_mm, shift / MM)), test
        )
        curves = dict(changes)
        for fraction in family_fractions(FamilySettings()):
            curves[str(fraction)] = _curve(mesh, mode, float(fraction), 1e3 * travel, solver)
        if body.imperfect:
            real = imperfect_mesh(body, size_mm)
            curves["real_geometry"] = _curve(real, mode, r, 1e3 * travel, solver)
            curves["real_geometry"] -= _curve(mesh, mode, r, 1e3 * travel, solver)
        for name, area in curves.items():
            rows += [
                {"curve": name, "mode": mode, "displacement_mm": u, "area_mm2": a}
                for u, a in zip(travel / MM, area / MM**2, strict=True)
            ]
    return pd.DataFrame(rows)


def _curve(
    mesh: SampleMesh, mode: str, mixture: float, travel_mm: np.ndarray, solver: SolverSettings
) -> np.ndarray:
    """Force over modulus [m2] of one mixture at travels [mm]."""
    held = mode_boundary(mesh.mesh, mode, glued(mesh), ContactSettings())
    solid = unit_modulus(mixture, ALPHA, POISSON, MODULUS)
    run = ExplicitModel(mesh.mesh, solver).run(solid, held, MM * travel_mm[-1])
    return np.interp(travel_mm, run.displacement / MM, run.force) / MODULUS
