"""The element: patch test, rigid motions, balances, gradient of the energy, hourglass control."""

import numpy as np
import pytest

import naive
from elastic_laws import BySpectrum
from softsample.errors import MeshError
from softsample.fem.element import HOURGLASS, hex_geometry, lumped_mass
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.fem.fields import deformation_gradients, principal_hencky_strains
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.mesh import HexMesh
from spectral import stress as ogden_stress

DOUBLE = SolverSettings(precision="float64")
GRADIENT = np.array([[0.12, 0.2, -0.05], [0.03, -0.15, 0.1], [-0.08, 0.06, 0.1]])


def axis_rotation(angle, axis):
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def inner_nodes(mesh):
    inner = np.ones(len(mesh.points), bool)
    inner[mesh.boundary] = False
    return inner


@pytest.fixture(scope="module")
def patch(block):
    """The block with a flat surface but inner nodes moved by up to 0.25 mm."""
    shift = np.random.default_rng(8).uniform(-2.5e-4, 2.5e-4, block.points.shape)
    return HexMesh(block.points + shift * inner_nodes(block)[:, None], block.hexes)


def test_linear_field_is_a_state_of_constant_stress(patch, tissue):
    """Patch test: zero residual inside, and each face carries stress times area."""
    force, state = ExplicitModel(patch, DOUBLE).internal_force(patch.points @ GRADIENT.T, tissue)
    F = np.eye(3) + GRADIENT
    P = ogden_stress(F, tissue)
    scale = np.abs(P).max() * patch.edge_length**2
    inner = inner_nodes(patch)
    assert inner.sum() >= 12
    np.testing.assert_allclose(force[inner], 0.0, atol=1e-11 * scale)
    np.testing.assert_allclose(state[1], 0.0, atol=1e-20)  # hourglass energy [J]
    np.testing.assert_allclose(state[2], np.linalg.det(F) - 1.0, rtol=1e-11)
    # forces of the half beyond a cut: faces x, y, z, without their edges, by integration
    moment = np.einsum("ni,nj->ij", force, patch.points)
    np.testing.assert_allclose(moment, P * hex_geometry(patch).volume.sum(), rtol=1e-10)


def test_inner_nodes_find_the_linear_field_by_themselves(patch, tissue):
    """Patch test, weak point of a spurious mode: equilibrium is unique and linear."""
    model = ExplicitModel(patch, DOUBLE)
    exact = patch.points @ GRADIENT.T
    inner = inner_nodes(patch)
    start = exact + 5e-5 * np.random.default_rng(0).normal(size=exact.shape) * inner[:, None]
    found = naive.equilibrium(
        lambda u: model.internal_force(u, tissue)[0], start, inner, tolerance=1e-12
    )
    np.testing.assert_allclose(found, exact, atol=1e-8 * np.abs(exact).max())


@pytest.mark.parametrize("angle", [0.0, 0.3, 2.0])
def test_rigid_motion_takes_no_force(crooked, tissue, angle):
    Q = axis_rotation(angle, [1.0, -2.0, 0.5])
    u = crooked.points @ (Q - np.eye(3)).T + np.array([1e-3, -2e-3, 5e-4])
    force, state = ExplicitModel(crooked, DOUBLE).internal_force(u, tissue)
    stiff = tissue.bulk_modulus * crooked.edge_length**2
    np.testing.assert_allclose(force, 0.0, atol=1e-13 * stiff)
    np.testing.assert_allclose(state[:2], 0.0, atol=1e-13 * stiff * crooked.edge_length)


@pytest.fixture(scope="module")
def deformed(crooked):
    rng = np.random.default_rng(1)
    return crooked.points @ GRADIENT.T + 8e-5 * rng.uniform(-1.0, 1.0, crooked.points.shape)


def test_forces_turn_with_a_deformed_body(crooked, tissue, deformed):
    """Objectivity, hourglass forces included: f(Q x) = Q f(x)."""
    model = ExplicitModel(crooked, DOUBLE)
    Q = axis_rotation(1.1, [0.2, 1.0, 0.3])
    force, state = model.internal_force(deformed, tissue)
    turned = (crooked.points + deformed) @ Q.T - crooked.points
    force_turned, state_turned = model.internal_force(turned, tissue)
    scale = np.abs(force).max()
    np.testing.assert_allclose(force_turned, force @ Q.T, atol=1e-11 * scale)
    np.testing.assert_allclose(state_turned, state, rtol=1e-9, atol=1e-11)


def test_internal_forces_balance(crooked, tissue, deformed):
    """No net force, and no net moment about the deformed positions."""
    force, state = ExplicitModel(crooked, DOUBLE).internal_force(deformed, tissue)
    scale = np.abs(force).sum()
    assert state[1].sum() > 1e-3 * state[0].sum()  # hourglass forces take part
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-14 * scale)
    moment = np.cross(crooked.points + deformed, force).sum(axis=0)
    np.testing.assert_allclose(moment, 0.0, atol=1e-14 * scale * 4e-3)


@pytest.mark.parametrize("solver", [ExplicitModel, BySpectrum])
def test_forces_are_the_gradient_of_the_energy(crooked, tissue, deformed, solver):
    model = solver(crooked, DOUBLE)

    def energy(u):
        return model.internal_force(u, tissue)[1][:2].sum()

    force, _ = model.internal_force(deformed, tissue)
    rng = np.random.default_rng(2)
    for _ in range(5):
        way = rng.normal(size=force.shape)
        reach = 1e-8
        slope = (energy(deformed + reach * way) - energy(deformed - reach * way)) / (2.0 * reach)
        assert slope == pytest.approx(np.vdot(force, way), rel=1e-6)


@pytest.mark.parametrize("pattern", range(4))
def test_hourglass_patterns_are_resisted(pattern, tissue):
    """Every pattern has its energy; without hourglass control the element does not feel it."""
    cube = mesh_cuboid(1e-3, 1e-3, 1e-3, 1e-3)
    u = np.zeros_like(cube.points)
    u[cube.hexes[0], 1] = 1e-5 * HOURGLASS[pattern]
    force, state = ExplicitModel(cube, DOUBLE).internal_force(u, tissue)
    # coefficient mu V (B:B) / 64 with B:B = 3 / (2 h^2) of a cube, and sum of squares 8
    stiffness = 0.5 * tissue.shear_modulus * 1e-9 * 1.5e6 / 64.0
    assert state[1, 0] == pytest.approx(0.5 * stiffness * (8.0 * 1e-5) ** 2, rel=1e-10)
    assert np.vdot(force, u) == pytest.approx(2.0 * state[1, 0], rel=1e-10)
    soft = SolverSettings(precision="float64", hourglass_coefficient=0.0)
    force, state = ExplicitModel(cube, soft).internal_force(u, tissue)
    np.testing.assert_allclose(force, 0.0, atol=1e-18)


def test_single_element_has_only_the_six_rigid_modes(tissue):
    cube = mesh_cuboid(1e-3, 1e-3, 1e-3, 1e-3)
    shift = np.random.default_rng(6).uniform(-2e-4, 2e-4, cube.points.shape)
    element = HexMesh(cube.points + shift, cube.hexes)
    for coefficient, modes in ((0.5, 6), (0.0, 18)):
        settings = SolverSettings(precision="float64", hourglass_coefficient=coefficient)
        model = ExplicitModel(element, settings)
        tangent = naive.stiffness(
            lambda u, model=model: model.internal_force(u, tissue)[0], np.zeros((8, 3)), 1e-9
        )
        np.testing.assert_allclose(tangent, tangent.T, atol=1e-5 * np.abs(tangent).max())
        values = np.linalg.eigvalsh(0.5 * (tangent + tangent.T))
        assert np.sum(np.abs(values) < 1e-6 * values.max()) == modes
        assert values.min() > -1e-6 * values.max()


def test_geometry_is_that_of_the_full_gauss_rule(crooked):
    geometry = hex_geometry(crooked)
    for e in range(0, len(crooked.hexes), 7):
        gradient, volume = naive.mean_gradient(crooked.points[crooked.hexes[e]])
        np.testing.assert_allclose(geometry.gradient[e], gradient, atol=1e-12 / 1e-3)
        assert geometry.volume[e] == pytest.approx(volume, rel=1e-12)


def test_mass_is_density_times_volume_and_follows_the_elements(block, crooked):
    regular = lumped_mass(block, hex_geometry(block), 1000.0)
    assert regular.sum() == pytest.approx(1000.0 * 4e-3 * 3.3e-3 * 2.7e-3, rel=1e-12)
    assert regular.max() == pytest.approx(8.0 * regular.min(), rel=1e-12)  # inside : corner
    twin = naive.Twin(crooked, 0.5).mass(1000.0)
    ours = lumped_mass(crooked, hex_geometry(crooked), 1000.0)
    np.testing.assert_allclose(ours, twin, rtol=1e-12)


def test_inverted_element_of_the_mesh_is_refused(block):
    hexes = block.hexes.copy()
    hexes[5] = hexes[5][[4, 5, 6, 7, 0, 1, 2, 3]]
    with pytest.raises(MeshError, match=r"element 5 has volume -.*element_size_mm"):
        ExplicitModel(HexMesh(block.points, hexes), DOUBLE)


def test_strain_fields_of_a_linear_deformation(patch):
    u = patch.points @ GRADIENT.T
    F = np.eye(3) + GRADIENT
    np.testing.assert_allclose(deformation_gradients(patch, u), np.tile(F, (36, 1, 1)), atol=1e-12)
    largest = np.log(np.linalg.svd(F, compute_uv=False)[0])
    found = principal_hencky_strains(patch, u)[:, -1]
    np.testing.assert_allclose(found, largest, rtol=1e-10)
