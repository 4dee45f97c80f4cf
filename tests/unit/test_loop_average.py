"""The modulus averaged over the models that records leave open."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm

import laboratory
from laboratory import page
from softsample.loop.average import Weighed, averaged, weighed
from softsample.loop.deviation import birge_ratio, bond_deviation, log_modulus_deviation
from softsample.loop.diagnose import diagnose
from softsample.loop.effects import library
from softsample.loop.posed import LoopSettings, pose
from softsample.loop.screen import penalty
from softsample.loop.verdict import report

SETTINGS = LoopSettings()


def model_of(mu, deviation, weight):
    """A model of which nothing counts but its modulus [Pa] and the deviation of its logarithm."""
    state = SimpleNamespace(material=SimpleNamespace(mu=mu))
    return Weighed(SimpleNamespace(state=state), weight, weight, deviation, (mu, deviation))


def test_of_one_model_the_interval_is_its_own():
    mu, low, high = averaged([model_of(1000.0, 0.05, 1.0)])
    assert mu == pytest.approx(1000.0)
    assert np.log(high / mu) == pytest.approx(norm.ppf(0.95) * 0.05, rel=1e-6)
    assert np.log(mu / low) == pytest.approx(norm.ppf(0.95) * 0.05, rel=1e-6)


def test_of_two_models_far_apart_each_end_is_a_quantile_of_one():
    """With weights of 1/4 and 3/4 the lower 5 % are a fifth of the first, the upper a fifteenth."""
    models = [model_of(500.0, 0.05, 0.25), model_of(2000.0, 0.05, 0.75)]
    mu, low, high = averaged(models)
    assert mu == pytest.approx(500.0**0.25 * 2000.0**0.75)
    assert np.log(low / 500.0) == pytest.approx(norm.ppf(0.2) * 0.05, rel=1e-6)
    assert np.log(high / 2000.0) == pytest.approx(norm.ppf(1.0 - 0.05 / 0.75) * 0.05, rel=1e-6)


def test_the_interval_holds_fit_scale_and_what_scatters():
    _, fit = plain(("tension", "compression"), ())
    of_fit = birge_ratio(fit) * np.sqrt(fit.covariance[0, 0])
    expected = np.hypot(of_fit, 0.01 * SETTINGS.noise.scale_percent)
    assert log_modulus_deviation(fit, {}) == pytest.approx(expected)
    scattered = {"A": 0.8, "B": 1.25}
    expected = np.hypot(expected, np.std(np.log([0.8, 1.25]), ddof=1) / np.sqrt(2.0))
    assert log_modulus_deviation(fit, scattered) == pytest.approx(expected)


@pytest.mark.parametrize(("drawn", "expected"), [(0.5, 1.0), (2.0, 2.0)])
def test_what_is_left_beyond_the_discrepancy_widens_the_interval(drawn, expected):
    """Of errors drawn at some multiple of the sizes that the fit is told."""
    told = replace(SETTINGS.noise, spread=1.0)
    sizes = dict.fromkeys(("smooth", "kinked", "rough", "history", "scale"), drawn)
    ratios = []
    for seed in range(24):
        tests = laboratory.drawn(laboratory.Lab(seed=3).specimens(), told, sizes, seed=seed)
        problem, _ = pose(tests, told)
        ratios.append(birge_ratio(problem.fit_material()))
    assert np.sqrt(np.mean(np.square(ratios))) == pytest.approx(expected, rel=0.15)


def plain(modes, bonded):
    """Problem and plain fit of tests, of which those of some modes lose a fifth of their force."""
    tests = [
        replace(test, bond=np.log(0.8) if test.mode in bonded else 0.0)
        for test in laboratory.Lab(seed=3).specimens(modes)
    ]
    problem, _ = pose(tests, SETTINGS.noise)
    return problem, problem.fit_material()


def test_a_test_alone_does_not_tell_its_bonded_area():
    assert bond_deviation(plain(("shear",), ("shear",))[1]) == pytest.approx(
        -np.log(0.8) / np.sqrt(3.0), rel=0.02
    )
    assert bond_deviation(plain(("shear",), ())[1]) == 0.0


def test_compression_beside_it_tells_some_of_the_bonded_area():
    """Against the joint covariance with the step to the other rule as a parameter more."""
    problem, fit = plain(("tension", "compression"), ("tension",))
    forces = problem.predicted(fit.model, fit.state)
    lost = problem.white([np.log(0.8) * forces[0], 0.0 * forces[1]])
    jacobian = np.column_stack([fit.jacobian[: problem.count], lost])
    joint = jacobian.T @ jacobian
    joint[:-1, :-1] = fit.information
    joint[-1, -1] += 3.0
    more = np.linalg.inv(joint)[0, 0] - fit.covariance[0, 0]
    found = bond_deviation(fit)
    assert found == pytest.approx(np.sqrt(more))
    assert 0.0 < found < 0.5 * -np.log(0.8) / np.sqrt(3.0)


def test_the_bonded_area_widens_the_interval():
    _, fit = plain(("shear",), ("shear",))
    found = Weighed.of(fit, 1.0, 1.0, {}).deviation
    alone = log_modulus_deviation(fit, {})
    assert found == pytest.approx(np.hypot(alone, bond_deviation(fit)))
    assert found > 1.5 * alone


def softer(part, smooth):
    """Records of a lower Poisson's ratio, by a part of 0.02, with smooth errors [% of peak]."""
    records = []
    for test in laboratory.Lab(seed=3).specimens():
        curves, changes = test.elastic.curves, test.elastic.perturbations["poisson_0.02_less"]
        lost = np.interp(test.travel, curves.displacement, changes.curve(0.5))
        records.append(replace(test, force=test.force + part * laboratory.MU * lost))
    sizes = {"smooth": smooth, "rough": smooth, "history": smooth, "scale": 5.0 * smooth}
    return laboratory.drawn(records, SETTINGS.noise, sizes, seed=1)


@cache
def with_law(part):
    """What is selected of such records if another law is the only other candidate."""
    known = [library()[name] for name in ("poisson_ratio", "elastic_law")]
    return diagnose(softer(part, 0.1), SETTINGS, known).selection


@pytest.fixture(scope="module")
def withheld():
    known = [library()[name] for name in ("poisson_ratio", "force_drift")]
    return diagnose(softer(0.5, 0.1), SETTINGS, known)


def test_weights_are_odds_of_evidence_and_prior(withheld):
    """Against the misfits of the path, put together by hand."""
    selection, models = withheld.selection, weighed(withheld.selection, {})
    assert sum(one.weight for one in models) == pytest.approx(1.0)
    weights = {tuple(one.fit.model.names): one.weight for one in models}
    (one,) = [c for c in selection.steps[0].candidates if c.name == "poisson_ratio"]
    left = one.settled.misfit + penalty(library()["poisson_ratio"], len(one.fit.white))
    nothing = min(selection.base.misfit, selection.final.misfit)
    odds = 0.5 * np.exp(-0.5 * (left - nothing))
    assert weights["poisson_ratio",] / weights[()] == pytest.approx(odds)


def test_the_interval_holds_what_is_reported_beside_a_likelier_model_that_was_refused(withheld):
    models = weighed(withheld.selection, {})
    of = {one.fit.model.names: one for one in models}
    reported = of[withheld.selection.final.model.names]
    assert reported.weight < 0.1 * max(one.weight for one in models)
    assert reported.alike == pytest.approx(max(one.alike for one in models))
    _, low, high = averaged(models)
    assert low < reported.mu < high


def test_another_law_is_as_probable_beforehand_as_the_one_of_the_study():
    """Laws share one half; all other effects share the other with none of them."""
    selection = with_law(0.5)

    def odds(*more):
        of = {"poisson_ratio": 0.0, "elastic_law": 0.0}
        every = [*selection.library, *(library()[name] for name in more)]
        models = weighed(replace(selection, library=every), {})
        of |= {"".join(one.fit.model.names): one.weight for one in models}
        return np.array([of["elastic_law"], of["poisson_ratio"]]) / of[""]

    law, other = odds()
    assert min(law, other) > 0.0
    np.testing.assert_allclose(odds("force_drift", "force_offset"), (law, other / 3.0))
    np.testing.assert_allclose(odds("ogden_exponents"), (law / 2.0, other))


def test_the_interval_holds_what_the_records_do_not_tell_from_the_choice():
    """Of two effects one is chosen; the other is weighed within its class and outside."""
    selection = with_law(2.0)
    opening = selection.steps[0]
    names = [candidate.name for candidate in opening.candidates]
    assert opening.chosen.name == names[0] == "poisson_ratio"
    found = []
    for members in (names[:1], names):
        steps = [replace(opening, members=members), *selection.steps[1:]]
        models = weighed(replace(selection, steps=steps), {})
        of = {one.fit.model.names: one for one in models}
        other, chosen = of["elastic_law",], of["poisson_ratio",]
        found.append((averaged(models), other.alike / chosen.alike, other.weight / chosen.weight))
    (alone, apart, _), (wider, alike, weight) = found
    assert apart == weight < 1e-3
    assert alike == pytest.approx(1.0, rel=0.02)  # the last fit settles once more
    assert wider[0] == alone[0]  # the estimate is that of the likeliest
    moduli = [one.fit.state.material.mu for one in models[:2]]
    assert wider[1] <= min(moduli) < max(moduli) <= wider[2]
    assert wider[2] - wider[1] > alone[2] - alone[1]


def test_of_a_class_what_was_chosen_is_as_probable_as_a_likelier_member():
    """A law that errors of geometry may look like gives way to what is beyond them."""
    selection = with_law(2.0)
    opening = selection.steps[0]
    likelier, chosen = opening.candidates[:2]
    step = replace(opening, chosen=chosen, members=[chosen.name, likelier.name])
    models = weighed(replace(selection, steps=[step]), {})
    of = {one.fit.model.names: one for one in models}
    assert of[chosen.name,].weight < 1e-3 * of[likelier.name,].weight
    assert of[chosen.name,].alike == pytest.approx(of[likelier.name,].alike, rel=0.02)
    low, high = averaged(models)[1:]
    assert low <= min(one.mu for one in models[:2]) < max(one.mu for one in models[:2]) <= high


def test_what_was_selected_counts_though_it_explains_nothing(withheld, monkeypatch):
    """Far from it the plain model has no weight; without it, it had all."""
    (one,) = [c for c in withheld.selection.steps[0].candidates if c.name == "poisson_ratio"]
    selection = replace(withheld.selection, final=one.settled)
    monkeypatch.setattr("softsample.loop.average.unusable", lambda fit: "at its end")
    likeliest = weighed(selection, {})[0]
    assert likeliest.fit is one.settled
    assert likeliest.weight > 0.5


def test_an_effect_that_is_withheld_counts_for_the_modulus_to_quote(withheld):
    assert withheld.verdict == "none"
    verdict = report(withheld, SETTINGS)
    quoted, plain = verdict["recommended"], verdict["theta_after"]["mu"]
    assert quoted["models"][0]["effects"] == ["poisson_ratio"]
    assert quoted["estimate"] == "averaged over the models fitted"
    off, before = (abs(mu["value"] / laboratory.MU - 1.0) for mu in (quoted["mu"], plain))
    assert off < 0.5 * before
    assert quoted["mu"]["low"] < laboratory.MU < quoted["mu"]["high"]
    text = page("A1", verdict)
    assert "90 %), of the model with `poisson_ratio`." in text
    assert "could hide is `force_drift`" in text  # the modulus allows for the other one


def test_what_does_not_hold_has_no_weight():
    """Of an objection the modulus is that of what is reported."""
    records = [replace(test, force=test.force * factor) for test, factor in
               zip(laboratory.Lab(seed=3).specimens(), (1.0, 1.6, 0.7), strict=False)]  # fmt: skip
    found = diagnose(records, SETTINGS, [library()["force_drift"]])
    assert found.objection
    quoted = report(found, SETTINGS)["recommended"]
    (model,) = quoted["models"]
    assert quoted["estimate"] == "of the model reported"
    assert model["effects"] == list(found.final.model.names)
    assert model["mu"] == found.final.state.material.mu


@pytest.mark.parametrize("lost", [0.0, 0.4])
def test_what_is_left_of_a_modulus_that_relaxes_is_told_too(lost):
    """Of a stretched exponential, which three times only follow, at the end of the records."""
    tests = laboratory.Lab(seed=5, relaxed=lost).specimens()
    found = diagnose(tests, SETTINGS, [library(tests=tests)["viscoelastic_relaxation"]])
    quoted = report(found, SETTINGS)
    relaxed, told = (
        quoted["recommended"]["mu_relaxed"],
        "are left at the end of the longest record.",
    )
    assert (told in page("A1", quoted)) == (relaxed is not None) == bool(lost)
    if relaxed:
        longest = max(test.clock[-1] for test in tests)
        left = laboratory.MU * (1.0 + lost * np.expm1(-((longest / 9.0) ** 0.6)))
        assert relaxed["value"] == pytest.approx(left, rel=0.03)
        assert relaxed["low"] < left < relaxed["high"]
        shared = norm.ppf(0.95) * 0.01 * SETTINGS.noise.scale_percent
        assert shared < np.log(relaxed["high"] / relaxed["value"]) < 2.0 * shared
