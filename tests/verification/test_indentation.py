"""Indentation of a large block against Hertz' ball and Boussinesq's punch."""

import numpy as np
import pytest

import modes
from softsample.errors import InputError
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.meshing.sample import indented_hexes
from softsample.shapes import IdealShape, Indenter

RADIUS = modes.BALL


@pytest.mark.parametrize("kind", [pytest.param("cylinder", marks=pytest.mark.long), "cuboid"])
def test_a_smooth_ball_is_that_of_hertz(kind):
    """H. Hertz, J. reine angew. Math. 92 (1882) 156, doi:10.1515/crll.1882.92.156."""
    mesh = modes.large(kind)
    run, exact = modes.smooth_ball(mesh)
    assert np.abs(modes.late(run, exact)).max() < 0.03
    touching = run.held == 2
    reach = np.hypot(*mesh.points[touching, :2].T).max()
    assert reach == pytest.approx(np.sqrt(RADIUS * RADIUS / 20), abs=RADIUS / 16)
    away = mesh.points[touching] + run.displacement_field[touching]
    centre = [0.0, 0.0, mesh.points[:, 2].max() + RADIUS - RADIUS / 20]
    np.testing.assert_allclose(np.linalg.norm(away - centre, axis=1), RADIUS, rtol=1e-6)


@pytest.mark.parametrize("layer", modes.LAYERS)
def test_a_ball_on_a_thin_layer_is_that_of_dimitriadis(layer):
    """Measured: 2.3 and 1.1 %; the layer alone makes 24 and 34 %."""
    run, exact = modes.ball_on_layer(*layer)
    assert np.abs(modes.late(run, exact)).max() < 0.03


@pytest.mark.long
def test_a_smooth_flat_punch_is_that_of_boussinesq():
    assert np.abs(modes.late(*modes.smooth_punch())).max() < 0.03


def test_a_ball_without_slip_is_stiffer_and_the_more_so_in_a_thin_layer():
    mesh = indented_hexes(IdealShape("cylinder", 30e-3, 30e-3, 20e-3), 4e-3,
                          Indenter("sphere", RADIUS), 2.0)  # fmt: skip
    thin = indented_hexes(IdealShape("cylinder", 30e-3, 30e-3, 3e-3), 1e-3,
                          Indenter("sphere", RADIUS), 2.0)  # fmt: skip
    depth, nu = RADIUS / 10, 0.3
    smooth, rough, layer = (
        modes.indented(on, Indenter("sphere", RADIUS, ends), depth, nu, 0.3).force[-1]
        for on, ends in ((mesh, "sliding"), (mesh, "bonded"), (thin, "bonded"))
    )
    assert 1.0 < rough / smooth < 1.1
    assert layer > 1.3 * rough


def test_an_indenter_belongs_to_indentation_alone():
    mesh = indented_hexes(IdealShape("cuboid", 12e-3, 12e-3, 9e-3), 2e-3, Indenter("flat", 2e-3))
    for mode, ends in (("compression", Indenter("flat", 2e-3)), ("indentation", "bonded")):
        with pytest.raises(InputError, match="an indenter belongs to indentation alone"):
            mode_boundary(mesh, mode, mesh.glued(0.0), ContactSettings(), ends)
    with pytest.raises(InputError, match="indenter 'cone' is unknown; give sphere or flat"):
        Indenter("cone", 1e-3)
    with pytest.raises(InputError, match="radius of the indenter is 0 mm"):
        Indenter("sphere", 0.0)
