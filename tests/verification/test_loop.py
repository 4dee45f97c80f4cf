"""The loop on records of a made-up laboratory whose effects have formulas of their own."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import laboratory
from laboratory import PLANTED, Lab
from softsample.loop import effects
from softsample.loop.diagnose import diagnose
from softsample.loop.errors import cross_validated, log_densities
from softsample.loop.noise import NoiseSettings
from softsample.loop.posed import LoopSettings
from softsample.loop.rounds import SelectionSettings
from softsample.loop.verdict import report

SETTINGS = LoopSettings()
EXACT = LoopSettings(
    NoiseSettings(
        floor_percent=0.1,
        fine_percent=0.0,
        history_percent=0.03,
        scale_percent=0.2,
        contact_zero_mm=0.01,
    )
)
"""For a model without error of its own, as the laboratory's curves are."""

HIDDEN = {
    # gap / 0.06 mm squared bounds the evidence: the prior of the contact zero takes up to 0.26 mm
    "late_contact": replace(PLANTED["late_contact"], gap=0.2),
    # modulus, modulus fraction, smooth error and the 2 % scale of each test take it
    "machine_compliance": replace(PLANTED["machine_compliance"], compliance=0.06),
}
"""Effects that the configured floor hides at this size."""

SHOWN = {
    name: lab
    for name, lab in PLANTED.items()
    if name not in {"late_contact", "mullins_softening"}  # have tests of their own
}


ON_UNLOADING = [["mullins_softening", "unloading_loss"]]
"""Which of the two it is, only a second loading can tell."""

TWO = ("viscoelastic_relaxation", "force_drift", "backlash", "channel_lag")
"""Effects that act alike in all tests, of which two are enough."""


@cache
def diagnosed(name):
    modes = ("compression", "shear") if name in TWO else laboratory.MODES
    return diagnose(SHOWN[name].specimens(modes), SETTINGS)


def classes(found):
    return list(found.selection.classes.values())


def overall(errors):
    """Structured error over all folds or phases and modes [N]."""
    squares = [error.structured**2 for modes in errors.values() for error in modes.values()]
    return float(np.sqrt(np.mean(squares)))


def modulus(fit):
    return fit.state.material.mu


@pytest.mark.parametrize("seed", [0, 1])
def test_nothing_is_found_where_nothing_is(seed):
    found = diagnose(Lab(seed=seed).specimens(), SETTINGS)
    assert found.verdict == "none"
    assert classes(found) == []
    assert modulus(found.selection.final) == pytest.approx(laboratory.MU, rel=0.03)


@pytest.mark.parametrize("name", SHOWN)
def test_a_planted_effect_is_in_the_first_class(name):
    found = diagnosed(name)
    assert found.selection.steps[0].chosen is not None
    assert name in found.selection.steps[0].members
    assert any(name in members for members in classes(found))


@pytest.mark.parametrize("name", SHOWN)
def test_nothing_else_is_named_and_the_modulus_comes_back(name):
    found = diagnosed(name)
    assert found.verdict == "explained"
    assert len(classes(found)) == 1
    final = found.selection.final
    assert modulus(final) == pytest.approx(laboratory.MU, rel=0.05)
    assert final.cost / len(final.white) < 1.2


@pytest.mark.parametrize("name", SHOWN)
def test_the_error_falls_also_where_it_was_left_out(name):
    """In the raw, and by its likelihood, which knows what the floor lets a fold expect."""
    found = diagnosed(name)
    assert overall(found.after.folds) < overall(found.before.folds)
    fits = found.selection.base, found.selection.final
    before, after = (log_densities(fit, cross_validated(fit)).sum() for fit in fits)
    assert after > before + 10.0
    assert overall(found.after.fitted) < overall(found.before.fitted)


def test_softening_of_another_form_is_named():
    """Ogden and Roxburgh's function of the energy; the library's is linear in the travel."""
    one = LoopSettings(selection=SelectionSettings(most_effects=1))
    found = diagnose(PLANTED["mullins_softening"].specimens(), one)
    assert classes(found) == ON_UNLOADING


def test_softening_of_another_form_draws_in_no_further_effects():
    found = diagnose(PLANTED["mullins_softening"].specimens(), SETTINGS)
    assert overall(found.selected.fitted) < overall(found.before.fitted)
    assert found.verdict == "unknown" or classes(found) == ON_UNLOADING


@pytest.mark.parametrize("name", HIDDEN)
def test_what_hides_in_the_floor_is_not_invented_but_seen_without_floor(name):
    specimens = HIDDEN[name].specimens()
    assert diagnose(specimens, SETTINGS).verdict == "none"
    found = diagnose(specimens, EXACT)
    assert any(name in members for members in classes(found))


def test_a_late_contact_beyond_its_prior_is_named():
    found = diagnose(Lab(gap=0.5).specimens(), SETTINGS)
    assert [members[0] for members in classes(found)] == ["late_contact"]
    assert overall(found.after.folds) < overall(found.before.folds)


def test_sizes_come_back_with_their_signs():
    def size(name, parameter):
        return diagnosed(name).selection.final.state.values[name][parameter]

    assert size("force_offset", "tension_mN") == pytest.approx(7.0, abs=0.5)
    assert size("force_offset", "compression_mN") == pytest.approx(-5.0, abs=0.5)
    assert size("force_drift", "mN_per_s") == pytest.approx(0.1, abs=0.02)
    assert size("channel_lag", "lag_ms") == pytest.approx(120.0, abs=15.0)
    assert size("backlash", "play_mm") == pytest.approx(0.06, abs=0.01)
    assert size("self_weight", "weight_mN") == pytest.approx(-30.0, abs=1.0)
    assert size("displacement_zero", "tension_mm") == pytest.approx(0.15, abs=0.03)


def test_two_effects_at_once_are_both_found():
    lab = replace(PLANTED["viscoelastic_relaxation"], offset=PLANTED["force_offset"].offset)
    found = diagnose(lab.specimens(["compression", "shear"]), SETTINGS)
    assert found.verdict == "explained"
    first, second = classes(found)
    assert "viscoelastic_relaxation" in first
    assert "force_offset" in second
    assert overall(found.after.folds) < overall(found.before.folds)


def test_a_kind_that_no_file_knows_is_not_explained():
    found = diagnose(Lab(steps=8.0).specimens(), SETTINGS)  # stick and slip
    assert found.verdict in {"unknown", "none"}


def test_names_and_order_of_the_tests_do_not_matter():
    lab = SHOWN["force_offset"]
    modes = ("shear", "tension", "compression")
    named = lab.specimens(modes, ["late_contact", "T7_gain", "x"])
    again, before = diagnose(named, SETTINGS), diagnosed("force_offset")
    assert again.verdict == before.verdict
    assert again.selection.classes == before.selection.classes
    for name, of in before.selection.final.state.values.items():
        assert again.selection.final.state.values[name] == pytest.approx(of, rel=0.01)


ABSURD = """
import numpy as np

from softsample.loop.effects.base import Effect, Parameter


def _instrument(specimen, force, travel, values):
    wild = np.random.default_rng(11).normal(size=len(force)).cumsum()
    return force + 1e-4 * values["moons"] * wild


EFFECT = Effect(
    name="moon",
    title="Phase of the moon",
    parameters=(Parameter("moons", "1", -20.0, 20.0, 1.0),),
    source="none",
    signature="random",
    confused_with=("gain",),
    experiment="wait a month",
    instrument=_instrument,
)
"""


def test_a_file_with_an_absurd_effect_joins_the_library_and_is_rejected(tmp_path, monkeypatch):
    (tmp_path / "zz_moon.py").write_text(ABSURD)
    monkeypatch.setattr(effects, "__path__", [*effects.__path__, str(tmp_path)])
    assert "moon" in effects.library()
    nothing = diagnose(Lab(seed=4).specimens(), SETTINGS)
    assert nothing.verdict == "none"
    few = [effects.library()[name] for name in ("moon", "self_weight", "force_offset")]
    found = diagnose(SHOWN["self_weight"].specimens(), SETTINGS, few)
    assert classes(found)[0][0] == "self_weight"
    assert all("moon" not in members for members in classes(found))
    assert "moon" in report(found, SETTINGS)["detection_limits"]
