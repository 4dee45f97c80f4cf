"""A foam in compression that loses force on unloading: law and loss in closed form.

Storakers' foam of a Poisson's ratio of 0 keeps its width between plates that slide, so that the
nominal stress is that of one stretch; nothing of the package predicts a force.
"""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

import laboratory
from softsample.loop.diagnose import diagnose
from softsample.loop.effects import library
from softsample.loop.effects.base import SOLID
from softsample.loop.model import Material, Model, State
from softsample.loop.posed import LoopSettings
from softsample.loop.verdict import report
from softsample.shapes import IdealShape

PLUG = IdealShape("cylinder", 15e-3, 15e-3, 10e-3)
MU, ALPHA, LOSS = 2000.0, 5.0, 0.2  # Pa, 1, 1
STRAIN = 0.45


@pytest.fixture(scope="module")
def cycle():
    """One cycle, with a part of the force missing on unloading."""
    return laboratory.foam_cycle("A", PLUG, MU, ALPHA, LOSS, STRAIN)


@pytest.fixture(scope="module")
def found(cycle):
    names = (
        "compressible_foam",
        "ogden_exponents",
        "elastic_law",
        "unloading_loss",
        "viscoelastic_relaxation",
        "poroelastic_drainage",
        "self_weight",
    )
    known = library(SOLID, [cycle])
    return diagnose([cycle], LoopSettings(), [known[name] for name in names])


def test_a_foam_is_found_though_loading_and_unloading_differ(found):
    assert found.verdict == "explained", found.objection
    assert set(found.selection.classes) == {"compressible_foam", "unloading_loss"}


def test_modulus_and_loss_are_those_of_the_plug(found):
    state = found.final.state
    assert state.material.mu == pytest.approx(MU, rel=0.05)
    assert state.values["unloading_loss"]["loss"] == pytest.approx(LOSS, abs=0.02)


def test_what_unseen_effects_do_to_the_modulus_is_told_of_the_law_that_was_found(found):
    verdict = report(found, LoopSettings())
    laws = {"ogden_exponents", "elastic_law"}
    assert not laws & {*verdict["detection_limits"], *verdict["not_identifiable"]}
    mu = verdict["recommended"]["mu"]
    assert 0.5 * MU < mu["low"] < MU < mu["high"] < 2.0 * MU


@pytest.mark.parametrize("depth", [0.5, 2.0])
def test_an_uneven_face_is_columns_of_the_law_that_the_tissue_has(cycle, depth):
    """Against the integral of the foam's force over the heights, and a change of its bulk."""
    known = library(SOLID, [cycle])
    foam, face, other = (known[n] for n in ("compressible_foam", "uneven_contact", "poisson_ratio"))
    values = {
        "compressible_foam": {"share": 1.0, "alpha": ALPHA, "nu": 0.0},
        "uneven_contact": {"depth_mm": depth},
        "poisson_ratio": {"nu": 0.48},
    }

    def force(test, *effects):
        state = State(Material(MU, 0.5), {e.name: values[e.name] for e in effects})
        return Model(effects).predict(test, state)

    found = force(cycle, foam, face)
    travel = np.linspace(0.0, cycle.reach, 20001)
    law = laboratory.foam_force(PLUG, MU, ALPHA, travel / PLUG.height)
    whole = cumulative_trapezoid(law, travel, initial=0.0)
    ahead, behind = (np.interp(cycle.travel - low, travel, whole) for low in (0.0, 1e-3 * depth))
    exact = (ahead - behind) / (1e-3 * depth)
    # the part of one of the eight columns, in which the corner of first contact may lie
    corner = 0.125 * 0.18**2 * 1e-3 * depth * 2.0 * MU * PLUG.area / PLUG.height
    np.testing.assert_allclose(found, exact, atol=corner)
    plain = force(cycle)
    part = np.divide(force(cycle, other), plain, out=np.ones_like(plain), where=plain > 0.0)
    np.testing.assert_allclose(force(cycle, foam, face, other), part * found, rtol=1e-12)
