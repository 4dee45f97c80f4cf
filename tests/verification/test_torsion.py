"""Torsion of a bonded cylinder against Rivlin."""

import numpy as np
import pytest

from softsample.constitutive.ogden import OgdenMaterial
from softsample.errors import InputError
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.sample import ideal_hexes
from softsample.shapes import IdealShape

RADIUS, HEIGHT, MU = 10e-3, 6e-3, 1000.0
SHAPE = IdealShape("cylinder", 2.0 * RADIUS, 2.0 * RADIUS, HEIGHT)
SOLVER = SolverSettings(curve_points=20)


def turned(along_radius):
    """A neo-Hookean cylinder turned until its rim is sheared by 0.3."""
    mesh = ideal_hexes(SHAPE, RADIUS / along_radius)
    boundary = mode_boundary(mesh, "torsion", mesh.glued(0.0), ContactSettings())
    material = OgdenMaterial((MU,), (2.0,), 0.499)
    return ExplicitModel(mesh, SOLVER).run(material, boundary, 0.3 * HEIGHT, loading_time=0.2)


@pytest.fixture(scope="module")
def runs():
    return {n: turned(n) for n in (10, 20)}


def test_torque_and_axial_force_are_those_of_rivlin(runs):
    """T = pi mu R^4 t / (2 H), N = -pi mu t^2 R^4 / (4 H^2); R. S. Rivlin 1949,
    doi:10.1098/rsta.1949.0009."""
    run = runs[20]
    angle = run.displacement / RADIUS
    torque = np.pi * MU * RADIUS**4 * angle / (2.0 * HEIGHT)
    np.testing.assert_allclose(RADIUS * run.force, torque, rtol=1e-3, atol=1e-9)
    axial = -np.pi * MU * angle**2 * RADIUS**4 / (4.0 * HEIGHT**2)
    np.testing.assert_allclose(run.force_vector[10:, 2], axial[10:], rtol=4e-3)  # measured 0.0032
    assert np.abs(run.platen_force + run.base_force).max() < 5e-3 * run.force.max()


def test_the_torque_converges_with_the_element_size(runs):
    """Measured: 0.084 and 0.027 % off, order 1.65; the edges of the rim err the other way."""
    exact = np.pi * MU * RADIUS**3 * 0.3 / 2.0
    errors = [abs(1.0 - RADIUS * run.force[-1] / exact) for run in runs.values()]
    assert errors[0] < 1.5e-3
    assert np.log2(errors[0] / errors[1]) > 1.5


def test_energy_goes_into_strain(runs):
    """The torque does the work: force along the rim times its displacement."""
    assert runs[10].energy["imbalance"] < 1e-3
    assert runs[10].energy["work"] == pytest.approx(
        np.trapezoid(runs[10].force, runs[10].displacement), rel=0.02
    )


def test_ends_that_slide_turn_nothing():
    mesh = ideal_hexes(SHAPE, RADIUS / 4)
    with pytest.raises(InputError, match="would turn on a sample in torsion; choose bonded"):
        mode_boundary(mesh, "torsion", mesh.glued(0.0), ContactSettings(), "sliding")
