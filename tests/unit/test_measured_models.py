"""Models of ideal shapes, splits and support: against other ways to the same numbers."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from softsample.constitutive.ogden import OgdenMaterial, ogden_stress, unit_modulus
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.loop.effects import library
from softsample.loop.errors import Error
from softsample.loop.model import Material
from softsample.measured.effects import OF_TIME, fitted_library
from softsample.measured.homogeneous import force_per_mu, normal_per_mu
from softsample.measured.measurement import Measurement, cuboid, cylinder, untimed
from softsample.measured.models import ModelSettings, elastics, key_of, model_table
from softsample.measured.split import Part, SplitSettings, split
from softsample.measured.study import supported
from softsample.meshing.cuboid import mesh_cuboid

ALPHA, MIXTURE = (1.5, 6.0), 0.6
CUBE = cuboid(10.0, 10.0, 10.0)
STRIP = cuboid(40.0, 3.0, 10.0)


def stress_of(gradient, i, j):
    """Component of the nominal stress over mu with the pressure that frees the y faces.

    Written with the constitutive law of the solver; its volumetric part is taken off.
    """
    solid = OgdenMaterial((MIXTURE, 1.0 - MIXTURE), ALPHA)
    stress = ogden_stress(gradient[None], solid)[0]
    inverse = np.linalg.inv(gradient).T
    free = stress - stress[1, 1] / inverse[1, 1] * inverse
    return free[i, j]


@pytest.mark.parametrize(
    ("shape", "mode", "strain", "gradient", "component"),
    [
        (CUBE, "tension", 0.3, np.diag([1.3**-0.5, 1.3**-0.5, 1.3]), (2, 2)),
        (CUBE, "compression", 0.4, np.diag([0.6**-0.5, 0.6**-0.5, 0.6]), (2, 2)),
        (STRIP, "tension", 0.5, np.diag([1.0, 1.0 / 1.5, 1.5]), (2, 2)),
        (CUBE, "shear", 0.5, np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), (0, 2)),
    ],
)
def test_closed_forms_are_those_of_the_constitutive_law(shape, mode, strain, gradient, component):
    travel = np.array([strain * shape.height])
    sign = -1.0 if mode == "compression" else 1.0
    expected = sign * shape.area * stress_of(gradient, *component)
    assert force_per_mu(shape, mode, MIXTURE, ALPHA, travel)[0] == pytest.approx(expected, rel=1e-9)


def test_normal_force_of_shear_is_that_of_the_constitutive_law():
    gradient = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    found = normal_per_mu(CUBE, MIXTURE, ALPHA, np.array([5e-3]))[0]
    assert found == pytest.approx(CUBE.area * stress_of(gradient, 2, 2), rel=1e-9)
    assert found > 0.0  # tension: the platens would be drawn together
    neo_hookean = normal_per_mu(CUBE, 1.0, (2.0, 2.0), np.array([5e-3]))[0]
    assert neo_hookean == pytest.approx(0.0, abs=1e-15)


def pressed(name="m_A1", group="m", specimen="A", mode="compression", shape=None, normal=None):
    shape = shape or cylinder(10.0, 10.0)
    sign = -1.0 if mode == "compression" else 1.0
    travel = sign * np.concatenate([np.linspace(0, 5e-3, 51), np.linspace(5e-3, 0, 51)[1:]])
    record = untimed(travel, travel, normal)
    return Measurement(name, group, specimen, mode, shape, record, timed=False)


def test_finite_elements_without_friction_are_the_closed_form():
    """Slip of the library is on the moving platen alone, so it ends between the two models."""
    settings = ModelSettings((2.0, 4.0), ("bonded", "homogeneous"), 0.2, 5)
    solver = SolverSettings(loading_time_s=0.08, curve_error_percent=1.0)
    test = pressed(shape=CUBE)
    models = elastics(model_table([test], settings, solver))
    sticking, free = (models[key_of(kind, test, "force")] for kind in settings.kinds)
    travel = np.array([0.5e-3, 1e-3, 2e-3])
    stuck, slid = sticking.force_per_mu(0.5, travel), free.force_per_mu(0.5, travel)
    half = stuck + sticking.change_per_mu("platen_slip", 0.5, travel)
    assert np.all((slid < half) & (half < stuck))
    back = slid - free.change_per_mu("platen_slip", 0.5, travel)  # from the closed form to sticking
    np.testing.assert_allclose(back, stuck, rtol=1e-3)

    mesh = mesh_cuboid(0.01, 0.01, 0.01, 0.002)
    smooth = mode_boundary(
        mesh, "compression", mesh.glued(0.0), ContactSettings(friction=0.0, base_friction=0.0)
    )
    run = ExplicitModel(mesh, solver).run(unit_modulus(0.5, (2.0, 4.0), 0.49, 1e3), smooth, 2e-3)
    found = np.interp(travel, run.displacement, run.force) / 1e3
    np.testing.assert_allclose(found, slid, rtol=0.01)


def test_a_specimen_is_held_out():
    tests = [pressed(f"m_{s}{k}", specimen=s) for s in "BA" for k in (1, 2)]
    (case,) = split(tests, SplitSettings("other_specimen", 0.5))
    assert {part.test.specimen for part in case.fitted} == {"A"}
    assert [part.test.name for part in case.held_out] == ["m_B1", "m_B2"]


def test_larger_strain_and_the_way_back_are_held_out():
    (case,) = split([pressed()], SplitSettings("larger_strain_and_way_back", 0.4, 0.3))
    (fitted,), (held_out,) = case.fitted, case.held_out
    strain = -fitted.test.strain
    assert strain[: fitted.until].max() == pytest.approx(0.3)
    counted = held_out.counts(strain)
    assert not counted[: fitted.until].any()
    assert strain[counted].max() == pytest.approx(0.4)
    back = np.arange(len(strain)) > 50
    assert np.array_equal(counted[back], strain[back] <= 0.4)


def test_one_mode_after_the_other_is_fitted():
    tests = [pressed(mode, mode=mode) for mode in ("tension", "compression", "shear")]
    cases = split(tests, SplitSettings("other_modes", 0.5))
    assert [case.name for case in cases] == ["m_tension", "m_compression", "m_shear"]
    for case in cases:
        assert len(case.fitted) == 1
        assert len(case.held_out) == 2
        assert case.fitted[0].test not in [part.test for part in case.held_out]


def test_normal_force_is_another_channel_of_the_same_record():
    (case,) = split([pressed(mode="shear")], SplitSettings("normal_force", 0.5))
    assert case.fitted[0].test is case.held_out[0].test
    assert (case.fitted[0].channel, case.held_out[0].channel) == ("force", "force_normal")
    assert isinstance(case.held_out[0], Part)


def test_ranges_follow_force_and_height_of_the_sample():
    known = {e.name: e for e in fitted_library((-20.0, 20.0), 26e-3, 100.0, timed=False)}
    assert not set(known) & set(OF_TIME)
    one, many = library()["force_offset"].sizes[0], known["force_offset"].sizes[0]
    assert (many.low, many.nominal) == pytest.approx((100.0 * one.low, 100.0 * one.nominal))
    gap = known["late_contact"].sizes[0]
    assert gap.high == pytest.approx(2.0 * library()["late_contact"].sizes[0].high)
    first = known["ogden_exponents"].sizes[0]
    assert (first.low, first.neutral, first.high) == (-35.0, -20.0, -5.0)
    timed = {e.name for e in fitted_library((2.0, 4.0), 13e-3, 1.0, timed=True)}
    assert set(OF_TIME) <= timed


@dataclass
class Found:
    """As much of a diagnosis as its support rests on."""

    held_out_before: dict
    held_out_after: dict
    selection: object = None
    problem: object = field(default_factory=lambda: SimpleNamespace(mixtures=(0.02, 0.98)))


@dataclass
class Chosen:
    final: object


@dataclass
class Fitted:
    model: object
    state: object
    at_bound: tuple
    covariance: np.ndarray


@dataclass
class Values:
    values: dict
    material: Material


def judged(before, after, value=0.1, at_bound=(), spread=0.1, mixture=0.5):
    errors = [
        {f"fold_{k}": {"shear": Error(e, e, 1.0)} for k, e in enumerate(part)}
        for part in (before, after)
    ]

    class Model:
        effect = library()["platen_slip"]
        parameters = ((effect, effect.parameters[0]),)

    fit = Fitted(
        Model,
        Values({"platen_slip": {"share": value}}, Material(1000.0, mixture)),
        at_bound,
        np.diag([spread**2, 1.0]),
    )
    return supported(Found(*errors, Chosen(fit)))


def test_effects_need_every_fold_a_size_within_its_range_and_a_modulus():
    assert judged((0.1, 0.2), (0.05, 0.1))
    assert not judged((0.1, 0.2), (0.05, 0.19))  # one fold hardly better
    assert not judged((), ())  # no fold, no support
    assert not judged((0.1,), (0.05,), value=1.0, at_bound=("platen_slip.share",))
    assert judged((0.1,), (0.05,), value=0.0, at_bound=("platen_slip.share",))  # absent, no harm
    assert not judged((0.1,), (0.05,), spread=1.0)  # the modulus may be anything
    assert not judged((0.1,), (0.05,), mixture=0.98)  # nor is the mixture known
