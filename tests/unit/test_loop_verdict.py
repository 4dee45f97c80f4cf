"""Rests of which an effect takes little, and first choices that a second effect shows wrong."""

from dataclasses import replace

import pytest

import laboratory
from softsample.loop.accept import driven_to_an_end, fold_ratio
from softsample.loop.diagnose import LoopSettings, diagnose, error_report, judgement
from softsample.loop.effects import library
from softsample.loop.model import Model
from softsample.loop.noise import NoiseSettings
from softsample.loop.select import SelectionSettings

OFFSET = library()["force_offset"]


def judged(offset, settings=None, **planted):
    """Verdict on an offset [mN] of all tests and what else is planted; no file has the steps."""
    lab = laboratory.Lab(seed=5, offset=dict.fromkeys(laboratory.MODES, offset), **planted)
    effects = [library()[name] for name in ("force_offset", "force_drift")]
    return diagnose(lab.specimens(), settings or LoopSettings(), effects)


@pytest.mark.parametrize("steps", [0.5, 1.0])
def test_a_small_share_is_enough_where_the_rest_would_not_be_called_unknown(steps):
    found = judged(1.75, steps=steps)
    first = found.selection.steps[0]
    (offset,) = (c for c in first.candidates if c.name == "force_offset")
    base = found.selection.base
    beyond = base.cost - len(base.white)
    assert offset.gain < beyond / 3.0
    assert offset.evidence > first.threshold
    small = base.cost < LoopSettings().selection.unknown_ratio * len(base.white)
    assert small == (steps == 0.5)
    assert found.verdict == ("explained" if small else "unknown")
    assert list(found.selection.classes) == (["force_offset"] if small else [])


def test_what_is_unknown_has_no_effects_and_the_values_of_the_plain_model():
    found = judged(45.0, steps=5.0, drift=0.1)
    assert found.verdict == "unknown"
    assert found.selection.final.model.names == ("force_offset",)  # it was tried
    verdict = judgement(found, LoopSettings())
    assert verdict["effects"] == []
    for what in ("theta", "error", "folds", "held_out"):
        assert verdict[f"{what}_after"] == verdict[f"{what}_before"]
    assert verdict["path"][0]["chosen"] == "force_offset"


@pytest.mark.parametrize(("drift", "verdict"), [(0.0, "explained"), (0.1, "unknown")])
def test_a_rest_that_asks_for_more_than_an_effect_can_give_is_unknown(drift, verdict):
    found = judged(45.0, steps=5.0, drift=drift)
    selection, rules = found.selection, LoopSettings().selection
    n = len(selection.final.white)
    assert list(selection.classes) == ["force_offset"]
    assert selection.final.cost > rules.unserved_ratio * n
    left, before = selection.final.cost - n, selection.base.cost - n
    assert left < rules.unknown_share * before  # so it is not the share that is left
    assert selection.unserved == (verdict == "unknown")
    assert found.verdict == verdict


def test_an_effect_that_does_not_help_to_predict_what_is_left_out_is_withheld():
    """An offset of 1.5 mN is in the records, but other errors of the folds are as large."""
    strict = LoopSettings(selection=SelectionSettings(fold_ratio=1.0))
    found = judged(1.5, strict, steps=0.5)
    before, after = found.before.folds, found.selected.folds
    assert fold_ratio(before, after) == pytest.approx(1.03, abs=0.02)
    assert found.objection.startswith("cross-validated errors are 1.0")
    verdict = judgement(found, strict)
    assert (verdict["verdict"], verdict["effects"]) == ("unknown", [])
    (withheld,) = verdict["withheld"]
    assert (withheld["name"], withheld["reason"]) == ("force_offset", found.objection)
    assert withheld["held_out_if_given"] == error_report(after)
    kept = judged(1.5, LoopSettings(), steps=0.5)  # a tenth is within what folds can tell
    assert (kept.verdict, judgement(kept, LoopSettings())["withheld"]) == ("explained", [])


def test_a_size_at_the_end_of_its_range_is_no_explanation():
    """An offset of 60 mN is more than the 50 mN that are plausible; a share may be all of it."""
    found = judged(60.0, steps=5.0)
    assert found.objection == "force_offset.tension_mN lies at the end of its range"
    physical = tuple(replace(p, physical=True) for p in OFFSET.parameters)
    assert driven_to_an_end(found.selection.final)
    model = Model((replace(OFFSET, parameters=physical),))
    assert driven_to_an_end(replace(found.selection.final, model=model)) == ""


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
