"""What the loop asks of the mechanics, each against an exact or an independent solution."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq, minimize

import naive
from softsample.constitutive.material import Relaxation
from softsample.constitutive.ogden import Fibres, OgdenMaterial
from softsample.errors import InputError, SimulationError
from softsample.fem import explicit
from softsample.fem.boundary import ContactSettings, glued_boundary, platen_boundary
from softsample.fem.explicit import ExplicitModel, Gravity, SolverSettings
from softsample.fem.motion import BASE, FREE, PLATEN
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.cylinder import mesh_cylinder
from softsample.meshing.mesh import HexMesh
from softsample.protocol import History
from spectral import energy as ogden_energy

SETTINGS = SolverSettings(precision="float64", loading_time_s=0.2, curve_points=20)
SMOOTH = ContactSettings(friction=0.0, base_friction=0.0)
MATERIAL = OgdenMaterial((900.0, 300.0), (-4.0, 6.0), 0.45)


@pytest.fixture(scope="module")
def small():
    """27 elements, 3 x 3 x 3 mm."""
    return mesh_cuboid(3e-3, 3e-3, 3e-3, 1e-3)


def energy(stretches, material):
    """Strain energy density [Pa] of a diagonal deformation gradient, fibres included."""
    F = np.diag(stretches)
    total = float(ogden_energy(F, OgdenMaterial(material.mu, material.alpha, 0.45)))
    for fibre in material.of_law("fibre"):
        along = np.asarray(fibre.direction)
        square = np.linalg.det(F) ** (-2.0 / 3.0) * along @ F.T @ F @ along
        total += 0.5 * fibre.modulus * (square - 1.0) ** 2
    return total


def uniaxial_stress(stretch, material):
    """Nominal stress [Pa] at an axial stretch, sides free of stress: least energy, differenced."""

    def least(axial):
        start = np.full(2, axial**-0.5)
        found = minimize(
            lambda sides: energy([*sides, axial], material), start, method="Nelder-Mead",
            options={"xatol": 1e-9, "fatol": 1e-12, "maxiter": 4000},
        )  # fmt: skip
        return found.fun

    step = 1e-4
    return (least(stretch + step) - least(stretch - step)) / (2.0 * step)


def compressed(mesh, material, travel, contact=SMOOTH, settings=SETTINGS, **options):
    model = ExplicitModel(mesh, settings, options.pop("stiffness", None))
    return model.run(material, platen_boundary(mesh, contact), travel, **options)


def end_stress(run, area):
    return -run.force[-1] / area


@pytest.mark.parametrize("fibres", [(), (Fibres(300.0, (0, 0, 1)),), (Fibres(2000.0, (1, 0, 0)),)])
def test_fibres_stiffen_as_their_energy_says(small, fibres):
    """Stiffer ones along the axis would buckle: smooth platens let the sample shear aside."""
    material = MATERIAL.plus(*fibres)
    run = compressed(small, material, 0.6e-3)
    assert end_stress(run, 9e-6) == pytest.approx(uniaxial_stress(0.8, material), rel=2e-3)


def test_fibres_are_the_same_in_vector_and_scalar_code(crooked):
    material = MATERIAL.plus(Fibres(1500.0, (1.0, 2.0, -0.5)))
    u = 0.1 * crooked.points[:, [1, 2, 0]] + 0.05 * crooked.points
    force, _ = ExplicitModel(crooked, SETTINGS).internal_force(u, material)
    scalar = ExplicitModel(crooked, replace(SETTINGS, backend="scalar"))
    wanted, _ = scalar.internal_force(u, material)
    np.testing.assert_allclose(force, wanted, atol=1e-12 * np.abs(wanted).max())
    # and forces are the slope of the energy
    rng = np.random.default_rng(0)
    v = 1e-7 * rng.standard_normal(u.shape)
    energies = [
        ExplicitModel(crooked, SETTINGS).internal_force(u + s * v, material)[1][:2].sum()
        for s in (-1, 1)
    ]
    assert np.diff(energies)[0] / 2.0 == pytest.approx(np.vdot(force, v), rel=1e-5)


def test_regions_side_by_side_share_the_load_by_stiffness_and_area(small):
    """Equal Poisson's ratios: no misfit at the interface, so the stretch is uniform."""
    left = small.points[small.hexes].mean(axis=1)[:, 0] < -0.4e-3
    stiffness = np.where(left, 3.0, 1.0)
    run = compressed(small, MATERIAL, 0.6e-3, stiffness=stiffness)
    wanted = uniaxial_stress(0.8, MATERIAL) * (3.0 * 3e-6 + 6e-6)
    assert -run.force[-1] == pytest.approx(wanted, rel=2e-3)


def test_cylinder_has_the_stress_of_the_cuboid():
    mesh = mesh_cylinder(4e-3, 3e-3, 0.5e-3)
    top = mesh.boundary_quads[np.all(mesh.points[mesh.boundary_quads][:, :, 2] > 2.99e-3, axis=1)]
    corners = mesh.points[top]
    diagonals = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    area = 0.5 * np.linalg.norm(np.cross(*diagonals), axis=1).sum()
    run = compressed(mesh, MATERIAL, 0.6e-3)
    assert end_stress(run, area) == pytest.approx(uniaxial_stress(0.8, MATERIAL), rel=2e-3)
    assert area == pytest.approx(np.pi * 4e-6, rel=0.03)


# --- friction, tilt, gap ------------------------------------------------------------------------


def sliding(mesh, friction):
    """A platen that presses and drags: 1 mm sideways while it comes down 0.4 mm."""
    contact = ContactSettings(friction=friction, side_walls=False)
    boundary = platen_boundary(mesh, contact)
    drag = np.array([1.0, 0.0, -0.4]) / np.hypot(1.0, 0.4)
    boundary = replace(boundary, direction=drag)
    return ExplicitModel(mesh, SETTINGS).run(MATERIAL, boundary, 1.08e-3)


@pytest.mark.parametrize("friction", [0.05, 0.2])
def test_sliding_sample_resists_with_friction_times_normal_force(small, friction):
    """Coulomb's law, once every node slides; the force on the sample is along the drag."""
    run = sliding(small, friction)
    along, normal = run.force_vector[-1, 0], run.force_vector[-1, 2]
    assert normal < -1e-3
    assert along == pytest.approx(-friction * normal, rel=0.02)
    assert abs(run.force_vector[-1, 1]) < 1e-3 * abs(normal)
    assert run.energy["imbalance"] < 5e-3


def test_much_friction_is_no_slip_and_none_is_no_drag(small):
    stuck, glued, smooth = (sliding(small, friction) for friction in (1e6, None, 0.0))
    # nodes that might slide count for the stable step, so that the two march in unlike steps
    np.testing.assert_allclose(stuck.force, glued.force, atol=5e-3 * np.abs(glued.force).max())
    drag = smooth.force_vector[:, 0]
    assert np.abs(drag).max() < 1e-3 * np.abs(smooth.force_vector[:, 2]).max()


def test_friction_lies_between_slip_and_no_slip(small):
    forces = [
        compressed(small, MATERIAL, 0.6e-3, ContactSettings(friction=f, base_friction=f)).force[-1]
        for f in (0.0, 0.05, 0.2, 1.0)
    ]
    glued = compressed(small, MATERIAL, 0.6e-3, ContactSettings()).force[-1]
    assert np.all(np.diff([*forces, glued]) >= -1e-3 * glued)
    assert forces[0] < 0.9 * glued


def test_tilted_platen_on_a_top_of_the_same_tilt_is_a_glued_top(small):
    slope = np.tan(np.deg2rad(5.0))
    points = small.points.copy()
    points[:, 2] *= 1.0 - slope * points[:, 0] / 3e-3
    mesh = HexMesh(points, small.hexes)
    model = ExplicitModel(mesh, SETTINGS)
    pressed = model.run(
        MATERIAL, platen_boundary(mesh, ContactSettings(), tilt_deg=(0.0, 5.0)), 0.4e-3
    )
    top = np.flatnonzero(small.points[:, 2] > 2.99e-3)
    glued = model.run(MATERIAL, glued_boundary(mesh, "compression", top), 0.4e-3)
    assert np.all(pressed.held[top] == PLATEN)
    np.testing.assert_allclose(pressed.force, glued.force, atol=2e-3 * np.abs(glued.force).max())


@pytest.mark.parametrize(("tilt", "axis", "side"), [((0.0, 4.0), 0, 1), ((4.0, 0.0), 1, -1)])
def test_tilted_platen_meets_the_high_side_first(small, tilt, axis, side):
    """By the geometry: a node is reached when the plane has come down to it, to first order."""
    boundary = platen_boundary(small, ContactSettings(), tilt_deg=tilt)
    run = ExplicitModel(small, SETTINGS).run(MATERIAL, boundary, 0.1e-3)
    top = np.flatnonzero(small.points[:, 2] > 2.99e-3)
    gap = np.tan(np.deg2rad(4.0)) * (1.5e-3 + side * small.points[top, axis] * -1.0)
    lowered = 0.1e-3
    reached = run.held[top] == PLATEN
    assert 0 < reached.sum() < len(top)
    assert np.all(reached[gap < 0.5 * lowered])
    assert not np.any(reached[gap > 1.2 * lowered])


def test_gap_shifts_the_curve(small):
    model = ExplicitModel(small, SETTINGS)
    near = model.run(MATERIAL, platen_boundary(small, ContactSettings()), 0.4e-3)
    far = model.run(MATERIAL, platen_boundary(small, ContactSettings(), gap=0.1e-3), 0.5e-3)
    moved = np.interp(near.displacement + 0.1e-3, far.displacement, far.force)
    np.testing.assert_allclose(moved, near.force, atol=0.01 * np.abs(near.force).max())
    assert np.all(np.abs(far.force[far.displacement < 0.09e-3]) < 1e-12)


# --- glue and weight, against the equilibrium of the twin -----------------------------------------


def static(mesh, material, held, displacement, load):
    """Equilibrium of the twin: displacements and nodal forces of what holds the sample."""
    twin = naive.Twin(mesh, SETTINGS.hourglass_coefficient)

    def residual(u):
        return twin.internal_force(u, material)[0] - load

    u = naive.equilibrium(residual, displacement, ~held, 1e-9)
    return u, residual(u)


def test_partly_glued_top_is_the_equilibrium_of_the_twin(small):
    top = small.glued(0.0)
    kept = top[small.points[top, 0] > -1e-3]
    run = ExplicitModel(small, SETTINGS).run(
        MATERIAL, glued_boundary(small, "tension", kept), 0.5e-3
    )
    held = np.zeros(len(small.points), bool)
    held[kept] = held[small.bottom] = True
    start = small.points * [0.0, 0.0, 0.5 / 3.0]
    u, forces = static(small, MATERIAL, held, start, 0.0)
    assert run.force[-1] == pytest.approx(forces[kept, 2].sum(), rel=2e-3)
    np.testing.assert_allclose(run.displacement_field, u, atol=2e-3 * np.abs(u).max())


SOFT = OgdenMaterial((100.0,), (2.0,), 0.45)


def weights(mesh, gravity):
    """Nodal weights [N]."""
    mass = naive.Twin(mesh, 0.0).mass(gravity.density_kg_m3)
    return mass[:, None] * np.asarray(gravity.acceleration)


def test_free_top_sags_as_the_twin_and_the_base_carries_the_weight(small):
    gravity = Gravity()
    model = ExplicitModel(small, replace(SETTINGS, loading_time_s=0.4))
    boundary = platen_boundary(small, ContactSettings(), gap=1e-3)
    run = model.run(SOFT, boundary, 1e-6, gravity=replace(gravity, settle_first=False))
    held = np.zeros(len(small.points), bool)
    held[small.bottom] = True
    load = weights(small, gravity)
    u, forces = static(small, SOFT, held, np.full_like(small.points, 1e-9), load)
    assert u[:, 2].min() < -0.05e-3
    np.testing.assert_allclose(run.displacement_field, u, atol=0.01 * np.abs(u).max())
    assert run.base_force[-1] == pytest.approx(load[:, 2].sum(), rel=0.01)
    assert run.force[-1] == pytest.approx(0.0, abs=0.01 * abs(load[:, 2].sum()))
    np.testing.assert_allclose(forces[held].sum(axis=0), -load.sum(axis=0), atol=1e-9)


def test_untared_weight_is_half_and_half_and_gone_if_glued_after_settling(small):
    """Glued at both ends before it settles each end carries half of it; glued afterwards none."""
    weight = float(weights(small, Gravity())[:, 2].sum())
    boundary = glued_boundary(small, "tension", small.glued(0.0))
    model = ExplicitModel(small, replace(SETTINGS, loading_time_s=0.4))
    before, after = (
        model.run(SOFT, boundary, 0.3e-3, gravity=Gravity(settle_first=first))
        for first in (False, True)
    )
    assert before.force[0] == pytest.approx(-0.5 * weight, rel=0.03)
    assert after.force[0] == pytest.approx(0.0, abs=0.01 * abs(weight))
    light = model.run(SOFT, boundary, 0.3e-3)
    tared = before.force - before.force[0]
    np.testing.assert_allclose(tared, light.force, atol=0.02 * light.force.max())


def test_a_gap_is_kept_above_the_settled_top(small):
    model = ExplicitModel(small, replace(SETTINGS, loading_time_s=0.4))
    touching, late = (
        model.run(
            SOFT, platen_boundary(small, ContactSettings(), gap=gap), travel, gravity=Gravity()
        )
        for gap, travel in ((0.0, 0.2e-3), (0.1e-3, 0.3e-3))
    )
    shifted = np.interp(late.displacement - 0.1e-3, touching.displacement, touching.platen_force)
    scale = np.abs(touching.platen_force).max()
    np.testing.assert_allclose(late.platen_force, shifted, atol=0.03 * scale)
    assert np.abs(late.platen_force[late.displacement < 0.09e-3]).max() < 0.01 * scale


def test_platen_is_brought_to_the_settled_top(small):
    """Zero travel is then the first touch of the sagged sample, not of the unloaded one."""
    model = ExplicitModel(small, replace(SETTINGS, loading_time_s=0.4))
    boundary = platen_boundary(small, ContactSettings())
    settled, unaware = (
        model.run(SOFT, boundary, 0.2e-3, gravity=Gravity(settle_first=first))
        for first in (True, False)
    )
    touched = [
        run.displacement[np.argmax(np.abs(run.platen_force) > 0.02 * np.abs(run.force).max())]
        for run in (settled, unaware)
    ]
    assert touched[0] < touched[1]
    assert settled.force[-1] > unaware.force[-1] > 0.0


# --- histories, relaxation ------------------------------------------------------------------------

UP_HOLD_DOWN = History(np.array([0.0, 2.0, 5.0, 7.0]), np.array([0.0, 0.5e-3, 0.5e-3, 0.0]))


def test_elastic_sample_forgets_its_history(small):
    run = ExplicitModel(small, SETTINGS).run(
        MATERIAL, glued_boundary(small, "tension", small.glued(0.0)), UP_HOLD_DOWN
    )
    up, hold, down = (run.force[a : a + 21] for a in (0, 20, 40))
    np.testing.assert_allclose(run.time[[0, 20, 40, 60]], UP_HOLD_DOWN.time)
    np.testing.assert_allclose(run.displacement[[0, 20, 40, 60]], UP_HOLD_DOWN.travel)
    peak = up.max()
    np.testing.assert_allclose(hold, peak, rtol=2e-3)
    np.testing.assert_allclose(down[::-1], up, atol=3e-3 * peak)


def test_pushed_then_sheared_is_sheared_then_pushed(small):
    """The force of an elastic sample is that of its shape, on whichever way it got there."""
    model, glued = ExplicitModel(small, SETTINGS), small.glued(0.0)
    shear = glued_boundary(small, "shear", glued)
    push = replace(shear, direction=np.array([0.0, 0.0, -1.0]))

    def ended(first, travel, second, further):
        there = model.run(MATERIAL, first, travel)
        return model.run(MATERIAL, second, further, start=there.displacement_field)

    one, other = ended(push, 0.3e-3, shear, 1e-3), ended(shear, 1e-3, push, 0.3e-3)
    peak = np.abs(one.force_vector[-1]).max()
    np.testing.assert_allclose(one.force_vector[-1], other.force_vector[-1], atol=5e-3 * peak)
    assert one.force_vector[0, 2] < -0.1 * peak  # it begins compressed
    assert other.force_vector[0, 0] > 0.1 * peak
    assert one.energy["imbalance"] < 1e-3
    assert other.energy["strain"] == pytest.approx(one.energy["strain"], rel=5e-3)


def relaxing_stress(time, stretch, material):
    """Nominal stress history [Pa] of a uniaxial test, from the hereditary integral itself.

    S_iso(t) = (1 - sum g) S0(t) + sum g int exp(-(t - s)/tau) dS0(s) with midpoint kernels, S0
    from differences of the energy; the lateral stretch makes the lateral stress vanish.
    """
    g, tau = material.relaxation.g, material.relaxation.tau_s
    isochoric = replace(material, relaxation=None)
    bulk = material.bulk_modulus

    def elastic(lateral, axial):
        """Isochoric second Piola-Kirchhoff stress (lateral, axial) by differences."""
        step = 1e-6

        def w(a, b):
            J = a * a * b
            return float(ogden_energy(np.diag([a, a, b]), isochoric)) - 0.5 * bulk * (J - 1) ** 2

        side = (w(lateral + step, axial) - w(lateral - step, axial)) / (4.0 * step * lateral)
        along = (w(lateral, axial + step) - w(lateral, axial - step)) / (2.0 * step * axial)
        return np.array([side, along])

    past, stresses, nominal = [], [np.zeros(2)], [0.0]
    for n in range(1, len(time)):
        axial = stretch[n]
        kernels = [
            [np.exp(-(time[n] - 0.5 * (time[k] + time[k - 1])) / t) for t in tau]
            for k in range(1, n + 1)
        ]
        share = np.array([sum(gi * ki for gi, ki in zip(g, row, strict=True)) for row in kernels])
        old = sum((share[k] * past[k] for k in range(n - 1)), np.zeros(2))

        def total(lateral, old=old, share=share, axial=axial):
            S0 = elastic(lateral, axial)
            S = (1.0 - sum(g)) * S0 + old + share[-1] * (S0 - stresses[-1])
            J = lateral**2 * axial
            return S + bulk * (J - 1.0) * J / np.array([lateral**2, axial**2]), S0

        lateral = brentq(lambda a: total(a)[0][0], 0.8, 1.3)
        S, S0 = total(lateral)
        past.append(S0 - stresses[-1])
        stresses.append(S0)
        nominal.append(axial * S[1])
    return np.array(nominal)


def test_relaxation_is_the_hereditary_integral(small):
    """Ramp, hold and unloading of a uniform compression; two relaxation times, large strain."""
    relaxation = Relaxation((0.3, 0.25), (0.7, 4.0))
    material = replace(MATERIAL, relaxation=relaxation)
    run = compressed(small, material, UP_HOLD_DOWN)
    time = np.linspace(0.0, 7.0, 281)
    stretch = 1.0 - np.interp(time, UP_HOLD_DOWN.time, UP_HOLD_DOWN.travel) / 3e-3
    wanted = 9e-6 * relaxing_stress(time, stretch, material)
    pressed = run.time < 6.0  # later the sample lets go of the platen
    exact = np.interp(run.time[pressed], time, wanted)
    np.testing.assert_allclose(-run.force[pressed], exact, atol=4e-3 * np.abs(exact).max())
    elastic = compressed(small, MATERIAL, UP_HOLD_DOWN)
    assert run.force[40] < 0.75 * elastic.force[40]


def test_relaxation_goes_by_the_clock_of_the_test(small):
    """The same history ten times as fast, with times ten times as short, is the same curve."""
    slow = replace(MATERIAL, relaxation=Relaxation((0.4,), (3.0,)))
    fast = replace(MATERIAL, relaxation=Relaxation((0.4,), (0.3,)))
    boundary = glued_boundary(small, "shear", small.glued(0.0))
    model = ExplicitModel(small, SETTINGS)
    one = model.run(slow, boundary, UP_HOLD_DOWN)
    ten = model.run(fast, boundary, History(0.1 * UP_HOLD_DOWN.time, UP_HOLD_DOWN.travel))
    np.testing.assert_allclose(ten.force, one.force, atol=1e-9 * one.force.max())


def test_a_platen_that_does_not_reach_the_sample_is_named(small):
    boundary = platen_boundary(small, ContactSettings(), gap=1e-3)
    with pytest.raises(
        SimulationError, match=r"nothing was strained in 0.1 mm of displacement.*gap"
    ):
        ExplicitModel(small, SETTINGS).run(MATERIAL, boundary, 0.1e-3)


def test_elements_that_are_crushed_end_a_run(small, monkeypatch):
    monkeypatch.setattr(explicit, "LEAST_STEP", 0.9)
    boundary = platen_boundary(small, ContactSettings())
    with pytest.raises(
        SimulationError, match=r"has shrunk to .* s at .*raise solver: loading_time_s"
    ):
        ExplicitModel(small, SETTINGS).run(MATERIAL, boundary, 1.2e-3)


def test_a_mesh_without_a_free_node_is_refused():
    flat = mesh_cuboid(3e-3, 3e-3, 0.5e-3, 0.5e-3)
    with pytest.raises(
        SimulationError, match="no node is free to move; lower mesh: element_size_mm"
    ):
        ExplicitModel(flat, SETTINGS).run(
            MATERIAL, glued_boundary(flat, "tension", flat.glued(0.0)), 0.1e-3
        )


@pytest.mark.parametrize("times", [[0.0, 1.0], [0.5, 0.5], [1.0, 0.5], [0.5, 2.0]])
def test_times_of_snapshots_that_are_none_of_the_test_are_refused(small, times):
    boundary = glued_boundary(small, "shear", small.glued(0.0))
    with pytest.raises(InputError, match="do not ascend from above 0 to 1 s"):
        ExplicitModel(small, SETTINGS).run(MATERIAL, boundary, 0.1e-3, snapshots=times)


def test_a_snapshot_has_the_travel_at_which_its_nodes_are(small):
    """A step is 1 % of this short run, so that the travel of the step before would be off."""
    boundary = glued_boundary(small, "shear", small.glued(0.0))
    model = ExplicitModel(small, SETTINGS)
    for snapshot in model.run(MATERIAL, boundary, 0.5e-3, snapshots=[0.2, 0.5, 0.6]).snapshots:
        glued = snapshot.displacement[snapshot.held == PLATEN]
        np.testing.assert_allclose(glued @ boundary.direction, snapshot.travel, rtol=1e-4)


def test_snapshots_are_taken_at_their_times(small):
    model = ExplicitModel(small, SETTINGS)
    boundary = platen_boundary(small, ContactSettings())
    run = model.run(MATERIAL, boundary, 0.5e-3, snapshots=[0.2, 0.5, 0.6, 1.0])
    plain = model.run(MATERIAL, boundary, 0.5e-3)
    np.testing.assert_allclose(run.force, plain.force, atol=0.005 * plain.force.max())
    travels = [snapshot.travel for snapshot in run.snapshots]
    np.testing.assert_allclose(travels, [0.1e-3, 0.25e-3, 0.3e-3, 0.5e-3], atol=2e-6)
    for snapshot in run.snapshots:
        force = np.interp(snapshot.travel, run.displacement, run.platen_force)
        # the record adds the inertia of the held nodes
        assert -snapshot.contact_force[:, 2].sum() == pytest.approx(force, rel=0.05)
        assert np.all(snapshot.held[small.bottom] == BASE)
        assert np.any(snapshot.held == FREE)
