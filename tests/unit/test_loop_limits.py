"""Sizes that would have been seen, against an exact result and records with what they name."""

from dataclasses import replace

import numpy as np
import pytest

import laboratory
from softsample.loop.diagnose import diagnose
from softsample.loop.effects import library
from softsample.loop.model import Model, State
from softsample.loop.posed import LoopSettings
from softsample.loop.verdict import report
from softsample.response.curves import ResponseCurves

SETTINGS = LoopSettings()


def of(names, lab):
    effects = [library()[name] for name in names]
    return diagnose(lab.specimens(), SETTINGS, effects)


@pytest.fixture(scope="module")
def nothing():
    return of(("force_offset", "force_drift", "late_contact", "gain"), laboratory.Lab(seed=6))


@pytest.fixture(scope="module")
def limits(nothing):
    return report(nothing, SETTINGS)["detection_limits"]


def bound(found):
    """Late contact [mm] at which the price of the contact zero that follows it is noticed."""
    need = found.selection.steps[0].threshold + np.log(len(found.selection.base.white))
    return SETTINGS.noise.contact_zero_mm * np.sqrt(need)


def test_a_late_contact_is_not_seen_while_its_prior_pays(nothing, limits):
    """The plain model follows it exactly at the price of its contact zero, squared, or better."""
    assert limits["late_contact"]["unit"] == "mm"
    assert bound(nothing) <= limits["late_contact"]["value"] < 1.5 * bound(nothing)


def test_a_rough_curve_hides_a_late_contact_as_well():
    """The cost of a shift has other minima then, in which a fit can stop."""
    specimens = laboratory.Lab(seed=6).specimens()
    compressed = specimens[laboratory.MODES.index("compression")]
    curves = compressed.elastic.curves
    grain = 1.0 + 0.01 * np.sin(2.0 * np.pi * curves.displacement / 1e-4)
    forces = np.stack([curves.curve(r) for r in curves.fractions])
    rough = ResponseCurves(curves.fractions, curves.displacement, grain * forces)
    specimens[laboratory.MODES.index("compression")] = replace(
        compressed, elastic=replace(compressed.elastic, curves=rough)
    )
    found = diagnose(specimens, SETTINGS, [library()["late_contact"]])
    limit = report(found, SETTINGS)["detection_limits"]["late_contact"]["value"]
    assert 0.9 * bound(found) < limit < 1.5 * bound(found)


@pytest.mark.parametrize(("part", "seen"), [(0.5, False), (1.5, True)])
@pytest.mark.parametrize("name", ["force_offset", "force_drift", "late_contact"])
def test_what_is_beyond_its_limit_is_seen_and_what_is_below_is_not(name, part, seen, limits):
    size = part * limits[name]["value"]
    planted = {
        "force_offset": {"offset": dict.fromkeys(laboratory.MODES, size)},
        "force_drift": {"drift": size},
        "late_contact": {"gap": size},
    }[name]
    found = of([name], laboratory.Lab(seed=7, **planted))
    assert list(found.selection.classes) == ([name] if seen else [])


def test_a_limit_tells_what_the_effect_makes_of_the_modulus():
    """A Poisson's ratio at its limit: the plain fit to its exact record is off by as much."""
    found = of(("poisson_ratio", "force_offset"), laboratory.Lab(seed=6))
    verdict = report(found, SETTINGS)
    limit = verdict["detection_limits"]["poisson_ratio"]
    effect = library()["poisson_ratio"]
    (nu,) = effect.parameters
    size = nu.neutral + np.sign(nu.nominal - nu.neutral) * limit["value"]
    plain = State(found.final.state.material)
    model, state = Model((effect,)), replace(plain, values={effect.name: {"nu": size}})
    problem = found.selection.final.problem
    problem = problem.with_least(SETTINGS.noise.doubt(problem.variances, geometry=True))
    fit = problem.with_forces(problem.predicted(model, state)).fit(Model(), plain)
    factor = fit.state.material.mu / plain.material.mu
    assert limit["modulus_percent"] == pytest.approx(100.0 * (factor - 1.0), abs=0.05)
    assert abs(factor - 1.0) > 0.005
