"""Quality measures against independent judges: Verdict, Gauss quadrature, an eigenvalue."""

import numpy as np
import pytest

from softsample.errors import MeshError
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.levelset import LevelSet
from softsample.meshing.mesh import HexMesh
from softsample.meshing.quality import (
    characteristic_lengths,
    check_topology,
    edge_lengths,
    element_volumes,
    scaled_jacobian,
    surface_distances,
)


def loose_hexes(noise, count=60, seed=0):
    """Separate hexahedra with disturbed corners; inverted ones among them if `noise` is large."""
    cube = mesh_cuboid(1.0, 1.0, 1.0, 1.0)
    rng = np.random.default_rng(seed)
    corners = np.tile(cube.points[cube.hexes[0]], (count, 1, 1))
    corners += noise * rng.normal(size=corners.shape) + 3.0 * np.arange(count)[:, None, None]
    return HexMesh(corners.reshape(-1, 3), np.arange(8 * count).reshape(count, 8))


@pytest.mark.parametrize("noise", [0.1, 0.8])
def test_scaled_jacobian_is_that_of_verdict(noise):
    pyvista = pytest.importorskip("pyvista")
    mesh = loose_hexes(noise, count=400)  # 10 of the folded ones are worst at their centre
    grid = pyvista.UnstructuredGrid({pyvista.CellType.HEXAHEDRON: mesh.hexes}, mesh.points)
    judge = grid.cell_quality("scaled_jacobian")["scaled_jacobian"]
    np.testing.assert_allclose(scaled_jacobian(mesh), judge, atol=1e-9)
    assert (judge.min() < 0.0) == (noise > 0.2)  # folded elements are among those judged


def corner_slopes(place):
    """(3, 8) derivatives of the corner functions of a VTK hexahedron at `place` in [-1, 1]^3."""
    signs = np.array(
        [[-1, 1, 1, -1, -1, 1, 1, -1], [-1, -1, 1, 1, -1, -1, 1, 1], [-1, -1, -1, -1, 1, 1, 1, 1]]
    )
    factor = 1.0 + signs * np.asarray(place)[:, None]
    return np.array([signs[a] * np.delete(factor, a, axis=0).prod(axis=0) for a in range(3)]) / 8.0


def test_volume_is_that_of_gauss_quadrature():
    mesh = loose_hexes(0.15)
    corners = mesh.points[mesh.hexes]
    gauss = np.array([-1.0, 1.0]) / np.sqrt(3.0)
    places = np.stack(np.meshgrid(gauss, gauss, gauss), axis=-1).reshape(-1, 3)
    volume = sum(np.linalg.det(corner_slopes(p) @ corners) for p in places)
    np.testing.assert_allclose(element_volumes(mesh), volume, rtol=1e-11)


def test_edges_of_a_box_are_its_edges():
    lengths = edge_lengths(mesh_cuboid(1.0, 2.4, 3.3, 1.1))
    np.testing.assert_allclose(np.sort(lengths[0]), [1.0] * 4 + [1.1] * 4 + [1.2] * 4)


def highest_frequency_squared(corners, poisson_ratio=0.49):
    """Largest eigenvalue of a one-point element, density and dilatational modulus both 1."""
    slopes = corner_slopes([0.0, 0.0, 0.0])
    jacobian = slopes @ corners
    gradient = np.linalg.solve(jacobian, slopes)
    lame = poisson_ratio / (1.0 - poisson_ratio)
    shear = 0.5 * (1.0 - lame)
    strain = np.zeros((6, 24))
    for row, (i, j) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]):
        strain[row, i::3] += gradient[j]
        if i != j:
            strain[row, j::3] += gradient[i]
    law = np.diag([2 * shear] * 3 + [shear] * 3)
    law[:3, :3] += lame
    return 8.0 * np.linalg.eigvalsh(strain.T @ law @ strain).max()


def test_characteristic_length_bounds_the_frequency_of_a_one_point_element():
    mesh = loose_hexes(0.12)
    length = characteristic_lengths(mesh)
    exact = np.array([highest_frequency_squared(c) for c in mesh.points[mesh.hexes]])
    assert np.all(exact <= 12.0 / length**2)
    assert np.all(exact > 4.0 / length**2)  # a bound, but no idle one


def test_characteristic_length_of_a_cube_is_its_edge():
    np.testing.assert_allclose(characteristic_lengths(mesh_cuboid(2.0, 2.0, 2.0, 0.5)), 0.5)


def test_distance_of_a_box_to_a_sphere_is_that_of_its_points():
    axes = [np.arange(-4.0, 4.1, 0.25)] * 2 + [np.arange(-2.0, 5.1, 0.25)]
    x, y, z = np.meshgrid(*axes, indexing="ij")
    sphere = np.sqrt(x**2 + y**2 + (z - 1.5) ** 2) - 2.5
    surface = LevelSet(sphere, np.array([-4.0, -4.0, -2.0]), 0.25)
    mean, p95 = surface_distances(mesh_cuboid(4.0, 4.0, 3.0, 0.25), surface)
    across, up = np.arange(-1.99, 2.0, 0.02)[:, None], np.arange(0.01, 3.0, 0.02)
    side = np.sqrt(across**2 + 2.0**2 + (up - 1.5) ** 2)
    top = np.sqrt(across**2 + across.T**2 + 1.5**2)
    exact = np.abs(np.concatenate([np.tile(side.ravel(), 4), top.ravel()]) - 2.5)
    assert mean == pytest.approx(exact.mean(), rel=2e-3)
    assert p95 == pytest.approx(np.quantile(exact, 0.95), rel=1e-2)


def with_orphan(mesh):
    return HexMesh(np.concatenate([mesh.points, [[9.0, 9.0, 9.0]]]), mesh.hexes)


def with_crack(mesh):
    """The last element gets corners of its own at the places of the shared ones."""
    hexes = mesh.hexes.copy()
    hexes[-1] = np.arange(8) + len(mesh.points)
    return HexMesh(np.concatenate([mesh.points, mesh.points[mesh.hexes[-1]]]), hexes)


def with_touching_elements(mesh):
    """The block of eight without two elements of the lower layer that face each other."""
    used, hexes = np.unique(mesh.hexes[[0, 3, 4, 5, 6, 7]], return_inverse=True)
    return HexMesh(mesh.points[used], hexes.reshape(-1, 8))


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (with_orphan, "1 nodes belong to no element"),
        (with_crack, "belong to no element|at the same place"),
        (with_touching_elements, "do not join exactly two faces"),
    ],
)
def test_broken_topology_is_refused(spoil, message):
    mesh = mesh_cuboid(2.0, 2.0, 2.0, 1.0)
    check_topology(mesh)
    with pytest.raises(MeshError, match=message):
        check_topology(spoil(mesh))
