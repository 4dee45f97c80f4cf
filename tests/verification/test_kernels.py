"""Compiled kernels against their slow twins in `tests/naive.py`."""

import numpy as np
import pytest

import naive
from softsample.constitutive.ogden import OgdenMaterial
from softsample.errors import SimulationError
from softsample.fem import kernels
from softsample.fem.boundary import Boundary, ContactSettings, glued_boundary, platen_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.mesh import HexMesh
from softsample.protocol import smooth_step

DOUBLE = SolverSettings(precision="float64")
SINGLE = SolverSettings(precision="float32")


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


def assert_twins_agree(mesh, material, settings, tolerance, spectral=None):
    u = deformed(mesh)
    force, state = ExplicitModel(mesh, settings).internal_force(u, material, spectral)
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


@pytest.mark.parametrize("spectral", [False, True])
@pytest.mark.parametrize("alpha", [(-8.0, 16.0), (2.0,), (-4.0, 6.0), (-2.0, 12.0, -10.0)])
def test_both_paths_are_the_twin_at_even_exponents(crooked, alpha, spectral):
    mu = (1000.0, 300.0, 50.0)[: len(alpha)]
    material = OgdenMaterial(mu, alpha, 0.49)
    assert_twins_agree(crooked, material, DOUBLE, 1e-10, spectral)


@pytest.mark.parametrize("nu", [0.3, 0.49, 0.4995])
def test_volumetric_part_is_the_twin(crooked, nu):
    assert_twins_agree(crooked, OgdenMaterial((700.0, 200.0), (-3.5, 4.2), nu), DOUBLE, 1e-10)


@pytest.mark.parametrize("spectral", [False, True])
def test_single_precision_keeps_five_digits(crooked, tissue, spectral):
    """A product of 16 stretches amplifies the rounding 6e-8 of each some hundred times."""
    assert_twins_agree(crooked, tissue, SINGLE, 3e-5, spectral)


def test_single_precision_keeps_small_strains(crooked, tissue):
    """Strains of 1e-5 keep three digits: C - I is formed without subtracting the identity."""
    u = 1e-5 * crooked.points[:, [1, 2, 0]]
    exact, _ = ExplicitModel(crooked, DOUBLE).internal_force(u, tissue)
    force, _ = ExplicitModel(crooked, SINGLE).internal_force(u, tissue)
    np.testing.assert_allclose(force, exact, atol=0.03 * np.abs(exact).max())


def test_both_paths_agree_where_stretches_coincide(block, tissue):
    """Repeated eigenvalues: no strain, two equal stretches, volume change only."""
    model = ExplicitModel(block, DOUBLE)
    for gradient in (np.zeros(3), [0.2, 0.2, -0.3], [0.1, 0.1, 0.1]):
        u = block.points * np.asarray(gradient)
        product, _ = model.internal_force(u, tissue, spectral=False)
        spectral, _ = model.internal_force(u, tissue, spectral=True)
        scale = max(np.abs(product).max(), 1e-9)
        np.testing.assert_allclose(product, spectral, atol=1e-11 * scale)


def unimodular(seed=4):
    """(6, LANES) symmetric positive matrices of determinant one, and (LANES, 3, 3)."""
    F = np.eye(3) + 0.25 * np.random.default_rng(seed).uniform(-1, 1, (kernels.LANES, 3, 3))
    C = np.swapaxes(F, 1, 2) @ F
    C /= np.cbrt(np.linalg.det(C))[:, None, None]
    return pack(C), C


def pack(C):
    return np.array([C[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1))])


@pytest.mark.nojit
@pytest.mark.parametrize("exponent", [1, 2, 3, 5, 8, -1, -2, -3, -4, -7])
def test_integer_power_is_the_matrix_power(exponent):
    c, C = unimodular()
    square, power = np.empty_like(c), np.empty_like(c)
    before = c.copy()
    kernels._integer_power(c, exponent, square, power)
    wanted = pack(np.linalg.matrix_power(C, exponent))
    np.testing.assert_allclose(power, wanted, atol=1e-11 * np.abs(wanted).max())
    np.testing.assert_array_equal(c, before)


@pytest.mark.nojit
def test_jacobi_rotations_find_eigenvalues_and_vectors():
    c, C = unimodular()
    c[:, 0], C[0] = (1, 1, 1, 0, 0, 0), np.eye(3)
    c[:, 1], C[1] = (4, 4, 0.0625, 0, 0, 0), np.diag([4.0, 4.0, 0.0625])
    vectors, squared = np.empty((3, 3, kernels.LANES)), np.empty((3, kernels.LANES))
    kernels._spectral(c, vectors, squared)
    np.testing.assert_allclose(
        np.sort(squared.T, axis=1), np.linalg.eigvalsh(C), rtol=1e-13, atol=1e-13
    )
    basis = np.moveaxis(vectors, -1, 0)
    rebuilt = (basis * squared.T[:, None, :]) @ np.swapaxes(basis, 1, 2)
    np.testing.assert_allclose(rebuilt, C, atol=1e-13)


def test_product_path_refuses_exponents_that_are_not_even(block):
    material = OgdenMaterial((1000.0,), (3.0,), 0.49)
    with pytest.raises(SimulationError, match=r"\(3.0,\) are not all even.*spectral path"):
        ExplicitModel(block, DOUBLE).internal_force(
            np.zeros((len(block.points), 3)), material, False
        )


def marched(mesh, material, boundary, path, dt):
    """The compiled march in double precision: displacements, velocities, holders, history."""
    model = ExplicitModel(mesh, DOUBLE)
    u, v, force = (np.zeros_like(mesh.points) for _ in range(3))
    held = boundary.held.copy()
    mobility = np.where(held == kernels.FREE, 1.0 / model.mass, 0.0)[:, None].repeat(3, axis=1)
    state = np.empty((3, *model.elements(1.0)[3].shape))
    history = np.empty((len(path) - 1, 7))
    kernels.advance(
        path, dt, dt, u, v, force, state, model.elements(material.shear_modulus),
        (np.array(material.mu), np.array(material.alpha), material.bulk_modulus, False),
        model.mass, mobility, mesh.points, held, (boundary.glued, boundary.candidates),
        boundary.planes, boundary.direction, boundary.release, history,
    )  # fmt: skip
    return u, v, held, history


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
    for ours, theirs in zip((u, v, history[:, 1:]), (*wanted[:2], wanted[3]), strict=True):
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
    touched = np.sum(held[boundary.candidates] == kernels.PLATEN)
    assert touched < 20 if release else touched == 20  # the whole top, some of which lets go
    assert np.abs(history[:, 1:4]).max() > 0.0
