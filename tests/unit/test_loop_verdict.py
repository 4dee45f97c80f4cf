"""Rests of which an effect takes little, and first choices that a second effect shows wrong."""

import pytest

import laboratory
from softsample.loop.diagnose import LoopSettings, diagnose, judgement
from softsample.loop.effects import library
from softsample.loop.noise import NoiseSettings


def judged(offset, **planted):
    """Verdict on an offset [mN] of all tests and what else is planted; no file has the steps."""
    lab = laboratory.Lab(seed=5, offset=dict.fromkeys(laboratory.MODES, offset), **planted)
    effects = [library()[name] for name in ("force_offset", "force_drift")]
    return diagnose(lab.specimens(), LoopSettings(), effects)


@pytest.mark.parametrize("steps", [0.5, 1.0])
def test_a_small_share_is_enough_where_the_rest_would_not_be_called_unknown(steps):
    found = judged(1.5, steps=steps)
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
    found = judged(60.0, steps=5.0, drift=0.03)
    assert found.verdict == "unknown"
    assert found.selection.final.model.names == ("force_offset",)  # it was tried
    verdict = judgement(found, LoopSettings())
    assert verdict["effects"] == []
    for what in ("theta", "error", "held_out"):
        assert verdict[f"{what}_after"] == verdict[f"{what}_before"]
    assert verdict["path"][0]["chosen"] == "force_offset"


@pytest.mark.parametrize(("drift", "verdict"), [(0.0, "explained"), (0.03, "unknown")])
def test_a_rest_that_asks_for_more_than_an_effect_can_give_is_unknown(drift, verdict):
    found = judged(60.0, steps=5.0, drift=drift)
    selection, rules = found.selection, LoopSettings().selection
    n = len(selection.final.white)
    assert list(selection.classes) == ["force_offset"]
    assert selection.final.cost > rules.unserved_ratio * n
    left, before = selection.final.cost - n, selection.base.cost - n
    assert left < rules.unknown_share * before  # so it is not the share that is left
    assert selection.unserved == (verdict == "unknown")
    assert found.verdict == verdict


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
