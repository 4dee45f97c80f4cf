"""A strip of elastomer that is pulled at three speeds, held and let go: all from closed forms."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from scipy.signal import fftconvolve

from softsample.constitutive.ogden import unit_modulus
from softsample.loop.average import weighed
from softsample.loop.candidates import candidates
from softsample.loop.diagnose import diagnose
from softsample.loop.held_out import specimens_of
from softsample.loop.posed import LoopSettings
from softsample.records import Record
from softsample.response.elastic import Tables
from softsample.response.unit import (
    ResponseSettings,
    homogeneous_response,
    modulus_fractions,
    response_table,
)
from softsample.shapes import IdealShape

MM = 1e-3
STRIP = IdealShape("cuboid", 10 * MM, 2 * MM, 40 * MM)
ALPHA = (-8.0, 16.0)
"""Exponents of the model, which are not those of the strip."""

TERMS = ((60e3, 1.5), (6e3, 7.0))
"""Modulus [Pa] and exponent of each term of the strip."""

RELAXING = ((0.12, 0.5), (0.10, 5.0), (0.08, 50.0), (0.06, 500.0))
"""Share and time [s] of each part that relaxes."""

PULL, HOLD = 20.0, 120.0
SPEEDS = (0.4, 4.0, 40.0)
"""Millimetres, seconds, millimetres per second."""

SCALES = (1.0, 1.01, 0.99)
"""Of the tests: a strip is not clamped twice alike."""


def elastic(stretch):
    """Force of the relaxed strip over its share [N], nominal stress of an Ogden solid."""
    return STRIP.area * sum(
        2.0 * m / a * (stretch ** (a - 1.0) - stretch ** (-0.5 * a - 1.0)) for m, a in TERMS
    )


def relaxed(time, force):
    """Quasi-linear viscoelasticity, exact for forces that are linear between times."""
    total = (1.0 - sum(g for g, _ in RELAXING)) * force
    for g, tau in RELAXING:
        part = np.zeros_like(force)
        for k, (dt, change) in enumerate(zip(np.diff(time), np.diff(force), strict=True)):
            decay = np.exp(-dt / tau)
            part[k + 1] = decay * part[k] + change * tau / dt * (1.0 - decay)
        total = total + g * part
    return total


def pulled(speed, scale, seed):
    """Record of one speed: there, held, and back; a strip does not push."""
    ramp = PULL / speed
    corners = np.array([0.0, ramp, ramp + HOLD, 2.0 * ramp + HOLD])
    fine = np.unique(np.concatenate([np.linspace(a, b, 4000) for a, b in pairwise(corners)]))
    way = np.interp(fine, corners, [0.0, PULL, PULL, 0.0])
    force = np.maximum(relaxed(fine, elastic(1.0 + way * MM / STRIP.height)), 0.0)
    step = min(ramp / 200.0, 0.2)
    time = np.arange(0.0, corners[-1], step)
    noise = 2e-3 * force.max() * np.random.default_rng(seed).normal(size=len(time))
    columns = {
        "time_s": time,
        "displacement_mm": np.interp(time, fine, way),
        "force_N": scale * np.interp(time, fine, force) + noise,
    }
    return Record.of_table(pd.DataFrame(columns)).marked("tension")


def strip_tests(records, held_out):
    """Tests of one strip beside the study's model, and the effects that they may show."""
    solid = unit_modulus(0.5, ALPHA, 0.49, 1.0)
    law = (modulus_fractions(ResponseSettings()), ALPHA, 0.49)
    curves, _ = homogeneous_response(STRIP, "tension", PULL * MM, *law, 60)
    response = Tables(pd.DataFrame(response_table(curves, "tension")), [], solid)
    row = {"specimen": "E", "group": "E", "mode": "tension", "ends": "sliding"}
    tests = []
    for k, record in enumerate(records):
        tests += specimens_of({**row, "sample": f"E{k}"}, record, response, STRIP, held_out)
    return tests, candidates(tests, STRIP.height, solid)


@pytest.fixture(scope="module")
def strips():
    """Three tests of one strip; what follows the ramps is held out."""
    records = [pulled(*one) for one in zip(SPEEDS, SCALES, range(3), strict=True)]
    return strip_tests(records, [{"phase": ["hold", "unloading"]}])


def test_relaxation_is_found_from_three_speeds_and_predicts_the_holds(strips):
    tests, effects = strips
    found = diagnose(tests, LoopSettings(), effects)
    assert found.verdict == "explained"
    assert list(found.selection.classes) == ["viscoelastic_relaxation"]
    for label, before in found.before.held_out.items():
        assert found.after.held_out[label].rms < before.rms / 3.0


def test_of_three_strips_speeds_say_less(strips):
    """Each may be of another stiffness; of one strip that is no excuse."""
    tests, effects = strips
    known = [e for e in effects if e.name == "viscoelastic_relaxation"]
    others = [replace(test, piece=test.name) for test in tests]
    evidence = [
        diagnose(of, LoopSettings(), known).selection.steps[0].candidates[0].evidence
        for of in (tests, others)
    ]
    assert evidence[0] > 5.0 * max(evidence[1], 1.0)


def test_a_model_of_far_other_exponents_finds_the_modulus_of_the_strip(strips):
    """At a stretch of 1.5 an exponent of 16 is far off, and still a minimum of its own."""
    tests, effects = strips
    none = [e for e in effects if e.name == "gain"]
    base = diagnose(tests, LoopSettings(), none).selection.base.state.material
    assert base.mu == pytest.approx(sum(m for m, _ in TERMS), rel=0.3)


def faded(speed, seed):
    """A strip of the model's exponents, incompressible, that relaxes by a power law of time."""
    step, way = 0.1, 10.0
    corners = np.cumsum([0.0, 5.0, way / speed, 40.0, way / speed, 5.0])
    time = np.arange(0.0, corners[-1], step)
    travel = np.interp(time, corners, [0.0, 0.0, way, way, 0.0, 0.0])
    stretch = 1.0 + travel * MM / STRIP.height
    force = STRIP.area * sum(
        2.0 * 15e3 / a * (stretch ** (a - 1.0) - stretch ** (-0.5 * a - 1.0)) for a in ALPHA
    )
    kept = (1.0 + time / 0.3) ** -0.07
    force = np.maximum(fftconvolve(np.diff(force, prepend=0.0), kept)[: len(time)], 0.0)
    noise = 2e-3 * force.max() * np.random.default_rng(seed).normal(size=len(time))
    columns = {"time_s": time, "displacement_mm": travel, "force_N": force + noise}
    return Record.of_table(pd.DataFrame(columns)).marked("tension")


def test_what_explains_most_is_followed_where_a_second_effect_hides_it():
    """Relaxation explains twice what `bond_peel` does, which was likelier alone and all there was.

    The model's Poisson's ratio is not that of the strip, so that one effect is not enough.
    """
    tests, effects = strip_tests([faded(0.16, 0), faded(0.8, 1)], [])
    found = diagnose(tests, LoopSettings(), effects).selection
    assert found.classes["viscoelastic_relaxation"][0] == "viscoelastic_relaxation"
    others = {"bond_peel", "unloading_loss", "mullins_softening"}
    assert others.isdisjoint(found.classes["viscoelastic_relaxation"])
    models = {frozenset(one.fit.model.names) for one in weighed(found, {})}
    for name, members in found.classes.items():  # the interval holds each beside all else
        rest = set(found.classes) - {name}
        assert all(frozenset({*rest, member}) in models for member in members)
