"""Meshes that are fine below an indenter."""

import numpy as np
import pytest

from softsample.errors import MeshError
from softsample.meshing.graded import GROWTH, graded, graded_hexes
from softsample.meshing.quality import element_volumes, scaled_jacobian
from softsample.meshing.sample import indented_hexes
from softsample.shapes import IdealShape, Indenter

CUBOID = IdealShape("cuboid", 20e-3, 16e-3, 12e-3)
CYLINDER = IdealShape("cylinder", 20e-3, 20e-3, 12e-3)


def test_lines_are_even_near_and_grow_by_little_beyond():
    line = graded(10e-3, 0.2e-3, 2e-3, 1e-3)
    steps = np.diff(line)
    assert (line[0], line[-1]) == (0.0, pytest.approx(10e-3))
    np.testing.assert_allclose(steps[:10], 0.2e-3)
    assert line[10] == pytest.approx(2e-3)
    assert (steps[1:] / steps[:-1]).max() < GROWTH + 1e-9
    assert steps.max() < 1.0001e-3


@pytest.mark.parametrize("shape", [CUBOID, CYLINDER], ids=lambda s: s.kind)
def test_a_graded_mesh_fills_the_sample_with_sound_elements(shape):
    mesh = graded_hexes(shape, 0.25e-3, 1.5e-3, 2e-3)
    polygon = 0.01 if shape.kind == "cylinder" else 1e-9  # circles are polygons
    assert element_volumes(mesh).sum() == pytest.approx(shape.volume, rel=polygon)
    assert scaled_jacobian(mesh).min() > 0.4
    top = mesh.points[mesh.points[:, 2] > shape.height - 1e-9]
    assert np.hypot(*top[:, :2].T).min() < 1e-9  # a node below the tip
    assert mesh.points[:, 2].min() == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("shape", [CUBOID, CYLINDER], ids=lambda s: s.kind)
def test_what_meets_a_punch_stands_for_its_area(shape):
    """A node stands for the area up to halfway to its neighbours; squares have ragged edges."""
    apart = 1e-6 if shape.kind == "cylinder" else 0.04
    radius = 3e-3
    fine = radius / 16
    mesh = indented_hexes(shape, 1e-3, Indenter("flat", radius))
    top = mesh.points[mesh.points[:, 2] > shape.height - 1e-9]
    away = np.hypot(*top[:, :2].T)
    edge = away[away <= radius * (1.0 + 1e-6)].max()
    assert edge + 0.5 * fine == pytest.approx(radius, rel=apart)


@pytest.mark.parametrize(("fine", "near"), [(0.0, 1e-3), (3e-3, 4e-3), (0.2e-3, 9.9e-3)])
def test_lengths_that_make_no_mesh_are_refused(fine, near):
    with pytest.raises(MeshError):
        graded_hexes(CYLINDER, fine, near, 2e-3)
