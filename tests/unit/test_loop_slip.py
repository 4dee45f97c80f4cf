"""Friction pulls the other way on unloading: the loop of a slipping sample."""

from dataclasses import replace

import numpy as np
import pytest

import laboratory
from softsample.constitutive.ogden import unit_modulus
from softsample.fem.boundary import ContactSettings
from softsample.fem.explicit import SolverSettings
from softsample.loop.effects import library
from softsample.loop.model import Material, Model, State
from softsample.loop.specimen import Specimen
from softsample.meshing.cuboid import mesh_cuboid
from softsample.response.curves import ResponseCurves
from softsample.response.elastic import Elastic
from softsample.response.perturbations import simulate_perturbations
from softsample.response.pieces import MechanicalTest, MeshedSample, PerturbationSettings

SLIP = library()["platen_slip"]
RUBBING = 0.6  # share of the slip in the run with friction
DEPTH = 0.1  # of its loop, over the force at the turn
MATERIAL = Material(1000.0, 0.7)


def cycle(*turns):
    """Noiseless test of a linear solid of 1 N/mm per kPa to each turn [mm] and back."""
    travel = np.concatenate(
        [np.concatenate([np.linspace(0, u, 101), np.linspace(u, 0, 101)[1:]]) for u in turns]
    )
    phase = np.tile(np.repeat(["ramp", "unloading"], [101, 100]), len(turns))
    grid = np.linspace(0.0, 4e-3, 81)
    way = grid / grid[-1]
    changes = {
        "platen_slip": -0.2 * grid,
        "platen_friction_0.1": -0.2 * RUBBING * grid,
        "platen_friction_0.1_loop": -DEPTH * grid[-1] * 4.0 * way * (1.0 - way),
    }
    curves = ResponseCurves(np.array([0.5]), grid, grid[None])
    elastic = Elastic(curves, laboratory.alike(curves, changes), contact=True)
    time = np.arange(len(travel), dtype=float)
    return Specimen("C", "compression", time, 1e-3 * travel, 0.0 * time, phase, elastic)


def force(specimen, share):
    """Force [N] with a share of the slip."""
    return Model((SLIP,)).predict(specimen, State(MATERIAL, {"platen_slip": {"share": share}}))


def lost(specimen, share):
    """Work that a cycle does not give back [J]."""
    return np.trapezoid(force(specimen, share), specimen.travel)


@pytest.mark.parametrize("share", [0.0, 0.3, RUBBING, 1.0])
def test_loading_loses_the_share_of_what_is_lost_without_friction(share):
    specimen = cycle(3.0)
    ramp = specimen.phase == "ramp"
    np.testing.assert_allclose(
        force(specimen, share)[ramp], (1.0 - 0.2 * share) * specimen.travel[ramp] * 1e3, atol=1e-12
    )


def test_a_cycle_loses_work_unless_nothing_slides_or_nothing_rubs():
    specimen = cycle(3.0)
    most = lost(specimen, RUBBING)
    # two thirds of the depth of a parabola times its width
    assert most == pytest.approx(2.0 / 3.0 * DEPTH * 3.0 * 3e-3, rel=1e-3)
    for share in (0.1, 0.3, 0.8, 0.95):
        assert 0.0 < lost(specimen, share) < most
    for share in (0.0, 1.0):
        assert abs(lost(specimen, share)) < 1e-9 * most


def test_the_loop_begins_at_the_turn_and_ends_at_the_start():
    specimen = cycle(3.0)
    loop = force(specimen, RUBBING) - (1.0 - 0.2 * RUBBING) * specimen.travel * 1e3
    assert abs(loop[[100, -1]]).max() < 1e-12
    assert abs(np.diff(loop)).max() < 0.05 * DEPTH * 3.0  # no step
    assert loop.min() == pytest.approx(-DEPTH * 3.0, rel=1e-3)


def test_a_second_larger_cycle_has_a_larger_loop_and_loads_as_the_first_did():
    specimen = cycle(1.0, 3.0)
    np.testing.assert_allclose(
        force(specimen, RUBBING)[-201:], force(cycle(3.0), RUBBING), atol=1e-12
    )
    assert lost(cycle(1.0), RUBBING) == pytest.approx(lost(cycle(3.0), RUBBING) / 9.0, rel=1e-3)


def test_between_two_runs_the_loop_is_between_theirs():
    """A second run that slips a fifth as much has a loop of half the depth, deepest earlier."""
    specimen = cycle(3.0)
    variants, curves = specimen.elastic.perturbations, specimen.elastic.curves
    grid = curves.displacement
    way = grid / grid[-1]
    rough = -0.5 * DEPTH * grid[-1] * 6.75 * way * (1.0 - way) ** 2
    weaker = {
        "platen_friction_0.3": 0.2 * variants["platen_friction_0.1"].curve(0.5),
        "platen_friction_0.3_loop": rough,
    }
    both = {**variants, **laboratory.alike(curves, weaker)}
    specimen = replace(specimen, elastic=replace(specimen.elastic, perturbations=both))
    less = 0.2 * RUBBING

    def loop(share):
        return force(specimen, share) - (1.0 - 0.2 * share) * specimen.travel * 1e3

    assert loop(less).min() == pytest.approx(-0.5 * DEPTH * 3.0, rel=1e-3)
    assert specimen.travel[np.argmin(loop(less))] == pytest.approx(1e-3, abs=3e-5)
    assert loop(RUBBING).min() == pytest.approx(-DEPTH * 3.0, rel=1e-3)
    for low, high in ((less, RUBBING), (0.0, less), (RUBBING, 1.0)):
        middle = 0.5 * (loop(low) + loop(high))
        np.testing.assert_allclose(loop(0.5 * (low + high)), middle, atol=1e-12)


@pytest.mark.parametrize("names", [(), ("platen_slip",)])
def test_a_model_without_a_run_that_comes_back_has_no_loop(names):
    specimen = cycle(3.0)
    kept = {name: specimen.elastic.perturbations[name] for name in names}
    without = replace(specimen, elastic=replace(specimen.elastic, perturbations=kept))
    assert abs(lost(without, RUBBING)) < 1e-12


def test_simulated_friction_loses_work_between_sticking_and_sliding():
    """On a cube of 4 x 4 x 4 elements; the work lost is the area of the loop."""
    mesh = mesh_cuboid(0.01, 0.01, 0.01, 0.0025)
    sample = MeshedSample(mesh, mesh.glued(0.0))
    solid = unit_modulus(0.5, (2.0, 4.0), 0.49, 1000.0)
    solver = SolverSettings(loading_time_s=0.08, curve_error_percent=1.0)

    def changes(*frictions):
        steps = PerturbationSettings(frictions=frictions)
        test = MechanicalTest("compression", solid, 2e-3, ContactSettings(), solver, steps)
        return simulate_perturbations(lambda _: sample, test)

    travel, found = changes(0.1, 0.0)
    slip, rubbing, loop = (
        found[n] for n in ("platen_slip", "platen_friction_0.1", "platen_friction_0.1_loop")
    )
    assert slip[-1] < rubbing[-1] < 0.0
    assert loop[-1] == 0.0
    area = np.trapezoid(loop, travel)
    assert area < 0.05 * np.trapezoid(slip, travel) < 0.0
    assert loop.max() < 0.01 * abs(slip[-1])
    assert found["platen_friction_0"][-1] == pytest.approx(slip[-1], rel=0.05)
    assert abs(np.trapezoid(found["platen_friction_0_loop"], travel)) < 0.05 * abs(area)
