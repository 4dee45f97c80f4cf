"""Time integration: stable step, balances, scaling, repeatability, errors."""

import platform
from dataclasses import replace

import numba
import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse.linalg import LinearOperator, eigsh

import naive
from elastic_laws import BySpectrum
from softsample.constitutive.ogden import OgdenMaterial
from softsample.errors import InputError, SimulationError
from softsample.fem import explicit
from softsample.fem.boundary import ContactSettings, glued_boundary, platen_boundary
from softsample.fem.denormals import flushed_denormals
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.fem.motion import FREE
from softsample.fem.schedule import Schedule
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.mesh import HexMesh
from softsample.protocol import History, smooth_step

DOUBLE = SolverSettings(precision="float64", loading_time_s=0.05)
SINGLE = replace(DOUBLE, precision="float32")


@pytest.fixture(scope="module")
def sample():
    """336 elements of 1 mm, 8 x 7 x 6 mm."""
    return mesh_cuboid(8e-3, 7e-3, 6e-3, 1e-3)


def loaded(mesh, mode, settings, material, travel, solver=ExplicitModel, **options):
    boundary = glued_boundary(mesh, mode, mesh.glued(0.0))
    return solver(mesh, settings).run(material, boundary, travel, **options)


def march(model, material, boundary, travel):
    """A run that has not begun."""
    schedule = Schedule(History.ramp(travel), model.settings.loading_time_s)
    return explicit._March(model, material, boundary, schedule, None)


def critical_steps(loading, times=5):
    """Estimates of the critical step, none influenced by the one before."""
    steps = []
    for _ in range(times):
        loading.critical = 0.0
        steps.append(loading._critical_step())
    return steps


def exact_critical_step(model, material, u, free):
    """2 / omega_max of the dense eigenvalue problem of the free nodes."""
    tangent = naive.stiffness(lambda w: model.internal_force(w, material)[0], u, 1e-8)
    keep = np.repeat(free, 3)
    mass = np.repeat(model.mass, 3)[keep]
    K = tangent[np.ix_(keep, keep)]
    return 2.0 / np.sqrt(eigh(0.5 * (K + K.T), np.diag(mass), eigvals_only=True)[-1])


@pytest.mark.parametrize("settings", [DOUBLE, SINGLE])
@pytest.mark.parametrize("strain", [0.0, 0.2])
def test_stable_step_is_that_of_the_dense_eigenvalue_problem(crooked, tissue, settings, strain):
    """Never above the exact one, and at most 4 % below."""
    boundary = glued_boundary(crooked, "compression", crooked.glued(2e-4))
    loading = march(ExplicitModel(crooked, settings), tissue, boundary, 1e-3)
    u = crooked.points * [0.5 * strain, 0.4 * strain, -strain]
    loading.motion.u[:, :3] = u
    exact = exact_critical_step(ExplicitModel(crooked, DOUBLE), tissue, u, boundary.held == FREE)
    estimates = critical_steps(loading)
    assert max(estimates) <= 1.005 * exact
    assert min(estimates) >= 0.96 * exact


def test_stable_step_errs_on_the_safe_side_where_lanczos_has_not_converged(tissue):
    """2,688 elements have too many modes near the stiffest for 12 steps: the residual covers it."""
    block = mesh_cuboid(16e-3, 14e-3, 12e-3, 1e-3)
    shift = np.random.default_rng(3).uniform(-1.2e-4, 1.2e-4, block.points.shape)
    mesh = HexMesh(block.points + shift * (block.points[:, 2:] > 0.0), block.hexes)
    model = ExplicitModel(mesh, DOUBLE)
    boundary = glued_boundary(mesh, "compression", mesh.glued(2e-4))
    free = np.repeat(boundary.held == FREE, 3)
    root = 1.0 / np.sqrt(np.repeat(model.mass, 3)[free])

    def product(x):
        reach = 1e-9 / np.abs(root * x.ravel()).max() if np.any(x) else 1.0
        u = np.zeros(mesh.points.size)
        u[free] = reach * root * x.ravel()
        force, _ = model.internal_force(u.reshape(-1, 3), tissue)
        return root * force.ravel()[free] / reach

    operator = LinearOperator((free.sum(), free.sum()), product)
    (stiffest,) = eigsh(operator, 1, which="LA", tol=1e-5, return_eigenvectors=False)
    exact = 2.0 / np.sqrt(stiffest)
    estimates = np.array(critical_steps(march(model, tissue, boundary, 1e-3))) / exact
    assert max(estimates) <= 1.0
    assert min(estimates) >= 0.98


@pytest.mark.skipif(
    numba.config.DISABLE_JIT or platform.machine() not in ("x86_64", "AMD64"),
    reason="denormals are flushed by compiled code on x86 only",
)
def test_subnormal_numbers_are_zero_while_it_marches_and_only_then():
    small, part = np.full(4, 1e-38, np.float32), np.float32(1e-3)
    assert np.all(small * part > 0.0)
    with flushed_denormals():
        np.testing.assert_array_equal(small * part, 0.0)
        with pytest.raises(RuntimeError), flushed_denormals():
            raise RuntimeError
    assert np.all(small * part > 0.0)


def test_safety_factor_divides_the_step(sample, tissue):
    runs = [
        loaded(sample, "tension", replace(DOUBLE, safety_factor=s), tissue, 5e-4)
        for s in (0.8, 0.4)
    ]
    assert runs[0].smallest_step_s / runs[1].smallest_step_s == pytest.approx(2.0, rel=0.05)


def test_too_large_a_step_is_noticed(sample, tissue):
    with pytest.raises(SimulationError, match="safety_factor"):
        loaded(sample, "tension", replace(DOUBLE, safety_factor=1.3), tissue, 1.5e-3)


@pytest.mark.parametrize("mode", ["tension", "compression", "shear"])
def test_energy_is_conserved(sample, tissue, mode):
    run = loaded(sample, mode, DOUBLE, tissue, 1.5e-3)
    e = run.energy
    assert e["work"] == pytest.approx(e["strain"] + e["hourglass"] + e["kinetic"], rel=2e-4)
    assert e["imbalance"] < 5e-4
    assert e["kinetic"] < 0.005 * e["strain"]
    # area under the reported curve, an independent sum
    area = np.trapezoid(run.platen_force, run.displacement)
    assert area == pytest.approx(e["work"], rel=5e-3)


def test_reported_energies_are_those_of_the_final_state(sample, tissue):
    run = loaded(sample, "shear", DOUBLE, tissue, 1.5e-3)
    _, state = ExplicitModel(sample, DOUBLE).internal_force(run.displacement_field, tissue)
    assert run.energy["strain"] == pytest.approx(state[0].sum(), rel=1e-3)
    assert run.energy["hourglass"] == pytest.approx(state[1].sum(), rel=1e-2)


@pytest.mark.parametrize("contact", [False, True])
def test_platens_change_the_momentum_and_nothing_else(crooked, tissue, contact):
    """Impulse of platen and base is the momentum of the sample, catching nodes included."""
    settings = replace(DOUBLE, loading_time_s=0.004)
    model = ExplicitModel(crooked, settings)
    boundary = (
        platen_boundary(crooked, ContactSettings())
        if contact
        else glued_boundary(crooked, "shear", crooked.glued(2e-4))
    )
    loading = march(model, tissue, boundary, 4e-4)
    duration = loading.schedule.loading_time * np.sqrt(1000.0 / tissue.shear_modulus)
    loading.schedule = replace(loading.schedule, loading_time=duration)
    n = int(np.ceil(2.0 * duration / loading._critical_step()))
    dt = 0.4 * duration / n
    # two slices of unlike steps, and an end while the platen moves
    loading._advance(duration * np.linspace(0.0, 0.4, n + 1), dt)
    loading._advance(duration * np.linspace(0.4, 0.6, n + 1), 0.5 * dt)
    history = np.concatenate(loading.records.forces)
    kick = np.repeat([dt, 0.5 * dt], n)
    kick[n] = 0.75 * dt  # from the middle of one step to the middle of the next
    impulse = kick @ (history[:, :3] + history[:, 3:])
    momentum = model.mass @ loading.motion.v[:, :3]
    assert np.abs(momentum).max() > 1e-3 * dt * np.abs(history[:, :3]).sum()
    np.testing.assert_allclose(impulse, momentum, atol=1e-10 * np.abs(momentum).max())


def test_platen_and_base_balance_when_loading_is_slow(sample, tissue):
    run = loaded(sample, "tension", replace(DOUBLE, loading_time_s=0.2), tissue, 1.5e-3)
    peak = np.abs(run.force).max()
    np.testing.assert_allclose(run.platen_force, -run.base_force, atol=0.005 * peak)
    np.testing.assert_allclose(run.force, (run.platen_force - 2.0 * run.base_force) / 3.0)


@pytest.mark.parametrize("settings", [DOUBLE, SINGLE])
def test_curve_of_fourfold_modulus_is_exactly_fourfold(sample, tissue, settings):
    """Powers of four leave every rounding the same, so homogeneity must hold to the bit."""
    stiff = OgdenMaterial(tuple(4.0 * mu for mu in tissue.mu), tissue.alpha, tissue.poisson_ratio)
    one = loaded(sample, "compression", settings, tissue, 1.5e-3)
    four = loaded(sample, "compression", settings, stiff, 1.5e-3)
    assert one.steps == four.steps
    np.testing.assert_array_equal(four.force, 4.0 * one.force)
    np.testing.assert_array_equal(four.displacement_field, one.displacement_field)


@pytest.mark.parametrize("k", [0.3, 7.7])
def test_curves_are_homogeneous_in_the_modulus(sample, tissue, k):
    scaled = OgdenMaterial(tuple(k * mu for mu in tissue.mu), tissue.alpha, tissue.poisson_ratio)
    one = loaded(sample, "tension", DOUBLE, tissue, 1.5e-3)
    other = loaded(sample, "tension", DOUBLE, scaled, 1.5e-3)
    np.testing.assert_allclose(other.force, k * one.force, atol=1e-9 * k * one.force.max())


def test_runs_repeat_to_the_bit(crooked, tissue):
    boundary = platen_boundary(crooked, ContactSettings())
    first, second = (ExplicitModel(crooked, SINGLE).run(tissue, boundary, 8e-4) for _ in range(2))
    np.testing.assert_array_equal(first.force, second.force)
    np.testing.assert_array_equal(first.displacement_field, second.displacement_field)
    assert np.all(boundary.held[boundary.candidates] == FREE)  # inputs are left alone


def test_single_precision_changes_nothing_that_matters(sample, tissue):
    double = loaded(sample, "compression", DOUBLE, tissue, 1.8e-3)
    single = loaded(sample, "compression", SINGLE, tissue, 1.8e-3)
    np.testing.assert_allclose(single.force, double.force, atol=5e-5 * double.force.max())


def test_spectral_run_is_the_product_run(sample, tissue):
    product = loaded(sample, "shear", DOUBLE, tissue, 1.5e-3)
    spectral = loaded(sample, "shear", DOUBLE, tissue, 1.5e-3, BySpectrum)
    np.testing.assert_allclose(spectral.force, product.force, atol=1e-8 * product.force.max())


def test_error_falls_with_the_square_of_the_loading_time(sample, tissue):
    """Inertia errors go as 1 / T^2: T against 4 T is five times 2 T against 4 T."""
    forces = [
        loaded(sample, "tension", DOUBLE, tissue, 1.5e-3, loading_time=0.05 * s).force
        for s in (1, 2, 4)
    ]
    coarse, fine = (np.abs(force - forces[2]).max() for force in forces[:2])
    assert coarse < 0.05 * forces[2].max()
    assert 3.5 < coarse / fine < 7.0


def test_curve_is_evenly_spaced_from_zero(sample, tissue):
    run = loaded(sample, "tension", replace(SINGLE, curve_points=30), tissue, 1.5e-3)
    np.testing.assert_allclose(run.displacement, np.linspace(0.0, 1.5e-3, 31))
    assert run.force[0] == pytest.approx(0.0, abs=1e-6)
    moved = run.displacement_field[sample.glued(0.0)]
    np.testing.assert_allclose(moved, np.tile([0.0, 0.0, 1.5e-3], (len(moved), 1)), atol=1e-8)


def test_progress_is_told_until_the_end(sample, tissue):
    told = []
    loaded(sample, "tension", SINGLE, tissue, 1e-3, progress=told.append)
    assert len(told) == explicit.STEP_UPDATES
    assert np.all(np.diff(told) > 0.0)
    assert told[-1] == 1.0


def test_smooth_step_starts_and_ends_at_rest():
    x = np.linspace(0.0, 1.0, 2001)
    s = smooth_step(x)
    np.testing.assert_allclose(s + s[::-1], 1.0)
    assert (s[0], s[-1]) == (0.0, 1.0)
    speed = np.gradient(s, x)
    acceleration = np.gradient(speed, x)
    assert np.all(speed >= 0.0)
    assert speed.max() == pytest.approx(1.875, rel=1e-5)
    for ends in (speed[[0, -1]], acceleration[[0, -1]]):
        np.testing.assert_allclose(ends, 0.0, atol=0.03)
    np.testing.assert_array_equal(smooth_step([-0.5, 1.5]), [0.0, 1.0])


def test_crushed_element_is_named_with_its_place_and_a_cure(sample):
    """Nearly all height taken off a soft solid: some element turns inside out."""
    soft = OgdenMaterial((1000.0,), (2.0,), 0.3)
    with pytest.raises(
        SimulationError,
        match=r"element \d+ near \[.*\] mm has J = .* mm of displacement.; lower solver",
    ):
        loaded(sample, "compression", DOUBLE, soft, 6.5e-3)


@pytest.mark.parametrize("travel", [0.0, -1e-3, np.nan])
def test_travel_must_be_positive(sample, tissue, travel):
    with pytest.raises(InputError, match=r"the platen must move.*check the record"):
        loaded(sample, "tension", DOUBLE, tissue, travel)
