"""Torsion of a bonded cylinder against Rivlin."""

import numpy as np
import pytest

import modes
from softsample.errors import InputError
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.meshing.sample import ideal_hexes

RADIUS = 0.5 * modes.TURNED.length


@pytest.fixture(scope="module")
def runs():
    return {n: modes.turned(n) for n in (10, 20)}


def test_torque_and_axial_force_are_those_of_rivlin(runs):
    run = runs[20]
    torque, axial = modes.rivlin(run.displacement)
    np.testing.assert_allclose(RADIUS * run.force, torque, rtol=1e-3, atol=1e-9)
    np.testing.assert_allclose(run.force_vector[10:, 2], axial[10:], rtol=3e-3)
    assert np.abs(run.platen_force + run.base_force).max() < 5e-3 * run.force.max()


def test_the_torque_converges_with_the_element_size(runs):
    """Measured: 0.087 and 0.025 % off."""
    errors = [
        abs(1.0 - RADIUS * run.force[-1] / modes.rivlin(run.displacement)[0][-1])
        for run in runs.values()
    ]
    assert errors[0] < 1.5e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.3)


def test_energy_goes_into_strain(runs):
    """The torque does the work: force along the rim times its displacement."""
    assert runs[10].energy["imbalance"] < 1e-3
    assert runs[10].energy["work"] == pytest.approx(
        np.trapezoid(runs[10].force, runs[10].displacement), rel=0.02
    )


def test_ends_that_slide_turn_nothing():
    mesh = ideal_hexes(modes.TURNED, RADIUS / 4)
    with pytest.raises(InputError, match="would turn on a sample in torsion; choose bonded"):
        mode_boundary(mesh, "torsion", mesh.glued(0.0), ContactSettings(), "sliding")
