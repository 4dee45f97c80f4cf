"""Compiled kernels against their slow twins in `tests/naive.py`."""

import functools
from dataclasses import replace

import numba
import numpy as np
import pytest

import naive
from elastic_laws import BySpectrum
from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem import tensors
from softsample.fem.boundary import Boundary, ContactSettings, glued_boundary, platen_boundary
from softsample.fem.explicit import BACKENDS, JACOBI_SWEEPS, ExplicitModel, SolverSettings
from softsample.fem.motion import FREE, PLATEN, Motion, advance
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.mesh import HexMesh
from softsample.protocol import smooth_step

BACKEND = "scalar" if numba.config.DISABLE_JIT else "vector"
DOUBLE = SolverSettings(backend=BACKEND, precision="float64")
SINGLE = replace(DOUBLE, precision="float32")


def deformed(mesh, strain=0.25, noise=0.04, seed=0):
    """Displacements of a large inhomogeneous deformation without inverted elements."""
    rng = np.random.default_rng(seed)
    gradient = strain * rng.uniform(-1.0, 1.0, (3, 3))
    size = np.ptp(mesh.points, axis=0).max()
    wave = 0.05 * size * np.sin(2.0 * mesh.points[:, [1, 2, 0]] / size)
    jitter = noise * mesh.edge_length * rng.uniform(-1.0, 1.0, mesh.points.shape)
    return mesh.points @ gradient.T + wave + jitter


def row_of_elements(count, seed=2):
    """`count` distorted elements side by side."""
    mesh = mesh_cuboid(1e-3 * count, 1e-3, 1e-3, 1e-3)
    shift = np.random.default_rng(seed).uniform(-2e-4, 2e-4, mesh.points.shape)
    return HexMesh(mesh.points + shift, mesh.hexes)


def assert_twins_agree(mesh, material, settings, tolerance, solver=ExplicitModel):
    u = deformed(mesh)
    force, state = solver(mesh, settings).internal_force(u, material)
    twin = naive.Twin(mesh, settings.hourglass_coefficient)
    wanted, wanted_state = twin.internal_force(u, material)
    np.testing.assert_allclose(force, wanted, atol=tolerance * np.abs(wanted).max())
    for row, wanted_row in zip(state, wanted_state, strict=True):
        np.testing.assert_allclose(row, wanted_row, atol=tolerance * np.abs(wanted_row).max())


@pytest.mark.nojit
@pytest.mark.parametrize("count", [1, 17])
def test_forces_energies_and_volume_are_those_of_the_twin(count, tissue):
    assert_twins_agree(row_of_elements(count), tissue, DOUBLE, 1e-10)


@pytest.mark.nojit
def test_spectral_path_is_the_twin_at_real_exponents():
    material = OgdenMaterial((900.0, 200.0, -40.0), (-7.3, 11.9, 1.5), 0.49)
    assert_twins_agree(row_of_elements(2), material, DOUBLE, 1e-10)


@pytest.mark.parametrize("count", [1, 15, 16, 17, 33])
def test_count_of_elements_need_not_fill_the_lanes(count, tissue):
    assert_twins_agree(row_of_elements(count), tissue, DOUBLE, 1e-10)


@pytest.mark.parametrize("solver", [ExplicitModel, BySpectrum])
@pytest.mark.parametrize("alpha", [(-8.0, 16.0), (2.0,), (-4.0, 6.0), (-2.0, 12.0, -10.0)])
def test_both_paths_are_the_twin_at_even_exponents(crooked, alpha, solver):
    mu = (1000.0, 300.0, 50.0)[: len(alpha)]
    material = OgdenMaterial(mu, alpha, 0.49)
    assert_twins_agree(crooked, material, DOUBLE, 1e-10, solver)


@pytest.mark.parametrize("nu", [0.3, 0.49, 0.4995])
def test_volumetric_part_is_the_twin(crooked, nu):
    assert_twins_agree(crooked, OgdenMaterial((700.0, 200.0), (-3.5, 4.2), nu), DOUBLE, 1e-10)


@pytest.mark.parametrize("solver", [ExplicitModel, BySpectrum])
def test_single_precision_keeps_five_digits(crooked, tissue, solver):
    """A product of 16 stretches amplifies the rounding 6e-8 of each some hundred times."""
    assert_twins_agree(crooked, tissue, SINGLE, 3e-5, solver)


def test_single_precision_keeps_small_strains(crooked, tissue):
    """Strains of 1e-5 keep three digits: C - I is formed without subtracting the identity."""
    u = 1e-5 * crooked.points[:, [1, 2, 0]]
    exact, _ = ExplicitModel(crooked, DOUBLE).internal_force(u, tissue)
    force, _ = ExplicitModel(crooked, SINGLE).internal_force(u, tissue)
    np.testing.assert_allclose(force, exact, atol=0.03 * np.abs(exact).max())


def test_both_paths_agree_where_stretches_coincide(block, tissue):
    """Repeated eigenvalues: no strain, two equal stretches, volume change only."""
    for gradient in (np.zeros(3), [0.2, 0.2, -0.3], [0.1, 0.1, 0.1]):
        u = block.points * np.asarray(gradient)
        product, _ = ExplicitModel(block, DOUBLE).internal_force(u, tissue)
        spectral, _ = BySpectrum(block, DOUBLE).internal_force(u, tissue)
        scale = max(np.abs(product).max(), 1e-9)
        np.testing.assert_allclose(product, spectral, atol=1e-11 * scale)


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("alpha", [(-8.0, 16.0), (-7.3, 11.9)])
def test_vector_code_is_its_scalar_twin(crooked, precision, alpha):
    """The same text on whole blocks and element by element; fused roundings differ."""
    material = OgdenMaterial((1000.0, 300.0), alpha, 0.49)
    vector = replace(DOUBLE, precision=precision, backend="vector")
    u = deformed(crooked)
    ours, state = ExplicitModel(crooked, vector).internal_force(u, material)
    scalar = ExplicitModel(crooked, replace(vector, backend="scalar"))
    wanted, wanted_state = scalar.internal_force(u, material)
    tolerance = 2e-5 if precision == "float32" else 1e-12
    np.testing.assert_allclose(ours, wanted, atol=tolerance * np.abs(wanted).max())
    for row, wanted_row in zip(state, wanted_state, strict=True):
        np.testing.assert_allclose(row, wanted_row, atol=tolerance * np.abs(wanted_row).max())


PLACES = ((0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1))


def unimodular(seed=4, count=16):
    """(count, 3, 3) symmetric positive matrices of determinant one."""
    F = np.eye(3) + 0.25 * np.random.default_rng(seed).uniform(-1, 1, (count, 3, 3))
    C = np.swapaxes(F, 1, 2) @ F
    return C / np.cbrt(np.linalg.det(C))[:, None, None]


def entries(C):
    return tuple(float(C[place]) for place in PLACES)


@functools.cache
def entry(part):
    """A function for Python that calls a part of the kernels, which has no entry of its own."""
    return numba.njit(lambda *given: part(*given))


@pytest.mark.nojit
@pytest.mark.parametrize("exponent", [1, 2, 3, 5, 8, 12])
def test_whole_power_is_the_matrix_power(exponent):
    for C in unimodular():
        power = entry(tensors.whole_power)(entries(C), exponent)
        wanted = np.linalg.matrix_power(C, exponent)
        np.testing.assert_allclose(power, entries(wanted), atol=1e-11 * np.abs(wanted).max())


@pytest.mark.nojit
def test_adjugate_is_the_inverse_at_determinant_one():
    for C in unimodular():
        np.testing.assert_allclose(
            entry(tensors.adjugate)(entries(C)), entries(np.linalg.inv(C)), atol=1e-12
        )


@pytest.mark.nojit
@pytest.mark.parametrize(("J", "tolerance"), [(0.1, 1e-7), (0.3, 1e-14), (3.0, 1e-14), (6.0, 1e-9)])
def test_cube_root_is_exact_for_foams_too(J, tolerance):
    """A foam without lateral contraction loses and gains volume as it is pressed and pulled."""
    found = entry(tensors.inverse_square_cube_root)(J - 1.0)
    assert found == pytest.approx(J ** (-2.0 / 3.0), rel=tolerance)


@pytest.mark.parametrize("precision", [SINGLE, DOUBLE])
@pytest.mark.parametrize("volume", [0.4, 2.5])
def test_forces_at_a_large_change_of_volume_are_those_of_the_twin(crooked, volume, precision):
    material = OgdenMaterial((900.0, 200.0), (-7.3, 11.9), 0.0)
    u = (np.cbrt(volume) - 1.0) * crooked.points + 0.1 * crooked.points[:, [1, 2, 0]]
    force, _ = ExplicitModel(crooked, precision).internal_force(u, material)
    wanted, _ = naive.Twin(crooked, DOUBLE.hourglass_coefficient).internal_force(u, material)
    tolerance = 1e-10 if precision is DOUBLE else 3e-5
    np.testing.assert_allclose(force, wanted, atol=tolerance * np.abs(wanted).max())


@pytest.mark.nojit
def test_jacobi_rotations_find_eigenvalues_and_vectors():
    matrices = unimodular()
    matrices[:3] = np.eye(3), np.diag([4.0, 4.0, 0.0625]), [[1, 0.5, 0], [0.5, 1, 0], [0, 0, 1]]
    for C in matrices:
        squared, vectors = entry(tensors.eigen)(entries(C), JACOBI_SWEEPS["float64"])
        np.testing.assert_allclose(np.sort(squared), np.linalg.eigvalsh(C), rtol=1e-13, atol=1e-13)
        basis = np.array(vectors).T
        np.testing.assert_allclose((basis * squared) @ basis.T, C, atol=1e-13)


def marched(mesh, material, boundary, path, dt):
    """The compiled march in double precision: displacements, velocities, holders, history."""
    model = ExplicitModel(mesh, DOUBLE)
    steps, held, state = len(path) - 1, boundary.held.copy(), model.blank_state()
    count = state.shape[-1]
    registers = tuple(np.zeros((-(-4 * len(held) // count), count)) for _ in range(4))
    motion = Motion(
        *(part.reshape(-1, 4)[: len(held)] for part in registers), held, model.mass, mesh.points,
        state, np.empty((0, 1, 6, count)), registers,
    )  # fmt: skip
    motion.mobility[:, :3] = np.where(held == FREE, 1.0 / model.mass, 0.0)[:, None]
    history = np.empty((steps, 7))
    advance(
        path, np.zeros((steps, 3)), np.empty((steps, 2, 0)), dt, dt, motion,
        model.elements(material.shear_modulus), model.solid(material), boundary.platens(), history,
        BACKENDS[DOUBLE.backend],
    )  # fmt: skip
    return motion.u[:, :3], motion.v[:, :3], held, history


def tilted_boundary(mesh, release):
    """A platen leaning in x that comes down and sideways, touching the top nodes one by one."""
    b = platen_boundary(mesh, ContactSettings(release=release))
    normal = np.array([0.1, -0.05, 1.0]) / np.linalg.norm([0.1, -0.05, 1.0])
    planes = b.planes.copy()
    planes[1] = [*normal, (mesh.points @ normal).max()]
    direction = np.array([0.6, 0.0, -0.8])
    return Boundary(b.held, b.candidates, planes, direction, release)


def compare_march(mesh, material, boundary, travel, steps, dt):
    path = travel * smooth_step(np.arange(steps + 1) / steps)
    u, v, held, history = marched(mesh, material, boundary, path, dt)
    twin = naive.Twin(mesh, DOUBLE.hourglass_coefficient)
    wanted = naive.march(twin, material, boundary, path, dt, DOUBLE.density_kg_m3)
    for ours, theirs in zip((u, v, history[:, :6]), (*wanted[:2], wanted[3]), strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-9 * np.abs(theirs).max())
    np.testing.assert_array_equal(held, wanted[2])
    return held, history


@pytest.mark.nojit
def test_a_few_glued_steps_are_those_of_the_twin(tissue):
    mesh = row_of_elements(2)
    mesh.points[:4, 2] = 0.0
    boundary = glued_boundary(mesh, "shear", np.flatnonzero(mesh.points[:, 2] > 5e-4))
    compare_march(mesh, tissue, boundary, 1e-4, 8, 2e-5)


@pytest.mark.parametrize("release", [False, True])
def test_march_with_contact_is_that_of_the_twin(crooked, tissue, release):
    boundary = tilted_boundary(crooked, release)
    held, history = compare_march(crooked, tissue, boundary, 8e-4, 120, 3e-5)
    touched = np.sum(held[boundary.candidates] == PLATEN)
    assert touched < 20 if release else touched == 20  # the whole top, some of which lets go
    assert np.abs(history[:, :3]).max() > 0.0
