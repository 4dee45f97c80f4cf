"""Sizes that would have been seen, against an exact result and records with what they name."""

import numpy as np
import pytest

import laboratory
from softsample.loop.diagnose import LoopSettings, diagnose, report
from softsample.loop.effects import library

SETTINGS = LoopSettings()


def of(names, lab):
    effects = [library()[name] for name in names]
    return diagnose(lab.specimens(), SETTINGS, effects)


@pytest.fixture(scope="module")
def nothing():
    return of(("force_offset", "force_drift", "late_contact", "gain"), laboratory.Lab(seed=6))


@pytest.fixture(scope="module")
def limits(nothing):
    return report(nothing, SETTINGS)["detection_limits"]


def test_a_late_contact_is_not_seen_while_its_prior_pays(nothing, limits):
    """The plain model follows it exactly at the price of its contact zero, squared, or better."""
    need = nothing.selection.steps[0].threshold + np.log(len(nothing.selection.base.white))
    bound = SETTINGS.noise.contact_zero_mm * np.sqrt(need)
    assert limits["late_contact"]["unit"] == "mm"
    assert bound <= limits["late_contact"]["value"] < 1.5 * bound


@pytest.mark.parametrize(("part", "seen"), [(0.5, False), (1.5, True)])
@pytest.mark.parametrize("name", ["force_offset", "force_drift", "late_contact"])
def test_what_is_beyond_its_limit_is_seen_and_what_is_below_is_not(name, part, seen, limits):
    size = part * limits[name]["value"]
    planted = {
        "force_offset": {"offset": dict.fromkeys(laboratory.MODES, size)},
        "force_drift": {"drift": size},
        "late_contact": {"gap": size},
    }[name]
    found = of([name], laboratory.Lab(seed=7, **planted))
    assert list(found.selection.classes) == ([name] if seen else [])
