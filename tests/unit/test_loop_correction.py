"""Corrections: what no effect explains, as a smooth function of the travel."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import laboratory
from softsample.loop.correction import NAME, _can_tell, confirmed, learned
from softsample.loop.diagnose import diagnose, judgement, report
from softsample.loop.effects import library
from softsample.loop.errors import cross_validated, folds, held_out_errors
from softsample.loop.page import page
from softsample.loop.posed import LoopSettings, pose
from softsample.response.curves import ResponseCurves

SETTINGS = LoopSettings()
BEYOND = 0.8


def bent(percent, seed=5):
    """Tests whose force has another form than the model's: a bow, of a part of the peak."""

    def bow(s):
        way = np.abs(s.travel) / s.reach
        return 0.04 * percent * s.peak * way * (1.0 - way)

    return [replace(s, force=s.force + bow(s)) for s in laboratory.Lab(seed=seed).specimens()]


@pytest.fixture(scope="module")
def tests():
    """Tests whose last part is held out."""
    return [replace(s, held_out=np.abs(s.travel) > BEYOND * s.reach) for s in bent(10.0)]


@pytest.fixture(scope="module")
def found(tests):
    """Diagnosis of these."""
    return diagnose(tests, SETTINGS, [library()["force_offset"]])


def test_what_another_law_leaves_is_corrected_and_goes_on_beyond_what_was_fitted(tests, found):
    verdict = judgement(found, SETTINGS)
    assert (verdict["verdict"], verdict["effects"]) == ("explained_class", [])
    correction = verdict["correction"]
    assert (correction["class"], correction["with"]) == ("elastic_form", [])
    assert correction["left_out_after_percent"] < 0.8 * correction["left_out_before_percent"]
    plain = held_out_errors(found.selection.base, tests, 0.0, found.scales_before)
    after = held_out_errors(found.predicting, tests, 0.0, found.scales)
    domain = correction["domain_mm"]
    assert set(domain) == {"tension", "shear"}
    assert all(after[name].rms < 0.8 * plain[name].rms for name in domain)
    assert after["compression"] == plain["compression"]  # it goes on too steeply there
    for s in tests:
        if s.mode in domain:
            assert domain[s.mode] == pytest.approx(1e3 * BEYOND * s.reach, rel=0.01)


def doubled(curves):
    """Curves of a sample twice as wide."""
    forces = np.stack([2.0 * curves.curve(r) for r in curves.fractions])
    return ResponseCurves(curves.fractions, curves.displacement, forces)


def test_nothing_is_corrected_where_nothing_is_wrong():
    """Nor does a verdict without a misfit hold a correction."""
    found = diagnose(laboratory.Lab(seed=5).specimens(), SETTINGS, [library()["force_offset"]])
    assert (found.verdict, found.correction) == ("none", None)
    spread = [noise.block for noise in found.noises]
    plain = found.selection.plain, found.selection.base
    assert confirmed([(*plain, cross_validated(*plain))], spread) is None


def test_tests_of_one_mode_share_a_correction_in_proportion_to_their_force():
    """The second test is of a sample twice as wide that nothing was fitted to."""
    first = bent(10.0)[0]
    other = replace(
        first,
        name="wide",
        piece="wide",
        force=2.0 * first.force,
        elastic=replace(first.elastic, curves=doubled(first.elastic.curves)),
        held_out=np.ones(len(first.force), bool),
    )  # fmt: skip
    problem, _ = pose([first], SETTINGS.noise)
    fit = problem.fit_material()
    whole = learned(problem, fit).of(fit)
    assert whole.model.names == (NAME,)
    change = [whole.model.predict(s, whole.state) - fit.model.predict(s, fit.state)
              for s in (first, other)]  # fmt: skip
    own = learned(problem, fit).scale[first.name, first.mode, first.channel]
    smooth = change[0] - own * fit.model.predict(first, fit.state)
    np.testing.assert_allclose(change[1], 2.0 * smooth, atol=1e-6 * np.abs(change[1]).max())


def test_what_is_left_far_above_the_floor_is_not_corrected():
    """Jumps in time are no function of the travel."""
    rng = np.random.default_rng(3)
    jumped = [
        replace(s, force=s.force + 0.2 * s.peak * np.repeat(
            rng.normal(size=len(s.force) // 50 + 1), 50)[: len(s.force)])
        for s in laboratory.Lab(seed=5).specimens()
    ]  # fmt: skip
    found = diagnose(jumped, SETTINGS, [library()["force_offset"]])
    assert (found.verdict, found.correction) == ("unknown", None)


def test_the_page_says_that_it_is_no_cause(found):
    text = page("G", report(found, SETTINGS))
    assert "Correction, not cause (class: elastic form): a smooth part." in text


@pytest.mark.parametrize(("count", "told"), [(1, False), (2, True), (7, True)])
def test_a_fold_tells_of_a_correction_if_tests_of_its_kind_are_left(count, told):
    """Also where several tests are left out together; what follows the ramp is part of all."""
    one = laboratory.Lab(seed=1).specimens(["tension"])[0]
    problem, _ = pose([one] * count, SETTINGS.noise)
    for name, masks in folds(problem).items():
        fold = SimpleNamespace(masks=masks)
        expected = told if name.startswith("leave_out") else name == "last_quarter"
        assert _can_tell(problem, name, fold) == expected
