"""Corrections: what no effect explains, as a smooth function of the travel."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import laboratory
from laboratory import page
from softsample.figures.loop import loop_figure
from softsample.loop.correction import NAME, _can_tell, _stage, _within, best_predictor, learned
from softsample.loop.diagnose import diagnose
from softsample.loop.discrepancy import settled
from softsample.loop.effects import library
from softsample.loop.errors import cross_validated, folds, held_out_errors
from softsample.loop.posed import LoopSettings, pose
from softsample.loop.select import select
from softsample.loop.specimen import Specimen
from softsample.loop.verdict import judgement, report
from softsample.report.residual import residual_table
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
    plain = held_out_errors(found.selection.base, tests, {}, found.scales_before)
    after = held_out_errors(found.predicting, tests, {}, found.scales)
    domain = correction["domain_mm"]
    assert set(domain) == {"tension", "compression", "shear"}
    assert all(after[name].rms < plain[name].rms for name in domain)
    assert all(after[name].rms < 0.25 * plain[name].rms for name in ("tension", "shear"))
    for s in tests:
        assert domain[s.mode] == pytest.approx(1e3 * BEYOND * s.reach, rel=0.01)


def test_a_mode_is_corrected_only_where_folds_confirm_it():
    """Jumps of the force in shear are no function of the strain."""
    jumps = 0.02 * np.repeat(np.random.default_rng(3).normal(size=400), 50)
    tension, compression, _ = bent(20.0)
    shear = laboratory.Lab(seed=5).specimens(["shear"])[0]
    shear = replace(shear, force=shear.force + shear.peak * jumps[: len(shear.force)])
    tests = [tension, compression, shear]
    judged = diagnose(tests, SETTINGS, [library()["force_offset"]])
    fit = judged.selection.base
    found = best_predictor([(fit, cross_validated(fit))], judged.posed.spread)
    assert found.learned is not None
    assert "shear" not in found.report()["domain_mm"]
    np.testing.assert_array_equal(
        found.whole.model.predict(shear, found.whole.state), fit.model.predict(shear, fit.state)
    )


def doubled(curves):
    """Curves of a sample twice as wide."""
    forces = np.stack([2.0 * curves.curve(r) for r in curves.fractions])
    return ResponseCurves(curves.fractions, curves.displacement, forces)


def test_nothing_is_corrected_where_nothing_is_wrong():
    """Nor does a verdict without a misfit hold a correction."""
    found = diagnose(laboratory.Lab(seed=5).specimens(), SETTINGS, [library()["force_offset"]])
    assert (found.verdict, found.correction) == ("none", None)
    plain = found.selection.base
    assert best_predictor([(plain, cross_validated(plain))], found.posed.spread) is None


@pytest.mark.parametrize("came_there", ["visited", "refused", ""])
def test_folds_choose_among_all_models_that_a_search_came_to(came_there, monkeypatch):
    """Of records that relax and a selection that has dropped relaxation, or it was at an end."""

    def dropped(problem, known, settings):
        found = select(problem, known, settings)
        assert found.final.model.names == ("viscoelastic_relaxation",)
        last = replace(found.steps[-1], refused=None)
        if came_there == "refused":
            last = replace(last, refused=found.steps[0].chosen, why="it lies at an end")
        visited = [found.final] if came_there == "visited" else []
        return replace(found, final=found.base, classes={}, visited=visited, steps=[last])

    monkeypatch.setattr("softsample.loop.diagnose.select", dropped)
    monkeypatch.setattr("softsample.loop.diagnose.driven_to_an_end", lambda fit: "g1")
    known = [library()["viscoelastic_relaxation"]]
    found = diagnose(laboratory.Lab(seed=5, relaxed=0.4).specimens(), SETTINGS, known)
    assert found.objection
    told = found.correction.report() if found.correction else {"with": [], "class": ""}
    expected = (["viscoelastic_relaxation"], "history") if came_there else ([], "")
    assert (told["with"], told["class"]) == expected


@pytest.mark.parametrize(
    ("effect", "kind"),
    [
        ("viscoelastic_relaxation", "history"),
        ("unloading_loss", "history"),
        ("elastic_law", "elastic_form"),
        ("real_geometry", "elastic_form"),
        ("mode_ratio", "mode_ratio"),
        ("tension_compression_asymmetry", "mode_ratio"),
        ("specimen_stiffness", "specimen_stiffness"),
        ("late_contact", "zero"),
        ("force_drift", "drift"),
        ("channel_crosstalk", "cross_talk"),
    ],
)
def test_effects_that_are_no_cause_stand_for_a_class(effect, kind):
    assert _stage(library()[effect]) == kind


def test_a_search_remembers_models_of_other_effects_once_the_smallest_first():
    two = laboratory.Lab(seed=5, relaxed=0.4, offset={"tension": 20.0}).specimens()
    problem, _ = pose(two, SETTINGS.noise)
    few = ("viscoelastic_relaxation", "force_offset", "force_drift")
    chosen = select(problem, [library()[name] for name in few], SETTINGS.selection)
    names = [frozenset(fit.model.names) for fit in chosen.visited]
    assert names
    assert len(set(names)) == len(names)
    assert frozenset(chosen.final.model.names) not in names
    assert [len(of) for of in names] == sorted(len(of) for of in names)


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
    _, fit = fitted([first])
    whole = learned(fit).of(fit)
    assert whole.model.names == (NAME,)
    change = [whole.model.predict(s, whole.state) - fit.model.predict(s, fit.state)
              for s in (first, other)]  # fmt: skip
    own = learned(fit).scale[first.name, first.mode, first.channel]
    smooth = change[0] - own * fit.model.predict(first, fit.state)
    np.testing.assert_allclose(change[1], 2.0 * smooth, atol=1e-6 * np.abs(change[1]).max())


@pytest.mark.parametrize("ratio", [0.4, 2.5])
def test_scales_of_tests_are_learned_beside_what_they_share(ratio):
    """Of two specimens that differ in stiffness, with a bow that one law does not follow."""
    one = bent(10.0)[0]
    other = replace(one, name="other", piece="other", force=ratio * one.force)
    fit = settled(*fitted([one, other]))
    correction = learned(fit)
    scales = [1.0 + correction.scale[s.name, s.mode, s.channel] for s in (one, other)]
    assert scales[1] / scales[0] == pytest.approx(ratio, rel=0.1)
    whole = correction.of(fit)
    for s in fit.problem.specimens:
        left = s.force - whole.model.predict(s, whole.state)
        assert np.sqrt(np.mean(left**2)) < 0.02 * s.peak


def test_scales_that_differ_within_specimens_are_no_stiffness_of_specimens():
    keys = [(piece, mode, "force") for piece in "ab" for mode in ("tension", "shear")]
    assert _within(dict(zip(keys, [0.3, -0.2, 0.25, -0.3], strict=True)))
    assert not _within(dict(zip(keys, [0.3, 0.25, -0.2, -0.3], strict=True)))


def fitted(tests):
    """Records as a problem, and the plain model's fit."""
    problem, _ = pose(tests, SETTINGS.noise)
    return problem, problem.fit_material()


def fung(mode, sign=1.0, toe=0.0, seed=5):
    """A test with sliding ends of an incompressible solid (Demiray's), to a strain of 0.5.

    What is beyond a strain of 0.35 is held out. A `toe` [N] is lost where contact begins.
    """
    shape, mu, b = laboratory.SHAPE, 1000.0, 0.8
    strain = np.linspace(0.0, 0.5, 200)
    if mode == "shear":
        stress = mu * strain * np.exp(b * strain**2)
    else:
        stretch = 1.0 - strain
        first = stretch**2 + 2.0 / stretch - 3.0
        stress = mu * (stretch**-2 - stretch) * np.exp(b * first)
    force = shape.area * stress - toe * (1.0 - np.exp(-strain / 0.02)) * np.exp(-strain / 0.1)
    noise = 1e-3 * np.random.default_rng(seed).normal(size=len(strain))
    return Specimen(
        mode,
        mode,
        0.1 * np.arange(200),
        sign * strain * shape.height,
        sign * force + noise,
        np.full(200, "ramp"),
        laboratory.exact(mode, shape, 0.55),
        held_out=strain > 0.35,
    )


def errors_beyond(tests, wanted):
    """Error of what is held out of tests [% of peak], without and with a correction."""
    _, fit = fitted(tests)
    whole = learned(fit).of(fit)
    found = [held_out_errors(f, wanted, {}, {}) for f in (fit, whole)]
    return [100.0 * np.mean([e.rms / e.peak for e in of.values()]) for of in found]


@pytest.mark.parametrize("toe", [0.0, 0.01])
def test_it_goes_on_as_the_ratio_of_two_laws_does(toe):
    """Also where the contact develops, which a smooth function of large strains cannot follow."""
    tests = [fung("compression", toe=toe)]
    plain, corrected = errors_beyond(tests, tests)
    assert plain > 15.0
    assert corrected < 0.5 * plain  # 0.44; 0.62 if it changed over a stroke


def test_it_is_the_same_in_both_directions_of_shear():
    one, other = fung("shear"), fung("shear", -1.0)
    plain, corrected = errors_beyond([one], [replace(other, held_out=np.ones(200, bool))])
    assert plain > 2.0
    assert corrected < 0.25 * plain


def test_the_modulus_to_quote_holds_what_a_correction_makes_of_it():
    """The pair of exponents finds 737 Pa in shear."""
    test = replace(fung("shear"), held_out=np.zeros(200, bool))
    found = diagnose([test], SETTINGS, [library()["force_offset"]])
    assert found.verdict == "explained_class"
    verdict = report(found, SETTINGS)
    factor = verdict["correction"]["modulus_factors"]["shear"]
    assert factor * verdict["theta_after"]["mu"]["value"] == pytest.approx(1000.0, rel=0.25)
    mu = verdict["recommended"]["mu"]
    assert mu["low"] <= 1000.0 <= mu["high"]
    assert f"It multiplies the modulus at small strain (shear {factor:.3g})" in page("G", verdict)


def test_the_modulus_to_quote_holds_what_no_fold_confirms():
    """The pair of exponents finds 200 Pa, and hardly predicts the end of the stroke better."""
    test = replace(fung("compression"), held_out=np.zeros(200, bool))
    found = diagnose([test], SETTINGS, [library()["force_offset"]])
    assert (found.verdict, found.correction) == ("unknown", None)
    verdict = report(found, SETTINGS)
    mu = verdict["recommended"]["mu"]
    assert mu["low"] <= mu["value"] < 300.0
    assert mu["high"] > 1000.0
    assert "what the error that is left makes of the modulus" in page("G", verdict)


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


def test_the_figure_marks_what_is_held_out_and_has_one_unit_of_residuals(found):
    figure = loop_figure(found)
    entries = [text.get_text() for text in figure.legends[0].get_texts()]
    assert entries == ["measured", "held out", "before", "after"]
    largest = max(np.abs(line.get_ydata()).max() for ax in figure.axes[3:] for line in ax.lines)
    assert figure.axes[3].get_ylabel() == "residual [mN]"
    assert largest == pytest.approx(
        1e3 * max(float(np.abs(s.force - m).max()) for s, m in residuals(found)), rel=0.1
    )


def test_the_table_of_residuals_has_the_curves_of_the_figure(tests, found):
    """With the signs of records; what is held out has rows too."""
    table = residual_table(found).set_index("mode")
    assert set(table["sample"]) == {s.name for s in tests}
    half_a_block = 0.03
    pressed, pulled = table.loc["compression"], table.loc["tension"]
    assert pressed["force_N"].min() < -0.9 * tests[1].peak
    assert pressed["displacement_mm"].min() == pytest.approx(-1e3 * tests[1].reach, half_a_block)
    fitted = pulled[~pulled["held_out"]]["displacement_mm"].max()
    assert fitted == pytest.approx(1e3 * BEYOND * tests[0].reach, half_a_block)
    columns = [line.get_ydata() for line in loop_figure(found).axes[0].lines[2:]]
    for name, drawn in zip(("before_N", "after_N"), columns, strict=True):
        np.testing.assert_allclose(pulled[name], drawn)


@pytest.mark.parametrize("fitted", [0, 5])
def test_table_and_figure_have_tests_of_which_not_one_block_is_fitted(tests, fitted):
    held_out = np.arange(len(tests[0].force)) >= fitted
    whole = replace(tests[0], name="another", held_out=held_out)
    found = diagnose([*tests, whole], SETTINGS, [library()["force_offset"]])
    drawn = {ax.get_title(): ax.lines[0] for ax in loop_figure(found).axes}
    assert drawn["another\ntension"].get_label() == "held out"
    table = residual_table(found)
    another = table[table["sample"] == "another"]
    assert another["held_out"].all()
    error = (another["force_N"] - another["after_N"]).abs().max()
    assert 0.0 < error < 0.2 * another["force_N"].max()


def residuals(found):
    """Tests and what the first model predicts of them."""
    first = found.posed.first
    forces = first.problem.predicted(first.model, first.state)
    return zip(found.posed.problem.specimens, forces, strict=True)


@pytest.mark.parametrize(("count", "told"), [(1, False), (2, True), (7, True)])
def test_a_fold_tells_of_a_correction_if_tests_of_its_kind_are_left(count, told):
    """Also where several tests are left out together; what follows the ramp is part of all."""
    one = laboratory.Lab(seed=1).specimens(["tension"])[0]
    problem, _ = pose([one] * count, SETTINGS.noise)
    for name, masks in folds(problem).items():
        fold = SimpleNamespace(masks=masks)
        expected = told if name.startswith("leave_out") else name == "last_quarter"
        assert _can_tell(problem, name, fold) == expected
