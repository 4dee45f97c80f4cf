"""The blind laboratory from end to end, small: one coarse sample, a handful of experiments."""

from dataclasses import replace

import numpy as np
import pytest

from softsample.blindlab.curves import planted_curves
from softsample.blindlab.judge import Resolution, answer, elastics
from softsample.blindlab.models import model_curves
from softsample.blindlab.plan import Benches, Experiment
from softsample.blindlab.records import Floor
from softsample.blindlab.score import Case, score
from softsample.fem.explicit import SolverSettings
from softsample.loop.posed import LoopSettings
from softsample.response.pieces import PerturbationSettings

BENCHES = Benches(cuboids=1, shapes=1, first=31)
SOLVER = SolverSettings(loading_time_s=0.2, curve_error_percent=0.3)
COARSE = Resolution(floor_percent=0.2, fine_percent=0.2, scale_percent=0.5, contact_zero_mm=0.01)
pytestmark = pytest.mark.study

NAMED = ("force_offset", "force_drift", "viscoelastic_relaxation", "self_weight")


@pytest.fixture(scope="module")
def bench():
    """A cuboid, its curves at 2 mm and the loop's model of it at 2.4 mm."""
    (body,) = BENCHES.bodies(imperfect=False)
    curves = planted_curves(body, (1.0,), 2.0, SOLVER)
    table = model_curves(body, 2.4, SOLVER, PerturbationSettings())
    return body, curves, elastics(table, body)


def judged(bench, kind, names=(), size=1.0, seed=31):
    body, curves, models = bench
    experiment = Experiment(kind, names, "B", size, 0.0, seed)
    settings = COARSE.settings(LoopSettings(), 0.0)
    records = experiment.records(body, curves, Floor(0.0))
    return Case(experiment.planted(body), answer(records, models, settings))


@pytest.fixture(scope="module")
def cases(bench):
    singles = [judged(bench, "effect", (name,)) for name in NAMED]
    nulls = [judged(bench, "null", seed=seed) for seed in (31, 32)]
    return [*singles, *nulls, judged(bench, "scale", ("gain",))]


def test_the_two_meshes_agree_but_are_not_the_same(bench):
    body, curves, models = bench
    for mode, model in models.items():
        plain = curves[(curves["mode"] == mode) & (curves["curve"] == "plain")]
        travel = plain["displacement_mm"].to_numpy()
        one, other = plain["area_mm2"], 1e6 * model.force_per_mu(body.mixture, 1e-3 * travel)
        apart = np.abs(one - other)[travel <= body.stroke(mode)].max() / np.abs(one).max()
        assert 1e-5 < apart < 0.02


def test_plain_effects_are_named_and_nothing_is_found_where_nothing_is(cases):
    rows = {row["goal"]: row["value"] for row in score(cases)}
    assert rows["1 false alarms"] == 0.0
    assert rows["scale not called identifiable"] == 1.0
    assert rows["2 effects with power"] == len(NAMED)
    assert rows["3 class correct when noticed"] >= 0.75
    assert rows["5 confidently wrong"] <= 0.25


@pytest.mark.long
def test_verdicts_do_not_depend_on_the_order_of_the_records(bench):
    body, curves, models = bench
    experiment = Experiment("effect", ("force_offset",), "B", 1.0, 0.0, 33)
    records = experiment.records(body, curves, Floor(0.0))
    settings = COARSE.settings(LoopSettings(), 0.0)
    one, other = (answer(order, models, settings) for order in (records, records[::-1]))
    assert one["verdict"] == other["verdict"]
    assert [e["class"] for e in one["effects"]] == [e["class"] for e in other["effects"]]


def test_a_floor_is_told_to_the_loop():
    told = Resolution().settings(LoopSettings(), 1.0).noise
    assert told.floor_percent == pytest.approx(np.hypot(1.0, 0.1))
    assert told.scale_percent == Resolution().scale_percent
    again = replace(told, floor_percent=0.1)
    assert again == Resolution().settings(LoopSettings(), 0.0).noise
