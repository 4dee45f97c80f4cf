"""Rests of which an effect takes little, and first choices that a second effect shows wrong."""

import re
from copy import deepcopy
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import laboratory
from laboratory import page
from softsample.loop import accept
from softsample.loop import verdict as of_verdict
from softsample.loop.accept import objection_to
from softsample.loop.diagnose import diagnose
from softsample.loop.effects import library
from softsample.loop.model import Model
from softsample.loop.noise import NoiseSettings
from softsample.loop.posed import LoopSettings, pose
from softsample.loop.usable import driven_to_an_end
from softsample.loop.verdict import error_report, extrapolated, judgement, overloaded, report
from softsample.report.loop import verdict_table
from softsample.report.verdict import _unwrapped

OFFSET = library()["force_offset"]


@cache
def judged(offset, settings=None, **planted):
    """Verdict on an offset [mN] of all tests and what else is planted; no file has the steps."""
    lab = laboratory.Lab(seed=5, offset=dict.fromkeys(laboratory.MODES, offset), **planted)
    effects = [library()[name] for name in ("force_offset", "force_drift")]
    return diagnose(lab.specimens(), settings or LoopSettings(), effects)


@cache
def reported(offset):
    """What `verdict.json` holds of it."""
    return report(judged(offset), LoopSettings())


def verdict_on(offset):
    """The same for a test to change."""
    return deepcopy(reported(offset))


def test_what_is_unknown_has_no_effects_and_the_values_of_the_plain_model():
    found = judged(30.0, steps=60.0, drift=0.1)
    assert found.verdict == "unknown"
    assert "force_offset" in found.selection.final.model.names  # it was tried
    verdict = judgement(found, LoopSettings())
    assert verdict["effects"] == []
    for what in ("theta", "error", "folds", "held_out"):
        assert verdict[f"{what}_after"] == verdict[f"{what}_before"]
    assert verdict["path"][0]["chosen"] == "force_offset"


def test_an_effect_that_makes_what_folds_leave_out_less_likely_is_withheld(monkeypatch):
    settings = LoopSettings()
    found = judged(15.0)
    assert (found.verdict, judgement(found, settings)["withheld"]) == ("explained", [])
    rules = settings.selection, settings.noise
    assert objection_to(found.selection, found.before, found.selected, *rules) == ""
    objections = []
    for less in (2.0, 4.0):
        monkeypatch.setattr(
            accept,
            "log_densities",
            lambda fit, folds, less=less: np.array([-less * len(fit.model.effects)]),
        )
        objections.append(objection_to(found.selection, found.before, found.selected, *rules))
    objection = "what folds leave out is exp(4) times less likely with the effects"
    assert objections == ["", objection]  # exp(2) is no more than chance
    verdict = report(replace(found, objection=objection), settings)
    assert (verdict["verdict"], verdict["effects"]) == ("unknown", [])
    (withheld,) = verdict["withheld"]
    assert (withheld["name"], withheld["reason"]) == ("force_offset", objection)
    assert withheld["held_out_if_given"] == error_report(found.selected.folds)
    mu, refused = verdict["recommended"]["mu"], found.selection.final.state.material.mu
    assert mu["value"] == pytest.approx(found.selection.base.state.material.mu)
    assert mu["low"] < refused < mu["high"]
    assert verdict["recommended"]["widened_by_models"]
    left = [e.rms / e.peak for tests in found.selected.folds.values() for e in tests.values()]
    percent = f"{100.0 * np.sqrt(np.mean(np.square(left))):.3g}"
    assert f"With `force_offset`, {percent} % of the peak would be left of what" in page(
        "A7", verdict
    )


def test_an_effect_that_spoils_the_rest_before_loading_is_no_explanation():
    found, settings = judged(15.0), LoopSettings()
    rules = settings.selection, settings.noise
    objections = []
    for more in (0.009, 0.011):
        fitted = {test: dict(phases) for test, phases in found.selected.fitted.items()}
        was = found.before.fitted["shear"]["baseline"]
        left = was.structured + more * was.peak
        fitted["shear"]["baseline"] = replace(was, structured=left)
        spoilt = replace(found.selected, fitted=fitted)
        objections.append(objection_to(found.selection, found.before, spoilt, *rules))
    assert objections[0] == ""
    assert objections[1].startswith("with the effects the rest before shear is off by")


def test_what_is_left_far_above_the_floor_is_more_than_floor():
    """No effect makes a wave along the travel; of which floor it is three times is a setting.

    As it goes on where a part of it was left out, its class is known.
    """

    def wave(percent):
        lab = laboratory.Lab(seed=5).specimens()
        return [
            replace(s, force=s.force + 1e-2 * percent * s.peak * np.sin(9.0 * s.travel / s.reach))
            for s in lab
        ]

    for percent, verdict in ((1.0, "none"), (8.0, "explained_class")):
        found = diagnose(wave(percent), LoopSettings(), [OFFSET])
        left = judgement(found, LoopSettings())["discrepancy_percent"]["after"]
        assert found.verdict == verdict
        assert 0.3 < np.hypot(left["smooth"], left["kinked"]) / (percent / np.sqrt(2.0)) < 3.0


def test_without_effects_the_model_after_is_the_one_before():
    found = judgement(diagnose(laboratory.Lab(seed=8).specimens(), LoopSettings(), [OFFSET]),
                      LoopSettings())  # fmt: skip
    assert found["verdict"] == "none"
    assert found["theta_after"] == found["theta_before"]


@pytest.mark.parametrize("tests", [slice(None), slice(2, None)])
def test_a_long_rest_hides_no_error_of_the_ramp(tests):
    """A fifth of the bond tears off within a ramp of 10 to 22 s, before a rest of 60."""

    def torn(s):
        since = s.time - s.time[np.argmax(s.travel > 0.6 * s.reach)]
        return replace(s, force=s.force * (1.0 - 0.2 * np.clip(since / 0.3, 0.0, 1.0)))

    records = [torn(s) for s in laboratory.Lab(seed=5).specimens()[tests]]
    found = diagnose(records, LoopSettings(), [OFFSET])
    assert found.verdict == "unknown"
    assert re.fullmatch(r"an error of .* is left that no effect explains", found.objection)


def test_an_effect_that_leaves_most_of_an_error_above_the_floor_is_no_explanation():
    """A tissue that becomes 6 % softer within seconds of a hold does not relax."""

    def softer(s):
        since = s.clock - s.clock[s.phase == "hold"][0]
        return replace(s, force=s.force * (0.97 - 0.03 * np.tanh((since - 10.0) / 3.0)))

    tests = [*map(softer, laboratory.Lab(seed=5).specimens())]
    settings = LoopSettings()
    found = diagnose(tests, settings, [library()["viscoelastic_relaxation"]])
    assert found.selection.final.model.names == ("viscoelastic_relaxation",)  # it was tried
    assert 1.0 < found.selected.form < 3.0  # above the floor, not far above it
    assert found.verdict != "explained"
    assert re.fullmatch(r"an error of .* is left that no effect explains", found.objection)
    half = replace(found.selected, form=0.49 * found.before.form)
    rules = settings.selection, settings.noise
    assert objection_to(found.selection, found.before, half, *rules) == ""


def test_a_size_at_the_end_of_its_range_is_no_explanation():
    """An offset of 240 mN is more than the 200 mN that are plausible; a share may be all of it."""
    found = judged(240.0)
    reason = found.objection
    assert found.verdict in ("unknown", "explained_class")  # with a correction or without
    assert re.fullmatch(r"force_offset\.\w+_mN lies at the end of its range", reason)
    verdict = report(found, LoopSettings())
    (withheld,) = verdict["withheld"]
    assert (withheld["name"], withheld["reason"]) == ("force_offset", reason)
    step = verdict["path"][-1]
    assert (step["chosen"], step["refused"], step["why"]) == (None, "force_offset", reason)
    (line,) = (line for line in page("A7", verdict).split("\n") if line.startswith("1. threshold"))
    assert line.endswith(f" - `force_offset` refused: {reason}")
    refused = found.selection.steps[-1].refused.settled
    limited = tuple(replace(p, limits=(p.low, p.high)) for p in OFFSET.parameters)
    model = Model((replace(OFFSET, parameters=limited),))
    assert driven_to_an_end(replace(refused, model=model)) == ""


def test_poissons_ratio_may_be_that_of_an_incompressible_sample_but_no_lower_than_plausible():
    effect = library()["poisson_ratio"]
    problem, _ = pose(laboratory.Lab(seed=3).specimens(), LoopSettings().noise)
    fit = problem.fit_material()
    ratio = effect.parameters[0]
    for end, name in ((ratio.high, ""), (ratio.low, "poisson_ratio.nu")):
        state = fit.state.with_values("poisson_ratio", {"nu": end})
        assert driven_to_an_end(problem.at(Model((effect,)), state)) == name


def test_a_period_at_the_end_of_its_range_is_no_explanation():
    """A hum with a beat of 10 s, and a range that ends there."""
    lab = laboratory.Lab(seed=5).specimens()
    heard = [replace(s, force=s.force + 15e-3 * np.sin(0.2 * np.pi * s.clock)) for s in lab]
    hum = library()["mains_pickup"]
    fit = diagnose(heard, LoopSettings(), [hum]).selection.final
    assert driven_to_an_end(fit) == ""
    *sizes, period = hum.parameters
    period = replace(period, high=fit.state.values["mains_pickup"]["period_s"])
    for inside, name in ((True, "mains_pickup.period_s"), (False, "")):
        effect = replace(hum, parameters=(*sizes, replace(period, inside=inside)))
        assert driven_to_an_end(replace(fit, model=Model((effect,)))) == name


def test_what_was_found_before_stands_beside_what_is_at_the_end_of_its_range():
    lab = laboratory.Lab(seed=5, offset=dict.fromkeys(laboratory.MODES, 6.0), relaxed=0.4)
    narrow = tuple(replace(p, low=-4.0, high=4.0) for p in OFFSET.parameters)
    effects = [replace(OFFSET, parameters=narrow), library()["viscoelastic_relaxation"]]
    found = diagnose(lab.specimens(), LoopSettings(), effects)
    assert (found.verdict, list(found.selection.classes)) == (
        "explained", ["viscoelastic_relaxation"]
    )  # fmt: skip
    (withheld,) = judgement(found, LoopSettings())["withheld"]
    assert withheld["name"] == "force_offset"


def test_a_first_choice_is_exchanged_when_a_second_effect_shows_it_to_be_wrong():
    """A late contact with offsets is a shift of all travels at first, of other sizes."""
    noise = NoiseSettings(
        floor_percent=0.1, fine_percent=0.0, scale_percent=0.2, contact_zero_mm=0.01
    )
    lab = laboratory.Lab(
        seed=6, offset={"tension": 2.0, "compression": -2.0, "shear": 2.0}, gap=0.2
    )
    names = ("displacement_zero", "force_offset", "late_contact")
    found = diagnose(lab.specimens(), LoopSettings(noise), [library()[name] for name in names])
    chosen = [step.chosen.name if step.chosen else None for step in found.selection.steps]
    assert chosen == ["displacement_zero", "force_offset", None, "late_contact", None]
    assert set(found.selection.classes) == {"force_offset", "late_contact"}
    assert found.selection.final.model.names == ("force_offset", "late_contact")
    gap = found.selection.final.state.values["late_contact"]["gap_mm"]
    assert gap == pytest.approx(0.2, rel=0.1)


def test_what_a_laboratory_knows_not_to_be_there_is_no_candidate():
    settings = LoopSettings(absent=("force_offset",))
    found = judged(15.0, settings)
    assert {c.name for s in found.selection.steps for c in s.candidates} <= {"force_drift"}
    verdict = report(found, settings)
    assert verdict["absent"] == ["force_offset"]
    assert "force_offset" not in {*verdict["detection_limits"], *verdict["not_identifiable"]}
    assert "Known not to be there: force_offset." in page("A7", verdict)
    assert "Known not" not in page("A7", verdict_on(15.0))


def test_what_is_named_is_not_called_not_identifiable(monkeypatch):
    found = judged(15.0)
    monkeypatch.setattr(of_verdict, "detection_limits", lambda *model: {})
    verdict = report(found, LoopSettings())
    assert [effect["name"] for effect in verdict["effects"]] == ["force_offset"]
    assert "force_drift" in verdict["not_identifiable"]
    assert "force_offset" not in verdict["not_identifiable"]
    first, last = found.selection.steps
    (offset,) = first.candidates
    fit = replace(offset.fit, state=offset.fit.state.with_values("force_drift", {}))
    asked = replace(offset, name="force_drift", fit=fit, evidence=9.0)
    steps = [first, replace(last, candidates=[asked])]
    selection = replace(found.selection, steps=steps)
    verdict = report(replace(found, selection=selection), LoopSettings())
    assert "force_drift" not in verdict["not_identifiable"]  # these records speak of it


def test_the_choice_of_a_round_is_shown_with_its_own_evidence():
    """Beside what came later it may have more than in its round, where others had more."""
    verdict = verdict_on(15.0)
    (first, *_) = verdict["path"]
    assert first["evidence"] == first["candidates"][0]["evidence"]
    assert (first["refused"], first["why"]) == (None, None)
    others = [{"name": f"other_{k}", "evidence": 90.0 - k} for k in range(6)]
    first |= {"candidates": [*others, *first["candidates"]], "evidence": 1234.4}
    assert "`other_4` 86 - `force_offset` chosen, evidence 1234\n" in page("A7", verdict)
    first |= {"refused": "other_0", "why": "so"}
    assert "- `other_0` refused: so; `force_offset` chosen, evidence 1234\n" in page("A7", verdict)


def test_a_verdict_on_records_far_beyond_the_simulation_says_so_first():
    found = judged(0.0)
    assert report(found, LoopSettings())["extrapolated_mm"] == {}
    further = [replace(s, travel=1.5 * s.travel) for s in found.posed.specimens]
    ends = extrapolated(further)
    assert {*ends} == {s.name for s in further}
    name, of = next(iter(ends.items()))
    assert of["fitted"] == pytest.approx(1e3 * np.abs(further[0].travel).max())
    lines = page("A7", {**report(found, LoopSettings()), "extrapolated_mm": ends}).split("\n")
    assert lines[2].startswith(f"**Not simulated to the end:** {name} to ")
    within = [replace(s, held_out=np.abs(s.travel) > 1e-3 * of["simulated"]) for s in further[:1]]
    assert extrapolated(within) == {}


def test_a_verdict_on_records_that_a_load_cell_cut_off_says_so_first():
    found = judged(0.0)
    assert report(found, LoopSettings())["overloaded_N"] == {}
    cut = [replace(s, force=np.minimum(s.force, 0.5 * s.peak)) for s in found.posed.specimens]
    forces = overloaded(cut)
    assert forces == {s.name: s.axis_sign * s.peak for s in cut}
    lines = page("A7", {**report(found, LoopSettings()), "overloaded_N": forces}).split("\n")
    name, force = next(iter(forces.items()))
    assert lines[2].startswith(f"**Load cell overloaded:** {name} stays at {force:.3g} N, ")
    known = [replace(s, held_out=s.force == s.peak) for s in cut]
    assert overloaded(known) == {}


@pytest.mark.parametrize(
    ("evidence", "threshold", "line"),
    [
        (11.62, 12.0, "1. threshold 12.0: `other` 11.6, `weak` 3 - no effect added"),
        (13.96, 14.04, "1. threshold 14.04: `other` 13.96, `weak` 3 - no effect added"),
        (11.99999, 12.0, "1. threshold 12: `other` just below 12, `weak` 3 - no effect added"),
        (9.4, 12.0, "1. threshold 12: `other` 9, `weak` 3 - no effect added"),
    ],
)
def test_evidence_near_its_threshold_shows_on_which_side_it_is(evidence, threshold, line):
    others = [{"name": "other", "evidence": evidence}, {"name": "weak", "evidence": 3.1}]
    step = {"threshold": threshold, "candidates": others} | dict.fromkeys(
        ("chosen", "evidence", "refused", "why")
    )
    verdict = verdict_on(0.0)
    assert f"\n\n{line}\n\n" in page("A7", {**verdict, "path": [step]})


def test_lines_of_a_paragraph_are_one_line_of_the_page():
    text = "\n\n# A\n\nOne (two\n).\nThree\n, four.\n\n\n\n| a |\n| - |\n\n1. b\nc\n2. d\n\n\n"
    page = "# A\n\nOne (two). Three, four.\n\n| a |\n| - |\n\n1. b c\n2. d\n"
    assert _unwrapped(text) == page


def test_none_says_what_is_left_beyond_the_discrepancy():
    verdict = verdict_on(0.0)
    assert verdict["verdict"] == "none"
    for ratio, saying in (
        (1.0, "No missing effect was detected: noise and model discrepancy explain the residual."),
        (1.27, "No effect is named; what is left is 1.27 times what the discrepancy predicts."),
    ):
        text = page("A7", {**verdict, "birge_ratio": {"after": ratio}}).split("\n")
        assert text[0] == "# Verdict for A7: none (no missing effect detected)"
        assert text[2] == saying


def test_the_page_says_first_what_is_not_predicted():
    """Of what the study leaves out; where little is left anyway, it is predicted all the same."""
    verdict = verdict_on(15.0)
    verdict["folds_before"] = verdict["folds_after"] = {}
    for when, (pull, push, shear) in (("before", (8.0, 50.0, 2.0)), ("after", (2.0, 49.0, 1.9))):
        verdict[f"held_out_{when}"] = {
            f"leave_out_{mode}": {mode: {"rms_percent": error, "rms_N": error}}
            for mode, error in (("tension", pull), ("compression", push), ("shear", shear))
        }
    assert "predicted to" not in page("A7", verdict).split("##")[0]  # the study holds nothing out
    opening = page("A7", {**verdict, "rule": "each mode left out in turn"}).split("##")[0]
    assert "What is held out is predicted to 28.3 % of the peak, 29.3 % without effects." in opening
    assert "**Not predicted:** `leave_out_compression`; what is quoted" in opening
    # parts that are left out have diagnoses of their own, whatever is said of all records
    unknown = {**verdict, "rule": "each mode left out in turn", "verdict": "unknown", "effects": []}
    assert "predicted to 28.3 %" in page("A7", unknown).split("##")[0]
    same = {**unknown, "held_out_after": unknown["held_out_before"], "verdict": "none"}
    alone = "What is held out is predicted to 29.3 % of the peak. **Not predicted:** `leave_out_"
    assert alone in page("A7", same).split("##")[0]
    verdict["held_out_before"]["leave_out_tension"]["tension"]["rms_percent"] = 346.0
    verdict["held_out_after"]["leave_out_tension"]["tension"]["rms_percent"] = 228.0
    opening = page("A7", {**verdict, "rule": "each mode left out in turn"}).split("##")[0]
    assert "**Not predicted:** `leave_out_tension`, `leave_out_compression`" in opening


def test_the_page_says_that_tests_differ_far_more_in_scale_than_is_usual():
    verdict = verdict_on(15.0)
    assert verdict["verdict"] == "explained"
    for scale, told in ((5.9, False), (8.9, True)):
        sizes = {"discrepancy_percent": {"after": {"scale": scale}}}
        opening = page("A7", {**verdict, **sizes}).split("##")[0]
        assert (f"the scale of the tests differs by {scale} %** (usual: 2 %)" in opening) == told


def test_the_page_has_what_folds_leave_out_beside_what_the_study_holds_out():
    verdict = verdict_on(15.0)
    error = {"ramp": {"rms_percent": 46.0, "rms_N": 0.1}}
    found = {"held_out_before": {}, "held_out_after": {}}
    told = "Parts of what is fitted, left out in turn"
    for rule in ("", "strain above 0.2"):
        folds = {f"folds_{when}": {"last_quarter": error} for when in ("before", "after")}
        text = page("A7", {**verdict, **found, **folds, "rule": rule})
        assert (told in text) == bool(rule)
        assert ("| last_quarter | ramp | 100 | 100 | 46 | 46 |" in text) == bool(rule)
    known = " and the stiffness of each specimen, which its own records show:"
    for stiffness in ({}, {"a": 0.9, "b": 1.1}):
        whole = {**verdict, **found, **folds, "rule": rule, "specimen_stiffness": stiffness}
        assert (f"predicted from the rest{known}" in page("A7", whole)) == bool(stiffness)


@pytest.mark.parametrize("there", [True, False])
def test_a_modulus_beside_relaxation_is_said_to_be_instantaneous(there):
    verdict = verdict_on(15.0)
    if there:
        verdict["recommended"]["models"][0]["effects"] += ["viscoelastic_relaxation"]
    assert ("It is the instantaneous modulus" in page("A7", verdict)) == there


@pytest.mark.parametrize(
    ("low", "high", "faster"),
    [(12.0, 19.0, True), (9.0, 19.0, False), (12.0, 12.0, False)],  # the last is known exactly
)
def test_a_relaxation_as_fast_as_records_tell_is_said_to_be_extrapolated(low, high, faster):
    verdict = verdict_on(15.0)
    verdict["recommended"]["models"][0]["effects"] += ["viscoelastic_relaxation"]
    verdict["effects"][0]["parameters"] = {
        "tau1_s": {"value": 12.0, "low": low, "high": high, "unit": "s"}
    }
    assert ("this modulus is extrapolated" in page("A7", verdict)) == faster


@pytest.mark.parametrize(("fraction", "alone"), [(0.0, True), (1.0, True), (0.02, False)])
def test_the_page_says_where_one_term_takes_all_of_the_modulus(fraction, alone):
    verdict = verdict_on(15.0)
    verdict["theta_after"]["mu1_fraction"]["value"] = fraction
    told = "ask for another elastic law than this pair"
    assert (told in page("A7", verdict)) == alone
    verdict["effects"][0]["name"] = "elastic_law"  # which is another law
    assert told not in page("A7", verdict)


def test_values_at_a_bound_are_zero_and_an_error_below_the_noise_says_so():
    verdict = verdict_on(15.0)
    size = {"value": 1e-6, "low": -4.9e-7, "high": 0.01, "unit": "1"}
    verdict["effects"][0]["parameters"] = {"share": size}
    verdict["theta_after"]["mu1_fraction"] |= {"value": 1.07e-7, "low": 0.0, "high": 0.2}
    verdict["correction"] = {
        "class": "zero", "smooth_part": True, "with": [], "parameters": {}, "domain_mm": {},
        "modulus_factors": {},
        "left_out_before_percent": 9.0, "left_out_after_percent": 1e-4,
        "separating_experiment": "more",
    }  # fmt: skip
    assert "goes on smoothly" in page("A7", verdict)
    assert "not cause" not in page("A7", verdict)  # beside effects that explain the residual
    text = page("A7", {**verdict, "verdict": "explained_class"})
    assert "| share | 0 | 0 to 0.01 | 1 |" in text
    assert "| 0 | 0 to 0.2 | 1 |" in text
    left = "is predicted from the rest to less than the noise, and to 9 % without it"
    assert f"{left} (noise taken out). It was" in text
    assert ": a smooth part. " in text
    assert re.search(r"\de-\d", text) is None


def test_the_table_of_verdicts_has_the_median_and_the_worst_of_the_folds():
    verdict = verdict_on(15.0)
    for when, errors in (("before", (2.0, 3.0, 9.0)), ("after", (1.0, 0.5, 50.0))):
        verdict[f"held_out_{when}"] = {
            f"fold_{k}": {"shear": {"rms_percent_structured": error}}
            for k, error in enumerate(errors)
        }
    (row,) = verdict_table({("A7", "real"): verdict}).to_dict("records")
    assert (row["held_out_before_percent"], row["held_out_after_percent"]) == (3.0, 1.0)
    assert row["held_out_worst_before_percent"] == 9.0
    assert row["held_out_worst_after_percent"] == 50.0


def test_what_is_withheld_together_is_told_once_and_with_what_its_error_is():
    size = {"mN": {"value": 2.0, "unit": "mN"}}
    fold = {"last_quarter": {"shear": {"rms_percent": 3.0}, "tension": {"rms_percent": 4.0}}}
    asked = [
        {"name": name, "parameters": size, "reason": reason, "held_out_if_given": would}
        for name, reason, would in (("a", "R", fold), ("b", "R", fold), ("c", "Q", {}))
    ]

    def told(correction=None):
        with_it = {**verdict, "withheld": asked, "correction": correction}
        return [line for line in page("A7", with_it).split("\n") if line.startswith("Not rep")]

    verdict = verdict_on(15.0)
    last = "Not reported: `c` (mN 2 mN), since Q."
    error = "With `a` and `b`, 3.54 % of the peak would be left of what is held out."
    both = f"Not reported: `a` (mN 2 mN) and `b` (mN 2 mN), since R. {error}"
    assert told() == [both, last]
    correction = {
        "class": "zero", "smooth_part": False, "with": ["a"], "parameters": {"a": size},
        "domain_mm": {}, "modulus_factors": {}, "left_out_before_percent": 9.0,
        "left_out_after_percent": 112.0, "separating_experiment": "more",
    }  # fmt: skip
    assert told(correction) == [f"Not reported: `b` (mN 2 mN), since R. {error}", last]
    text = page("A7", {**verdict, "verdict": "explained_class", "correction": correction})
    assert "(class: zero): `a` (mN 2 mN). With it, " in text
    assert "is predicted from the rest to 112 % of the peak, and to 9 % without it" in text


def test_the_page_says_which_effects_of_the_quoted_models_are_not_named():
    verdict = verdict_on(15.0)
    verdict["recommended"]["models"] = [
        {"effects": ["force_offset", name], "mu": 805.4, "weight": 0.5}
        for name in ("channel_lag", "backlash")
    ]
    saying = " may be there, but the evidence does not suffice to name "
    opening = page("A7", verdict).split("##")[0]
    assert f"`backlash` and `channel_lag`{saying}them." in opening
    verdict["effects"][0]["class"] = ["force_offset", "backlash"]
    assert f" `channel_lag`{saying}it." in page("A7", verdict).split("##")[0]
    verdict["correction"] = {
        "class": "drift", "smooth_part": False, "with": ["channel_lag"], "domain_mm": {},
        "parameters": {}, "modulus_factors": {}, "left_out_before_percent": 9.0,
        "left_out_after_percent": 1.0, "separating_experiment": "more",
    }  # fmt: skip
    assert saying not in page("A7", verdict)


def test_the_page_says_which_folds_are_predicted_worse_with_the_effects():
    verdict = verdict_on(15.0)
    saying = "With the effects the prediction of"
    verdict["folds_after"] = verdict["folds_before"]
    assert saying not in page("A7", verdict)
    fold, tests = next(iter(verdict["folds_before"].items()))
    worse = {test: {**error, "rms_N": 2.0 * error["rms_N"]} for test, error in tests.items()}
    verdict["folds_after"] = {**verdict["folds_after"], fold: worse}
    assert f"{saying} `{fold}` is worse: " in page("A7", verdict)
    assert saying not in page("A7", {**verdict, "effects": []})


def test_a_modulus_is_of_one_model_only_if_that_has_all_the_weight():
    verdict = verdict_on(15.0)
    of = {"effects": ["force_offset"], "mu": 805.4}
    for weights, saying in (
        ([1.0], "of the model with `force_offset`."),
        (
            [0.96],
            "averaged over the model with `force_offset` (805 Pa, weight 0.96), others of less "
            "weight.",
        ),
        ([0.04], "averaged over many models."),
    ):
        verdict["recommended"]["models"] = [{**of, "weight": weight} for weight in weights]
        assert f"90 %), {saying}" in page("A7", verdict)
