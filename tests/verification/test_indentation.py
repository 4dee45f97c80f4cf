"""Indentation of a large block against Hertz' ball and Boussinesq's punch."""

import numpy as np
import pytest

from softsample.constitutive.ogden import OgdenMaterial
from softsample.errors import InputError
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.graded import graded_hexes
from softsample.meshing.sample import indented_hexes
from softsample.shapes import IdealShape, Indenter

RADIUS = 3e-3
MU = 1000.0


def modulus(nu):
    """Young's modulus over 1 - nu^2 [Pa]."""
    return 2.0 * MU * (1.0 + nu) / (1.0 - nu**2)


def indented(mesh, indenter, depth, nu, loading_time=0.6):
    held = mode_boundary(mesh, "indentation", mesh.glued(0.0), ContactSettings(), indenter)
    solid = OgdenMaterial((MU,), (2.0,), nu)
    model = ExplicitModel(mesh, SolverSettings())
    return model.run(solid, held, depth, loading_time=loading_time)


@pytest.mark.parametrize(
    ("kind", "nu", "apart"),
    [pytest.param("cylinder", 0.3, 0.03, marks=pytest.mark.long), ("cuboid", 0.3, 0.03)],
)
def test_a_smooth_ball_is_that_of_hertz(kind, nu, apart):
    """H. Hertz, J. reine angew. Math. 92 (1882) 156, doi:10.1515/crll.1882.92.156."""
    shape = IdealShape(kind, 80e-3, 80e-3, 60e-3)
    mesh = graded_hexes(shape, RADIUS / 16, 0.4 * RADIUS, 8e-3)
    run = indented(mesh, Indenter("sphere", RADIUS, "sliding"), RADIUS / 20, nu)
    exact = 4.0 / 3.0 * modulus(nu) * np.sqrt(RADIUS) * run.displacement**1.5
    late = slice(2 * len(exact) // 3, None)  # before, few nodes are in contact
    np.testing.assert_allclose(run.force[late], exact[late], rtol=apart)
    touching = run.held == 2
    reach = np.hypot(*mesh.points[touching, :2].T).max()
    assert reach == pytest.approx(np.sqrt(RADIUS * RADIUS / 20), abs=RADIUS / 16)
    away = mesh.points[touching] + run.displacement_field[touching]
    centre = [0.0, 0.0, shape.height + RADIUS - RADIUS / 20]
    np.testing.assert_allclose(np.linalg.norm(away - centre, axis=1), RADIUS, rtol=1e-6)


@pytest.mark.long
def test_a_smooth_flat_punch_is_that_of_boussinesq():
    """F = 2 E a d / (1 - nu^2); I. N. Sneddon 1965, doi:10.1016/0020-7225(65)90019-4."""
    shape, nu = IdealShape("cylinder", 100e-3, 100e-3, 80e-3), 0.3
    punch = Indenter("punch", RADIUS, "sliding")
    run = indented(indented_hexes(shape, 2e-3, punch), punch, RADIUS / 50, nu, 0.3)
    exact = 2.0 * modulus(nu) * RADIUS * run.displacement
    np.testing.assert_allclose(run.force[-10:], exact[-10:], rtol=0.03)


def test_a_ball_without_slip_is_stiffer_and_the_more_so_in_a_thin_layer():
    mesh = indented_hexes(IdealShape("cylinder", 30e-3, 30e-3, 20e-3), 4e-3,
                          Indenter("sphere", RADIUS), 2.0)  # fmt: skip
    thin = indented_hexes(IdealShape("cylinder", 30e-3, 30e-3, 3e-3), 1e-3,
                          Indenter("sphere", RADIUS), 2.0)  # fmt: skip
    depth, nu = RADIUS / 10, 0.3
    smooth, rough, layer = (
        indented(on, Indenter("sphere", RADIUS, ends), depth, nu, 0.3).force[-1]
        for on, ends in ((mesh, "sliding"), (mesh, "bonded"), (thin, "bonded"))
    )
    assert 1.0 < rough / smooth < 1.1
    assert layer > 1.3 * rough


def test_an_indenter_belongs_to_indentation_alone():
    mesh = indented_hexes(IdealShape("cuboid", 12e-3, 12e-3, 9e-3), 2e-3, Indenter("punch", 2e-3))
    for mode, ends in (("compression", Indenter("punch", 2e-3)), ("indentation", "bonded")):
        with pytest.raises(InputError, match="an indenter belongs to indentation alone"):
            mode_boundary(mesh, mode, mesh.glued(0.0), ContactSettings(), ends)
    with pytest.raises(InputError, match="indenter 'cone' is unknown; give sphere or punch"):
        Indenter("cone", 1e-3)
    with pytest.raises(InputError, match="radius of the indenter is 0 mm"):
        Indenter("sphere", 0.0)
