"""Rests of which an effect takes little: when it is named all the same, when nothing is."""

import pytest

import laboratory
from softsample.loop.diagnose import LoopSettings, diagnose
from softsample.loop.effects import library


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
