"""Errors that tests of one piece have in common, and blocks of fast ramps."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import OptimizeResult

import laboratory
from softsample.loop import discrepancy
from softsample.loop.noise import SIMILARITY, NoiseSettings, block_size
from softsample.loop.posed import pose
from softsample.loop.same_piece import same_piece

SETTINGS = NoiseSettings()


def repeats():
    """Two tests of one piece in shear, the second twice as fast, and one of another piece."""
    (one,) = laboratory.Lab(seed=7).specimens(["shear"])
    faster = replace(one, name="again", time=0.5 * one.time, piece=one.piece)
    return [one, faster, replace(one, name="other", piece="other")]


def by_hand(problem, sizes):
    """Joint covariance of the blocks of three tests, of which the first two share errors [N2]."""
    n = [len(w.known) for w in problem.whiteners]
    common = np.concatenate(
        [w.blocks(c) for w, c in zip(problem.whiteners, problem.common, strict=True)]
    )
    joint = np.outer(common, common)
    parts = np.split(np.arange(len(joint)), np.cumsum(n)[:-1])
    for w, own in zip(problem.whiteners, parts, strict=True):
        of = w.alone
        joint[np.ix_(own, own)] += of.known
        joint[np.ix_(own, own)] += sum(v * of.part(name) for name, v in sizes.items())
    one, again, _ = (w.shared for w in problem.whiteners)
    cross = sum(sizes[name] * one[name] @ again[name].T for name in one)
    joint[np.ix_(parts[0], parts[1])] += cross
    joint[np.ix_(parts[1], parts[0])] += cross.T
    return joint


def test_tests_of_one_piece_that_go_as_far_at_several_speeds_share_their_errors():
    one, again, other = repeats()
    assert same_piece([one, other, again]) == [0, None, 0]
    assert same_piece([one, replace(again, travel=2.0 * again.travel)]) == [None, None]
    assert same_piece([one, replace(again, mode="tension")]) == [None, None]
    assert same_piece([one, replace(one, name="across")]) == [None, None]  # of one speed
    assert same_piece([one, replace(again, timed=False)]) == [None, None]


def test_residuals_are_whitened_and_judged_by_the_joint_covariance():
    sizes = {
        "smooth": 4.0,
        "kinked": 2.0,
        "rough": 1.0,
        "history": 0.3,
        "wander": 0.5,
        "scale": 9.0,
    }
    problem = pose(repeats(), SETTINGS)[0].with_variances(sizes)
    joint = by_hand(problem, sizes)
    rng = np.random.default_rng(3)
    residual = [rng.normal(size=len(s.force)) for s in problem.specimens]
    means = np.concatenate([w.blocks(r) for w, r in zip(problem.whiteners, residual, strict=True)])
    white = problem.white(residual)
    assert white @ white == pytest.approx(means @ np.linalg.solve(joint, means), rel=1e-6)
    np.testing.assert_allclose(np.concatenate(problem.coloured(white)), means, rtol=1e-6, atol=1e-9)
    fit = problem.fit_material()
    left = problem.residual(fit.model, fit.state)
    likelihood = fit.misfit - left @ left - problem._unlikely_sizes
    assert likelihood == pytest.approx(np.linalg.slogdet(joint)[1], rel=1e-6)


@pytest.mark.parametrize("name", list(SIMILARITY))
def test_variates_at_knots_give_the_correlation_of_the_whole_travel(name):
    alone, shared = (pose(tests, SETTINGS)[0].whiteners[0].alone
                     for tests in (repeats()[:1], repeats()))  # fmt: skip
    exact, found = (w.part(name) for w in (alone, shared))
    assert np.abs(found - exact).max() < 0.02 * np.abs(exact).max()


def test_the_slope_of_the_restricted_likelihood_is_its_derivative(monkeypatch):
    problem, _ = pose(repeats(), SETTINGS)
    asked = []

    def minimize(value, start, args, **_):
        asked.append((value, args))
        return OptimizeResult(x=start, fun=0.0)

    monkeypatch.setattr(discrepancy, "minimize", minimize)
    discrepancy.estimated(problem, problem.fit_material())
    value, args = asked[0]
    here = np.array([0.3, -0.1, -0.2, 0.5, -0.4, 0.1])
    _, slope = value(here, *args)
    for k, step in enumerate(1e-4 * np.eye(6)):
        ahead, behind = (value(here + way * step, *args)[0] for way in (1.0, -1.0))
        assert slope[k] == pytest.approx((ahead - behind) / 2e-4, rel=1e-4, abs=1e-4)


@pytest.mark.parametrize(("shared", "larger"), [(True, "shared"), (False, "own")])
def test_what_tests_of_one_piece_share_is_told_from_what_is_their_own(shared, larger):
    """Five tests of one piece with a wave of 4 % along the travel, the same in each or not."""
    (one,) = laboratory.Lab(seed=7).specimens(["shear"])
    tests = []
    for k in range(5):
        wave = np.sin(12.0 * one.travel / one.reach + (0.0 if shared else k))
        force, time = one.force + 0.04 * one.peak * wave, (1.0 + k) * one.time
        tests.append(replace(one, name=str(k), piece="A", time=time, force=force))
    problem, _ = pose(tests, SETTINGS)
    of_shared = discrepancy.settled(problem, problem.fit_material())
    sizes = SETTINGS.sizes(of_shared.problem.variances)
    found = {
        "shared": np.hypot(sizes["smooth"], sizes["kinked"]) / SETTINGS.floor_percent,
        "own": np.hypot(sizes["rough"], sizes["history"])
        / np.hypot(SETTINGS.fine_percent, SETTINGS.history_percent),
    }
    assert found.pop(larger) > 2.0
    assert min(found.values()) < 1.5


def test_a_block_is_no_longer_than_what_is_rough_in_a_fast_ramp():
    (one,) = laboratory.Lab(seed=7).specimens(["shear"])
    usual = block_size(one, SETTINGS)
    assert usual == round(SETTINGS.block_s / np.median(np.diff(one.time)))
    fast = replace(one, time=0.02 * one.time)
    ramp = max(part.stop - part.start for part in one.stretches if one.phase[part.start] == "ramp")
    assert block_size(fast, SETTINGS, most=10**6) == round(SETTINGS.fine_length * ramp) < 50 * usual
    held = replace(one, time=0.02 * one.time, held_out=np.ones(len(one.time), bool))
    assert block_size(held, SETTINGS, most=10**6) == 50 * usual
