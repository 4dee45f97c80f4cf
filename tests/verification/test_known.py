"""Whole runs against exact solutions, and the orders at which the solver converges to them."""

import os
import subprocess
import sys

import numpy as np
import pytest

import known
from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.element import hex_geometry
from softsample.fem.explicit import SolverSettings

TERMS = {
    "even": ((1196.8, 113.1), (-8.0, 16.0)),
    "real": ((1196.8, 113.1, 400.0), (-8.0, 16.0, 3.5)),
}
ORDER = 0.3
"""How far an observed order may be from the theory's."""


@pytest.mark.parametrize("nu", [0.40, 0.49, 0.499])
@pytest.mark.parametrize("terms", TERMS)
def test_smooth_platens_compress_homogeneously(terms, nu):
    """Every point of the curve is the root of one scalar equation, at 30 % of strain."""
    run, exact = known.smooth_platens(OgdenMaterial(*TERMS[terms], nu))
    # 0.6e-4 to 1.3e-4, inertia at this loading time: a quarter at the doubled one
    np.testing.assert_allclose(run.force, exact, atol=2.5e-4 * exact.max())
    assert run.energy["hourglass"] < 1e-6 * run.energy["strain"]
    assert run.energy["imbalance"] < 1e-4


def test_smooth_platens_in_single_precision(tissue):
    settings = SolverSettings(precision="float32")
    run, exact = known.smooth_platens(tissue, settings)
    np.testing.assert_allclose(run.force, exact, atol=4e-4 * exact.max())


@pytest.mark.parametrize("nu", [0.3, 0.49])
@pytest.mark.parametrize("distortion", [0.0, 0.2])
def test_order_in_element_size_is_two(nu, distortion):
    """Lame's mode of a free square; its frequency does not know Poisson's ratio."""
    errors = [known.lame_frequency(n, 0.1, nu, distortion) for n in (8, 16, 32)]
    np.testing.assert_allclose(known.observed_orders([4, 2, 1], errors), 2.0, atol=ORDER)
    assert abs(errors[-1]) < 0.002  # measured 0.0015 to 0.0016


def test_order_in_the_time_step_is_two():
    """The same mode on one mesh; its discrete frequency rises by (omega dt)^2 / 24."""
    frequency = [known.lame_frequency(16, step) for step in (0.9, 0.45, 0.225)]
    order, _ = known.richardson(frequency)
    assert order == pytest.approx(2.0, abs=ORDER)
    assert frequency[0] > frequency[1] > frequency[2]


@pytest.mark.parametrize("terms", TERMS)
def test_order_of_the_virtual_work_of_large_strains_is_two(terms):
    solid = OgdenMaterial(*TERMS[terms], 0.49)
    errors = [known.virtual_work_error(n, solid) for n in (4, 8, 16)]
    np.testing.assert_allclose(known.observed_orders([4, 2, 1], errors), 2.0, atol=ORDER)


def test_platen_on_a_paraboloid_is_that_of_hertz():
    """Small strains, no friction; contact spreads node by node, hence the steps of the error."""
    errors = []
    for per_radius, cells in ((2, 9), (4, 12), (8, 15)):
        run, exact = known.hertz(per_radius, cells)
        errors.append(np.abs(run.force - exact).max() / exact.max())
    assert errors[0] > errors[1] > errors[2]  # measured 0.121, 0.036, 0.021
    assert errors[1] < 0.05
    assert errors[2] < 0.03
    late = run.displacement > 0.3 * run.displacement[-1]
    slope, _ = np.polyfit(np.log(run.displacement[late]), np.log(run.force[late]), 1)
    expected, _ = np.polyfit(np.log(run.displacement[late]), np.log(exact[late]), 1)
    assert slope == pytest.approx(expected, abs=0.05)  # 1.5 and a bit for the layer


def test_refined_mesh_is_the_same_shape(crooked):
    fine = known.refined(crooked)
    assert len(fine.hexes) == 8 * len(crooked.hexes)
    # nodes, edges, faces and elements of a grid of 4 x 3 x 3 cells
    assert len(fine.points) == 9 * 7 * 7
    whole, parts = hex_geometry(crooked).volume, hex_geometry(fine).volume
    np.testing.assert_allclose(parts.reshape(-1, 8).sum(axis=1), whole, rtol=1e-12)


CURVE = """
import sys
from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.boundary import ContactSettings, platen_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.cuboid import mesh_cuboid
mesh = mesh_cuboid(8e-3, 7e-3, 6e-3, 1e-3)
tissue = OgdenMaterial((1196.8, 113.1), (-8.0, 16.0), 0.49)
run = ExplicitModel(mesh, SolverSettings()).run(
    tissue, platen_boundary(mesh, ContactSettings()), 1.8e-3, loading_time=0.02)
sys.stdout.buffer.write(run.force.tobytes())
"""


def test_curve_does_not_depend_on_process_or_threads():
    """Bit for bit between two processes, to 1e-6 of the peak between one and two threads."""

    def curve(threads):
        environment = {**os.environ, "NUMBA_NUM_THREADS": str(threads)}
        command = [sys.executable, "-c", CURVE]
        out = subprocess.run(command, env=environment, check=True, capture_output=True).stdout
        return np.frombuffer(out)

    first, again, threaded = curve(1), curve(1), curve(2)
    assert first[-1] > 0.0
    np.testing.assert_array_equal(again, first)
    np.testing.assert_allclose(threaded, first, atol=1e-6 * first.max())
