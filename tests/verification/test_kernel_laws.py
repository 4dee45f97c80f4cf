"""Every elastic law in the solver: its kernel, sliding ends, bonded blocks against felupe."""

from dataclasses import replace

import numpy as np
import pytest

from elastic_laws import CORK, FIBRES, SOLIDS, TYPICAL, felupe_force, named
from softsample.constitutive.homogeneous import homogeneous_force
from softsample.constitutive.material import Material, Relaxation, Term
from softsample.errors import SimulationError
from softsample.fem.boundary import ContactSettings, glued_boundary, mode_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.cuboid import mesh_cuboid
from spectral import energy, stress

DOUBLE = SolverSettings(precision="float64", loading_time_s=0.2, curve_points=20)
SINGLE = replace(DOUBLE, precision="float32")
BLOCK = mesh_cuboid(4e-3, 3e-3, 3e-3, 1e-3)
VOLUME = 36e-9
EVERYTHING = Material((*(t for solid in TYPICAL.values() for t in solid.terms), *FIBRES), 0.4)
BLOCKS = {**TYPICAL, "cork": CORK}

every_solid = pytest.mark.parametrize("solid", SOLIDS, ids=named)


def sheared(seed=2):
    return np.eye(3) + 0.15 * np.random.default_rng(seed).uniform(-1.0, 1.0, (3, 3))


@every_solid
@pytest.mark.parametrize(("settings", "close"), [(DOUBLE, 1e-10), (SINGLE, 3e-5)])
def test_uniform_strain_has_the_stress_and_energy_of_the_law(solid, settings, close):
    F = sheared()
    u = BLOCK.points @ (F - np.eye(3)).T
    force, state = ExplicitModel(BLOCK, settings).internal_force(u, solid)
    P, wanted = np.einsum("ni,nj->ij", force, BLOCK.points) / VOLUME, stress(F, solid)
    np.testing.assert_allclose(P, wanted, atol=close * np.abs(wanted).max())
    # energies of exponents next to zero are differences of numbers that are almost equal
    loose = 30.0 * close if settings is SINGLE else close
    assert state[0].sum() / VOLUME == pytest.approx(energy(F, solid), rel=loose)


@pytest.mark.nojit
def test_the_kernel_without_compiler_has_the_stress_of_all_laws_together():
    mesh, F = mesh_cuboid(1e-3, 1e-3, 1e-3, 1e-3), sheared()
    model = ExplicitModel(mesh, replace(DOUBLE, backend="scalar"))
    force, _ = model.internal_force(mesh.points @ (F - np.eye(3)).T, EVERYTHING)
    P, wanted = np.einsum("ni,nj->ij", force, mesh.points) / 1e-9, stress(F, EVERYTHING)
    np.testing.assert_allclose(P, wanted, atol=1e-10 * np.abs(wanted).max())


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_vector_code_is_its_scalar_twin_in_every_law(crooked, precision):
    rng = np.random.default_rng(1)
    u = crooked.points @ (sheared(1) - np.eye(3)).T
    u = u + 0.03 * crooked.edge_length * rng.uniform(-1.0, 1.0, u.shape)
    settings = replace(DOUBLE, precision=precision)
    force, state = ExplicitModel(crooked, settings).internal_force(u, EVERYTHING)
    scalar = ExplicitModel(crooked, replace(settings, backend="scalar"))
    wanted, wanted_state = scalar.internal_force(u, EVERYTHING)
    close = 2e-5 if precision == "float32" else 1e-12
    np.testing.assert_allclose(force, wanted, atol=close * np.abs(wanted).max())
    np.testing.assert_allclose(state, wanted_state, atol=close * np.abs(wanted_state).max())


@pytest.mark.parametrize("mode", ["tension", "compression", "pure_shear", "confined_compression"])
@pytest.mark.parametrize("law", [law for law, solid in BLOCKS.items() if solid.isotropic])
def test_sliding_ends_are_the_closed_form(law, mode):
    """To 0.1 % of the peak; measured 4e-5 and less."""
    material, strain = BLOCKS[law], 0.1 if mode == "confined_compression" else 0.25
    boundary = mode_boundary(BLOCK, mode, BLOCK.glued(0.0), ContactSettings(), "sliding")
    run = ExplicitModel(BLOCK, DOUBLE).run(material, boundary, 3e-3 * strain)
    exact = 12e-6 * homogeneous_force(mode, run.displacement / 3e-3, material)
    np.testing.assert_allclose(run.force, exact, atol=1e-3 * np.abs(exact).max())


@pytest.mark.parametrize("mode", ["tension", "compression", "shear"])
@pytest.mark.parametrize("law", BLOCKS)
def test_bonded_blocks_are_those_of_felupe(law, mode):
    """Elements of 1 mm with one point and the same hourglass stiffness, to 0.5 % at the end."""
    mesh, travel = mesh_cuboid(4e-3, 4e-3, 4e-3, 1e-3), 0.8e-3
    boundary = glued_boundary(mesh, mode, mesh.glued(0.0))
    run = ExplicitModel(mesh, SINGLE).run(BLOCKS[law], boundary, travel)
    assert abs(run.force[-1]) == pytest.approx(
        felupe_force(mesh, BLOCKS[law], mode, travel), rel=5e-3
    )


def test_another_law_relaxes_as_ogden_does():
    """The neo-Hookean solid is Ogden's of exponent two, in another branch of the kernel."""
    relaxation = Relaxation((0.4,), (0.5,))
    boundary = glued_boundary(BLOCK, "shear", BLOCK.glued(0.0))
    one, other = (
        ExplicitModel(BLOCK, DOUBLE).run(
            Material((Term(law, 900.0, shape),), 0.45, relaxation), boundary, 1e-3
        )
        for law, shape in (("neo_hooke", ()), ("ogden", (2.0,)))
    )
    np.testing.assert_allclose(one.force, other.force, atol=1e-9 * other.force.max())
    elastic = ExplicitModel(BLOCK, DOUBLE).run(TYPICAL["neo_hooke"], boundary, 1e-3)
    assert one.force[-1] < 0.8 * elastic.force[-1]


def test_gent_beyond_its_limit_is_refused():
    """It stiffens a million times within a slice of constant time step."""
    stiff = Material((Term("gent", 900.0, (0.02,)),), 0.45)
    boundary = glued_boundary(BLOCK, "tension", BLOCK.glued(0.0))
    with pytest.raises(SimulationError, match="end the record at a smaller strain"):
        ExplicitModel(BLOCK, SINGLE).run(stiff, boundary, 0.6e-3)
