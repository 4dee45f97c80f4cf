"""The force on a sample by one call, for scripts: any shape, test and elastic law."""

import numpy as np

from softsample.arrays import Array
from softsample.constitutive.material import Material
from softsample.fem.boundary import BONDED, ContactSettings, Ends, mode_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.mesh import HexMesh
from softsample.meshing.sample import ideal_hexes
from softsample.protocol import is_homogeneous
from softsample.response.unit import homogeneous_area, paced
from softsample.shapes import IdealShape, Indenter


def force_curve(
    sample: IdealShape | HexMesh,
    mode: str,
    material: Material,
    travel: float,
    *,
    ends: Ends = BONDED,
    elements_across: int = 12,
    settings: SolverSettings | None = None,
) -> tuple[Array, Array]:
    """Force that a test takes, by finite elements or, where the deformation is uniform, exactly.

    Parameters
    ----------
    sample : IdealShape or HexMesh
        Cuboid, cylinder, or a mesh [m] whose base lies on z = 0; the platen is glued to the
        highest nodes of a mesh.
    mode : str
        `tension`, `compression`, `shear`, and of shapes `pure_shear`, `confined_compression`,
        `torsion` or `indentation`.
    material : Material
        Its elastic law.
    travel : float
        Displacement of the platen [m], > 0.
    ends : str, float or Indenter
        `bonded`, `sliding`, a Coulomb coefficient, or what indents the sample.
    elements_across : int
        Elements along the shortest extent of an ideal shape; below an indenter they are as fine
        as those of a study.
    settings : SolverSettings, optional
        Of the explicit solver; the loading time is found so that inertia changes the force by
        `curve_error_percent` of its peak at most.

    Returns
    -------
    displacement, force : (n,) float64
        Along the platen's travel from zero [m], and the force [N] with it, both >= 0 as a rule.

    Raises
    ------
    InputError
        If the mode cannot be tested with such ends.
    SimulationError
        If elements are crushed, or the loading is too fast at 32 times the first loading time.
    """
    given = settings or SolverSettings()
    if isinstance(sample, IdealShape) and is_homogeneous(mode, ends):
        displacement = np.linspace(0.0, travel, given.curve_points + 1)
        area = homogeneous_area(sample, mode, displacement, material)
        return displacement, material.shear_modulus * area
    mesh = sample
    if isinstance(mesh, IdealShape):
        size = mesh.smallest / elements_across
        mesh = ideal_hexes(mesh, size, ends if isinstance(ends, Indenter) else None)
    model = ExplicitModel(mesh, given)
    held = mode_boundary(mesh, mode, mesh.glued(0.0), ContactSettings(), ends)
    run = paced(model, material, held, travel).run
    return run.displacement, run.force
