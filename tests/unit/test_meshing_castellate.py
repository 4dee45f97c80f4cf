"""The core's surface is one closed sheet, judged by its edges and by the faces around its nodes."""

from collections import Counter

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from softsample.errors import MeshError
from softsample.meshing.castellate import add_buffer, castellated_mesh, clean_core, core_cells
from softsample.meshing.quality import element_volumes


def rough_core(seed):
    """Blob of cells with noise strong enough to make spikes, pits and diagonal contacts."""
    rng = np.random.default_rng(seed)
    x, y, z = np.meshgrid(*[np.arange(n) + 0.5 for n in (14, 13, 9)], indexing="ij")
    depth = 5.0 - np.sqrt((x - 7.0) ** 2 + (y - 6.5) ** 2 + (0.7 * z) ** 2)
    return depth + 5.0 * gaussian_filter(rng.normal(size=depth.shape), 0.7)


def edges_of(quad):
    return [tuple(sorted((quad[i], quad[i - 1]))) for i in range(4)]


def sheets_at_nodes(quads):
    """Number of fans of faces around each node: 1 everywhere on a manifold surface."""
    fans = {}
    for quad in quads.tolist():
        for i in range(4):
            fans.setdefault(quad[i], []).append({quad[i - 1], quad[(i + 1) % 4]})
    for node, links in fans.items():
        groups = []
        for link in links:
            touching = [group for group in groups if group & link]
            groups = [group for group in groups if not group & link]
            groups.append(link.union(*touching))
        fans[node] = len(groups)
    return fans


@pytest.mark.parametrize("seed", range(6))
def test_cleaned_core_has_a_manifold_surface(seed):
    depth = rough_core(seed)
    cells = clean_core(depth > 0.0, depth, -0.3)
    assert cells.sum() > 0.5 * (depth > 0.0).sum()  # it may not win by throwing all away
    quads = castellated_mesh(cells, np.zeros(3), 1.0).boundary_quads
    assert set(Counter(e for quad in quads.tolist() for e in edges_of(quad)).values()) == {2}
    assert set(sheets_at_nodes(quads).values()) == {1}


def test_rough_core_would_not_be_manifold_without_cleaning():
    """The test above would pass on anything if the noise were too weak."""
    quads = castellated_mesh(rough_core(1) > 0.0, np.zeros(3), 1.0).boundary_quads
    assert max(sheets_at_nodes(quads).values()) > 1


def test_spike_goes_and_pit_is_filled():
    cells = np.zeros((8, 8, 8), dtype=bool)
    cells[1:7, 1:7, :6] = True
    spiky = cells.copy()
    spiky[3, 3, 6] = True
    spiky[4, 4, 4:6] = False
    np.testing.assert_array_equal(clean_core(spiky, np.where(cells, 1.0, 0.1), 0.5), cells)


def test_single_layer_on_the_base_is_no_spike():
    """It goes on below the base plane as far as the clean-up is concerned."""
    plate = np.zeros((6, 6, 3), dtype=bool)
    plate[1:5, 1:5, 0] = True
    np.testing.assert_array_equal(clean_core(plate, np.where(plate, 1.0, 0.1), 0.5), plate)


def test_buffer_layer_wraps_sides_and_top_but_not_the_base():
    mesh, inner = add_buffer(castellated_mesh(np.ones((3, 2, 2), bool), np.zeros(3), 1.0))
    assert len(mesh.hexes) == 12 + 2 * (3 * 2 + 2 * 2) + 3 * 2
    outer = np.arange(len(mesh.points) - len(inner), len(mesh.points))
    np.testing.assert_array_equal(mesh.points[outer], mesh.points[inner])
    moved = mesh.points.copy()  # pull the outer nodes away from the middle of the base
    moved[outer] += 0.2 * (moved[outer] - [1.5, 1.0, 0.0])
    volume = element_volumes(type(mesh)(moved, mesh.hexes))
    assert volume.min() > 0.0
    assert volume.sum() == pytest.approx(1.2**3 * 12.0)  # the block, 1.2 times as large


def sphere(centre, radius):
    return lambda points: radius - np.linalg.norm(points - centre, axis=1)


def test_too_coarse_elements_are_refused():
    with pytest.raises(MeshError, match=r"2 mm are too coarse.*smaller mesh element size"):
        core_cells(sphere([0, 0, 0], 4e-3), np.full(3, -4e-3), np.full(3, 4e-3), 2e-3, 1.0)


def test_sample_that_floats_above_the_base_is_refused():
    with pytest.raises(MeshError, match="does not reach down to the base plane"):
        core_cells(sphere([0, 0, 9e-3], 4e-3), np.full(3, -4e-3), np.full(3, 13e-3), 0.5e-3, 1.0)
