"""No-slip contact with rigid platens: where nodes end, what they carry, when they let go."""

from dataclasses import replace

import numpy as np
import pytest

import naive
from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.boundary import (
    Boundary,
    ContactSettings,
    glued_boundary,
    platen_boundary,
)
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.fem.motion import BASE, FREE, PLATEN
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.mesh import HexMesh

SETTINGS = SolverSettings(precision="float64", loading_time_s=0.08)
DOWN = np.array([0.0, 0.0, -1.0])


def tilted(mesh, normal, direction=DOWN, release=False):
    """Platen with outward `normal` that just touches the mesh before it travels."""
    b = platen_boundary(mesh, ContactSettings(base_platen=False))
    normal = np.asarray(normal) / np.linalg.norm(normal)
    plane = np.array([*normal, (mesh.points @ normal).max()])
    direction = np.asarray(direction) / np.linalg.norm(direction)
    return Boundary(b.held, b.candidates, np.array([b.planes[0], plane]), direction, release)


def beyond(mesh, run, boundary, nodes, holder=PLATEN):
    """Distance of nodes behind a platen at the end of a run [m]; the base does not travel."""
    plane = boundary.planes[holder - 1]
    offset = plane[3]
    if holder == PLATEN:
        offset += run.displacement[-1] * boundary.direction @ plane[:3]
    return (mesh.points[nodes] + run.displacement_field[nodes]) @ plane[:3] - offset


def test_nodes_on_a_tilted_platen_end_on_its_plane(crooked, tissue):
    boundary = tilted(crooked, [0.12, -0.07, 1.0])
    run = ExplicitModel(crooked, SETTINGS).run(tissue, boundary, 6e-4)
    touching = np.flatnonzero(run.held == PLATEN)
    assert 4 < len(touching) < 20  # part of the top
    np.testing.assert_allclose(beyond(crooked, run, boundary, touching), 0.0, atol=1e-15)
    free = boundary.candidates[run.held[boundary.candidates] == FREE]
    assert beyond(crooked, run, boundary, free).max() <= 0.0
    assert np.abs(run.displacement_field[touching][:, :2]).max() > 1e-5  # where they touched


def test_force_of_a_tilted_platen_is_that_of_bonded_nodes_in_equilibrium(crooked, tissue):
    """Newton's method with the touching nodes held where they ended finds the same forces."""
    boundary = tilted(crooked, [0.12, -0.07, 1.0])
    model = ExplicitModel(crooked, replace(SETTINGS, loading_time_s=0.3))
    run = model.run(tissue, boundary, 6e-4)

    def force_of(u):
        return model.internal_force(u, tissue)[0]

    exact = naive.equilibrium(force_of, run.displacement_field, run.held == FREE, 1e-11)
    force = force_of(exact)[run.held == PLATEN].sum(axis=0)
    assert run.force[-1] == pytest.approx(force @ boundary.direction, rel=2e-3)
    assert run.platen_force[-1] == pytest.approx(force @ boundary.direction, rel=5e-3)


def test_contact_knows_no_preferred_direction(block, tissue):
    """The whole test turned by 30 degrees about an odd axis gives the same curve."""
    axis = np.array([1.0, 2.0, -0.5]) / np.linalg.norm([1.0, 2.0, -0.5])
    cross = np.cross(np.eye(3), axis)
    Q = np.eye(3) + np.sin(0.52) * cross + (1.0 - np.cos(0.52)) * cross @ cross
    np.testing.assert_allclose(Q @ Q.T, np.eye(3), atol=1e-12)
    upright = platen_boundary(block, ContactSettings(release=False))
    planes = upright.planes.copy()
    planes[:, :3] = planes[:, :3] @ Q.T
    turned = replace(upright, planes=planes, direction=Q @ upright.direction)
    curves = [
        ExplicitModel(mesh, SETTINGS).run(tissue, boundary, 7e-4)
        for mesh, boundary in (
            (block, upright),
            (HexMesh(block.points @ Q.T, block.hexes), turned),
        )
    ]
    peak = curves[0].force.max()
    # the step estimate starts from random numbers in space, hence another time step
    np.testing.assert_allclose(curves[1].force, curves[0].force, atol=2e-3 * peak)


def test_flat_top_in_contact_is_the_glued_top(tissue):
    """A platen that meets the whole top at once: nodes stick within the first step."""
    mesh = mesh_cuboid(6e-3, 5e-3, 4e-3, 1e-3)
    model = ExplicitModel(mesh, SETTINGS)
    glued = model.run(tissue, glued_boundary(mesh, "compression", mesh.glued(0.0)), 1e-3)
    touching = model.run(tissue, platen_boundary(mesh, ContactSettings()), 1e-3)
    peak = glued.force.max()
    np.testing.assert_allclose(touching.force, glued.force, atol=1e-3 * peak)
    assert np.all(touching.held[mesh.glued(0.0)] == PLATEN)


def test_no_force_before_the_platen_arrives(tissue):
    """A gap of 0.4 mm shifts the curve by 0.4 mm."""
    mesh = mesh_cuboid(6e-3, 5e-3, 4e-3, 1e-3)
    model = ExplicitModel(mesh, replace(SETTINGS, curve_points=70, loading_time_s=0.2))
    contact = ContactSettings()
    late = model.run(tissue, platen_boundary(mesh, contact, gap=0.4e-3), 1.4e-3)
    prompt = model.run(tissue, platen_boundary(mesh, contact), 1e-3)
    waiting = late.displacement < 0.4e-3 - 1e-9
    np.testing.assert_array_equal(late.force[waiting], 0.0)
    shifted = np.interp(late.displacement - 0.4e-3, prompt.displacement, prompt.force)
    np.testing.assert_allclose(late.force, shifted, atol=0.02 * prompt.force.max())


def test_contact_starts_at_the_highest_node(crooked, tissue):
    boundary = platen_boundary(crooked, ContactSettings())
    assert boundary.planes[1, 3] == crooked.points[:, 2].max()
    run = ExplicitModel(crooked, SETTINGS).run(tissue, boundary, 3e-4)
    assert np.all(run.force[1:] > 0.0)
    slope = np.diff(run.force)
    assert slope[:5].mean() < 0.4 * slope[-5:].mean()  # one node carries less than many


def pressing(mesh, model, material, run, boundary):
    """Normal force with which the platen presses on each touching node at the end [N]."""
    force, _ = model.internal_force(run.displacement_field, material)
    return -force[run.held == PLATEN] @ boundary.planes[PLATEN - 1, :3]


def test_pulled_nodes_let_go_of_the_platen(tissue):
    """Pressed a little and sheared a lot, one edge of the top is pulled up."""
    mesh = mesh_cuboid(6e-3, 4e-3, 5e-3, 1e-3)
    model = ExplicitModel(mesh, replace(SETTINGS, loading_time_s=0.3))
    runs = {}
    for release in (False, True):
        boundary = tilted(mesh, [0.0, 0.0, 1.0], [1.0, 0.0, -0.12], release)
        runs[release] = model.run(tissue, boundary, 1.5e-3)
    bonded, released = runs[False], runs[True]
    top = mesh.glued(0.0)
    assert np.all(bonded.held[top] == PLATEN)
    assert pressing(mesh, model, tissue, bonded, boundary).min() < 0.0  # some are pulled
    gone = top[released.held[top] == FREE]
    assert 0 < len(gone) < len(top)
    assert np.all(mesh.points[gone, 0] > 0.0)  # the leading edge, by the moment of the shear force
    press = pressing(mesh, model, tissue, released, boundary)
    assert press.min() > 0.0
    assert beyond(mesh, released, boundary, gone).max() <= 0.0
    assert beyond(mesh, released, boundary, gone).min() < -1e-6


SOFT = OgdenMaterial((1000.0,), (2.0,), 0.45)


@pytest.fixture(scope="module")
def squashed():
    """A flat block at half its height, by the contact settings."""
    mesh = mesh_cuboid(6e-3, 4e-3, 4e-3, 0.5e-3)
    model = ExplicitModel(mesh, replace(SETTINGS, loading_time_s=0.05))
    runs = {}
    for walls, base in ((True, True), (False, False)):
        contact = ContactSettings(release=False, side_walls=walls, base_platen=base)
        boundary = platen_boundary(mesh, contact)
        runs[walls] = (boundary, model.run(SOFT, boundary, 2.2e-3))
    return mesh, runs


@pytest.mark.parametrize("holder", [BASE, PLATEN])
def test_bulging_side_walls_are_caught_by_both_platens(squashed, holder):
    mesh, runs = squashed
    ends = np.union1d(mesh.bottom, mesh.glued(0.0))
    walls = np.setdiff1d(mesh.boundary, ends)
    boundary, run = runs[True]
    caught = walls[run.held[walls] == holder]
    assert len(caught) > 10
    np.testing.assert_allclose(beyond(mesh, run, boundary, caught, holder), 0.0, atol=1e-12)
    free = walls[run.held[walls] == FREE]
    assert beyond(mesh, run, boundary, free, holder).max() <= 0.0


@pytest.mark.parametrize("holder", [BASE, PLATEN])
def test_side_walls_pass_the_platens_when_told_to(squashed, holder):
    mesh, runs = squashed
    _, run = runs[False]
    walls = np.setdiff1d(mesh.boundary, np.union1d(mesh.bottom, mesh.glued(0.0)))
    assert np.all(run.held[walls] == FREE)
    through = beyond(mesh, run, runs[True][0], walls, holder)
    assert through.max() > 1e-5


def test_both_ends_of_a_block_catch_alike(squashed):
    """The block is its own mirror image, so are the nodes that its platens catch."""
    mesh, runs = squashed
    _, run = runs[True]
    walls = np.setdiff1d(mesh.boundary, np.union1d(mesh.bottom, mesh.glued(0.0)))
    counts = [np.sum(run.held[walls] == holder) for holder in (BASE, PLATEN)]
    assert abs(counts[0] - counts[1]) <= 0.2 * max(counts)


def test_catching_costs_no_noticeable_energy(crooked, tissue):
    run = ExplicitModel(crooked, SETTINGS).run(
        tissue, platen_boundary(crooked, ContactSettings()), 8e-4
    )
    assert run.energy["imbalance"] < 0.01
