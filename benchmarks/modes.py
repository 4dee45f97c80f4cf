"""Torsion, bonded discs and indentation against published solutions."""

import numpy as np

from known import hertz_force
from softsample.arrays import Array
from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.fem.explicit import ExplicitModel, Run, SolverSettings
from softsample.meshing.graded import graded_hexes
from softsample.meshing.mesh import HexMesh
from softsample.meshing.sample import ideal_hexes, indented_hexes
from softsample.shapes import IdealShape, Indenter

MU = 1000.0
"""Shear modulus of all of them [Pa]."""

TURNED = IdealShape("cylinder", 20e-3, 20e-3, 6e-3)
"""The cylinder in torsion."""

BALL, LATE = 3e-3, 2.0 / 3.0
"""Radius of indenters [m], and the part of the travel before which few nodes are in contact."""

RITZ = {(1.0, 0.49): 1.5075, (1.0, 0.499): 1.5455, (2.5, 0.49): 3.3753, (2.5, 0.499): 3.9706}
"""Apparent over Young's modulus of a bonded disc by radius over height and Poisson's ratio, from
an axisymmetric Ritz solution of 12 x 12 functions, which is an upper bound."""


def solid(poisson_ratio: float) -> OgdenMaterial:
    """Neo-Hookean solid."""
    return OgdenMaterial((MU,), (2.0,), poisson_ratio)


def turned(along_radius: int) -> Run:
    """A bonded cylinder turned until its rim is sheared by 0.3, in elements of a part of R."""
    mesh = ideal_hexes(TURNED, 0.5 * TURNED.length / along_radius)
    held = mode_boundary(mesh, "torsion", mesh.glued(0.0), ContactSettings())
    model = ExplicitModel(mesh, SolverSettings(curve_points=20))
    return model.run(solid(0.499), held, 0.3 * TURNED.height, loading_time=0.4)


def rivlin(travel: Array) -> tuple[Array, Array]:
    """Torque [N m] and axial force [N] of an incompressible cylinder whose rim travels (n,) [m].

    R. S. Rivlin, Phil. Trans. R. Soc. A 242 (1949) 173, doi:10.1098/rsta.1949.0009.
    """
    radius, height = 0.5 * TURNED.length, TURNED.height
    angle = travel / radius
    torque = np.pi * MU * radius**4 * angle / (2.0 * height)
    return torque, -np.pi * MU * angle**2 * radius**4 / (4.0 * height**2)


def disc(radius_over_height: float, poisson_ratio: float, along_height: int = 8) -> float:
    """Apparent over Young's modulus of a bonded disc, pulled by 0.2 %."""
    height, strain = 4e-3, 2e-3
    radius = radius_over_height * height
    mesh = ideal_hexes(
        IdealShape("cylinder", 2.0 * radius, 2.0 * radius, height), height / along_height
    )
    held = mode_boundary(mesh, "tension", mesh.glued(0.0), ContactSettings())
    model = ExplicitModel(mesh, SolverSettings(curve_points=4))
    run = model.run(solid(poisson_ratio), held, strain * height, loading_time=0.2)
    apparent = run.force[-1] / (np.pi * radius**2 * strain)
    return float(apparent / (2.0 * MU * (1.0 + poisson_ratio)))


def indented(
    mesh: HexMesh, indenter: Indenter, depth: float, poisson_ratio: float, loading_time: float = 0.6
) -> Run:
    """A sample on a bonded base, indented by `depth` [m]."""
    held = mode_boundary(mesh, "indentation", mesh.glued(0.0), ContactSettings(), indenter)
    model = ExplicitModel(mesh, SolverSettings())
    return model.run(solid(poisson_ratio), held, depth, loading_time=loading_time)


def large(kind: str) -> HexMesh:
    """A cuboid or cylinder that is large for the ball."""
    return graded_hexes(IdealShape(kind, 80e-3, 80e-3, 60e-3), BALL / 16, 0.4 * BALL, 8e-3)


def smooth_ball(mesh: HexMesh) -> tuple[Run, Array]:
    """A smooth ball pressed into a large sample by a twentieth of its radius, and Hertz' force."""
    run = indented(mesh, Indenter("sphere", BALL, "sliding"), BALL / 20, 0.3)
    return run, hertz_force(solid(0.3), BALL, np.inf, run.displacement)


def ball_on_layer(height: float, depth: float, fine: float) -> tuple[Run, Array]:
    """The same on a thin layer [m] that is bonded to its base, and Hertz' force with a series."""
    mesh = graded_hexes(IdealShape("cylinder", 12e-3, 12e-3, height), fine, 0.3 * BALL, 2e-3)
    run = indented(mesh, Indenter("sphere", BALL, "sliding"), depth, 0.3)
    return run, hertz_force(solid(0.3), BALL, height, run.displacement)


LAYERS = ((3e-3, BALL / 20, BALL / 16), (1e-3, BALL / 100, BALL / 40))
"""Height, depth and smallest element [m] of the thin layers."""


def smooth_punch() -> tuple[Run, Array]:
    """A smooth flat punch on a large cylinder, and F = 2 E a d / (1 - nu^2).

    I. N. Sneddon, Int. J. Eng. Sci. 3 (1965) 47, doi:10.1016/0020-7225(65)90019-4.
    """
    shape, punch = IdealShape("cylinder", 100e-3, 100e-3, 80e-3), Indenter("flat", BALL, "sliding")
    run = indented(indented_hexes(shape, 2e-3, punch), punch, BALL / 50, 0.3, 0.3)
    young = 2.0 * MU * (1.0 + 0.3)
    return run, 2.0 * young / (1.0 - 0.3**2) * BALL * run.displacement


def late(run: Run, exact: Array) -> Array:
    """Force over the exact one, less one, where it is more than a few nodes that touch (k,)."""
    part = slice(int(LATE * len(exact)), None)
    return np.asarray(run.force[part] / exact[part] - 1.0)
