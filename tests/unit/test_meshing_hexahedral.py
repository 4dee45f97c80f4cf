"""Meshes of solids with a formula: element shape, closed surface, flat base, volume, top."""

import os
from collections import Counter
from functools import cache

import numpy as np
import pytest

from softsample.errors import MeshError
from softsample.meshing import hexahedral
from softsample.meshing.hexahedral import mesh_solid
from softsample.meshing.levelset import LevelSet
from softsample.meshing.quality import element_volumes, scaled_jacobian
from softsample.meshing.sample import mesh_real

pytestmark = pytest.mark.skipif(
    os.environ.get("NUMBA_DISABLE_JIT") == "1",
    reason="minutes in plain Python; the kernels have tests of their own in both modes",
)

MM = 1e-3
SPACING = 0.25  # mm


def dome(x, y, z):
    """Distance [mm] to a cylinder of radius 3 that ends in a half sphere 6 above its base."""
    return np.sqrt(x**2 + y**2 + np.maximum(z - 3.0, 0.0) ** 2) - 3.0


def capped_block(x, y, z):
    """Block of 8 x 6 with edges of radius 1.2 below a sphere of radius 9, top at 5.

    Its sharp upper rim is rounded by a smooth maximum.
    """
    u, v = np.maximum(np.abs(x) - 2.8, 0.0), np.maximum(np.abs(y) - 1.8, 0.0)
    wall = np.hypot(u, v) + np.minimum(np.maximum(np.abs(x) - 2.8, np.abs(y) - 1.8), 0.0) - 1.2
    return rounded_maximum(wall, np.sqrt(x**2 + y**2 + (z + 4.0) ** 2) - 9.0)


def bumpy_block(x, y, z):
    """Tapered block of about 9 x 8 x 6 with bowed walls and a tilted, bumpy, rounded top."""
    low = np.maximum(z, -1.0)
    taper = 0.05 * (low - 3.0)
    sides = rounded_maximum(
        np.abs(x + 0.15 * np.sin(y + 0.5 * low)) - 4.5 + taper,
        np.abs(y + 0.15 * np.sin(0.8 * x)) - 4.0 - taper,
    )
    return rounded_maximum(sides, z - 6.0 - 0.04 * x + 0.25 * np.cos(1.1 * x) * np.sin(0.9 * y))


def rounded_maximum(a, b, radius=1.2):
    """Maximum of two distances, the edge between them rounded."""
    u, v = np.maximum(a + radius, 0.0), np.maximum(b + radius, 0.0)
    return np.minimum(np.maximum(a, b), -radius) + np.hypot(u, v)


SHAPES = {"dome": dome, "capped_block": capped_block, "bumpy_block": bumpy_block}


def axes(spacing, below=3.0):
    return [np.arange(-7.0, 7.0 + spacing / 2, spacing)] * 2 + [np.arange(-below, 9.0, spacing)]


@cache
def grid(shape):
    values = SHAPES[shape](*np.meshgrid(*axes(SPACING), indexing="ij"))
    return values * MM, np.array([-7.0, -7.0, -3.0]) * MM, SPACING * MM


@cache
def solid(shape, size=0.5):
    return mesh_solid(*grid(shape), size * MM)


def counted_volume(shape, heights=None, step=0.1):
    """Volume [mm3] by adding up shares of small cubes, independent of splines and meshes.

    With `heights` [mm], of layers of one step at these heights only.
    """
    x, y, _ = axes(step)
    z = (np.arange(90) + 0.5) * step if heights is None else heights
    distance = SHAPES[shape](*np.meshgrid(x, y, z, indexing="ij"))
    return np.clip(0.5 - distance / step, 0.0, 1.0).sum() * step**3


@pytest.mark.parametrize("size", [0.5, 0.8])
@pytest.mark.parametrize("shape", SHAPES)
def test_elements_are_well_shaped(shape, size):
    """0.3 is what the solver needs, 0.45 what this method keeps on smooth solids."""
    jacobian = scaled_jacobian(solid(shape, size))
    assert jacobian.min() > 0.45
    assert np.quantile(jacobian, 0.01) > 0.55  # small samples have more surface than real ones


@pytest.mark.parametrize("shape", SHAPES)
def test_surface_is_closed_and_uses_every_outer_node_once(shape):
    mesh = solid(shape)
    edges = Counter(
        tuple(sorted((quad[i], quad[i - 1])))
        for quad in mesh.boundary_quads.tolist()
        for i in range(4)
    )
    assert set(edges.values()) == {2}
    nodes = len(mesh.boundary)
    assert nodes - len(edges) + len(mesh.boundary_quads) == 2  # Euler number of a sphere
    assert len(np.unique(mesh.hexes)) == len(mesh.points)


@pytest.mark.parametrize("shape", SHAPES)
def test_base_is_flat_and_has_the_area_of_the_section(shape):
    mesh = solid(shape)
    base = mesh.points[:, 2] == 0.0
    assert np.all(mesh.points[~base, 2] > 0.2 * 0.5 * MM)
    np.testing.assert_array_equal(mesh.bottom, np.flatnonzero(base))
    on_base = np.all(base[mesh.boundary_quads], axis=1)
    rim = np.intersect1d(mesh.boundary_quads[on_base], mesh.boundary_quads[~on_base])
    distance = np.abs(SHAPES[shape](*(mesh.points[rim] / MM).T))
    assert len(rim) > 30
    assert distance.mean() < 0.01  # mm; the sagitta, see below
    x, y, _ = mesh.points[mesh.boundary_quads[on_base]].transpose(2, 1, 0) / MM
    area = -0.5 * np.sum((x[2] - x[0]) * (y[3] - y[1]) - (x[3] - x[1]) * (y[2] - y[0]))
    section = counted_volume(shape, heights=np.zeros(1)) / 0.1
    assert area == pytest.approx(section, rel=3e-3)  # chords around it would lack 1 %


@pytest.mark.parametrize("shape", SHAPES)
def test_surface_nodes_lie_on_the_solid_but_for_the_sagitta_of_the_faces(shape):
    """Faces of edge h cut h^2 / 12 (1 / R1 + 1 / R2) off; the nodes stand out by about that."""
    mesh = solid(shape)
    quads = mesh.boundary_quads
    outer = np.unique(quads[~np.all(mesh.points[quads, 2] == 0.0, axis=1)])
    distance = SHAPES[shape](*(mesh.points[outer] / MM).T)
    assert np.abs(distance).mean() < 0.5**2 / 12.0 * (1.0 / 3.0 + 1.0 / 3.0)
    assert np.abs(distance).max() < 0.07  # at the corners of radius 1.2


@pytest.mark.parametrize("shape", SHAPES)
def test_volume_is_that_of_the_solid(shape):
    volume = element_volumes(solid(shape)).sum() / MM**3
    assert volume == pytest.approx(counted_volume(shape), rel=1e-3)


def test_volume_error_falls_faster_than_that_of_chords():
    """With the nodes on the surface it would be h^2 / (6 R), 1.3 % at 0.6 mm, and rate 2."""
    exact = np.pi * 3.0**2 * 3.0 + 2.0 / 3.0 * np.pi * 3.0**3
    sizes = [0.3, 0.6]
    error = [abs(1.0 - element_volumes(solid("dome", h)).sum() / MM**3 / exact) for h in sizes]
    assert error[1] < 3e-3
    assert error[0] < error[1] / 3.0


def test_highest_point_is_a_node():
    top = LevelSet(*grid("dome")).highest_point
    assert np.linalg.norm(solid("dome").points - top, axis=1).min() < 1e-12
    assert solid("dome").highest == pytest.approx(6.0 * MM, abs=2e-6)
    mesh, (x, y) = solid("bumpy_block"), np.meshgrid(*[np.arange(-4.4, 4.4, 0.05)] * 2)
    reached = [z for z in np.arange(6.0, 7.0, 0.005) if bumpy_block(x, y, z).min() < 0.0]
    assert mesh.highest / MM == pytest.approx(max(reached), abs=0.01)


def test_same_input_gives_the_same_mesh():
    again = mesh_solid(*grid("dome"), 0.5 * MM)
    np.testing.assert_array_equal(again.points, solid("dome").points)


def test_report_holds_the_figures_in_millimetres():
    made = mesh_real(*grid("capped_block"), 0.8 * MM, preload=1.0 * MM)
    report = made.report
    assert report["inverted"] == 0
    assert report["elements"] == len(made.mesh.hexes)
    assert report["volume_mm3"] == pytest.approx(counted_volume("capped_block"), rel=0.01)
    assert report["highest_point_mm"] == pytest.approx(5.0, abs=0.01)
    assert report["mean_distance_mm"] < report["p95_distance_mm"] < 0.2
    glued = made.mesh.points[made.point_data["glued"] == 1, 2]
    assert glued.min() >= made.mesh.highest - 1.0 * MM * 1.001
    assert made.point_data["glued"].sum() > 20


@pytest.mark.parametrize("shift", [-0.3, 0.3])
def test_shifted_boundary_is_the_parallel_surface(shift):
    """Steiner: a dome of radius r + shift on a wall of 3, all of it above the same base plane."""
    made = mesh_real(*grid("dome"), 0.5 * MM, preload=1.0 * MM, boundary_shift=shift * MM)
    radius = 3.0 + shift
    exact = np.pi * radius**2 * 3.0 + 2.0 / 3.0 * np.pi * radius**3
    assert element_volumes(made.mesh).sum() / MM**3 == pytest.approx(exact, rel=3e-3)
    assert made.report["volume_mm3"] == pytest.approx(exact, rel=3e-3)
    assert made.mesh.highest / MM == pytest.approx(6.0 + shift, abs=2e-3)
    base = made.mesh.points[made.mesh.bottom] / MM
    assert np.all(base[:, 2] == 0.0)
    assert np.linalg.norm(base[:, :2], axis=1).max() == pytest.approx(radius, abs=0.02)


def test_shift_changes_the_volume_by_wall_and_top_to_first_order():
    distance, origin, spacing = grid("dome")
    low, high = (
        LevelSet(distance - shift * MM, origin, spacing).volume / MM**3 for shift in (-0.05, 0.05)
    )
    area = 2.0 * np.pi * 3.0 * 3.0 + 2.0 * np.pi * 3.0**2  # the base does not move
    assert (high - low) / 0.1 == pytest.approx(area, rel=0.01)


def test_element_size_too_coarse_for_the_sample_is_refused():
    with pytest.raises(MeshError, match=r"too coarse.*choose a smaller mesh element size"):
        mesh_solid(*grid("dome"), 2.5 * MM)


def test_element_worse_than_allowed_is_refused_with_its_place(monkeypatch):
    monkeypatch.setattr(hexahedral, "LEAST_JACOBIAN", 0.95)
    message = (
        r"elements of 0.8 mm have a scaled Jacobian below 0.95, the worst 0\.\d+ at \(.*: choose "
        "another mesh: element_size_mm"
    )
    with pytest.raises(MeshError, match=message):
        mesh_solid(*grid("dome"), 0.8 * MM)


def test_spike_in_the_distance_is_meshed_with_a_warning_that_names_its_place(caplog):
    distance, origin, spacing = grid("capped_block")
    spoilt = distance.copy()
    spoilt[30:44, 28, 20] = 0.2 * MM  # a needle of 3.5 mm from outside, at y = 0 and z = 2
    mesh = mesh_solid(spoilt, origin, spacing, 0.5 * MM)
    assert scaled_jacobian(mesh).min() > 0.2
    assert "times as fast as a distance" in caplog.text
    caplog.clear()
    distance[30:44, 28, round((-1.0 * MM - origin[2]) / spacing)] = 0.2 * MM  # below the base
    mesh_solid(distance, origin, spacing, 0.8 * MM)
    assert caplog.text == ""
