"""Parts of the blind laboratory one by one: faults, records, plan, seal, score."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import blind_page
from softsample.blindlab import records
from softsample.blindlab.bodies import MODES, Body
from softsample.blindlab.curves import SLIP_BACK, planted_curves
from softsample.blindlab.faults import EFFECTS, KINDS, Fault, Trial
from softsample.blindlab.plan import GROUPS, Benches, Experiment, Extent, plan
from softsample.blindlab.score import Case, confusion, median, opened, score, share
from softsample.errors import InputError
from softsample.fem.explicit import SolverSettings
from softsample.io import read_json, write_json

ROOT = Path(__file__).resolve().parents[2]
BODY = Body(1, False, 23.0, 20.0, 13.0, 0.7, 0.3)
CHANGED = {
    "tilt",
    "shape",
    "strip",
    "slip",
    SLIP_BACK,
    "poisson",
    "larger",
    "third_term",
    "fibres",
    "pressed",
}
MU = 1000.0
NO_FLOOR = records.Floor(0.0)


def straight_curves():
    """Force over modulus is 30 mm2 a millimetre, a tenth less if changed, less on return."""
    travel = np.linspace(0.0, 8.0, 33)
    slope = {"plain": 30.0, SLIP_BACK: 24.0}
    return pd.concat(
        pd.DataFrame(
            {
                "curve": curve,
                "size": 1.0,
                "mode": mode,
                "displacement_mm": travel,
                "area_mm2": slope.get(curve, 27.0) * travel,
            }
        )
        for curve in ("plain", *CHANGED, "inclusion")
        for mode in MODES
    )


def made(name, size=1.0, mode="compression"):
    """Trial, its travel [mm] and its force [N] with one fault, without noise."""
    fault = KINDS[name].make(np.random.default_rng(3), BODY, size)
    curves = straight_curves()
    elastic = {m: records._curve(BODY, curves, [fault], m, 1.0) for m in MODES}
    loop = records._loop(curves, 1.0)
    test = records._test(BODY, mode, MU, elastic, loop, "B", records.SPEED)
    return fault, test, records._force(test, [fault])


def plain(test):
    return 1e-6 * MU * 30.0 * test.travel


@pytest.mark.parametrize("name", EFFECTS)
def test_every_effect_changes_a_record_more_the_larger_it_is(name):
    def change(size):
        return sum(
            float(np.abs(force / plain(test).max() - plain(test) / plain(test).max()).max())
            for mode in MODES
            for _, test, force in [made(name, size, mode)]
        )

    assert change(1.0) > 2e-3
    if name not in ("real_geometry",) and EFFECTS[name].form[:7] != "own run":
        assert change(0.5) < 0.8 * change(1.0)


def test_the_effects_are_those_of_the_design_that_one_speed_can_identify():
    assert len(EFFECTS) == 25
    assert {name for names in GROUPS.values() for name in names} == set(EFFECTS) - {"real_geometry"}


def test_relaxation_keeps_the_rest_of_a_step():
    """A step of force decays to 1 - g after the longest time, along its spectrum."""
    fault, test, _ = made("viscoelastic_relaxation")
    time = np.linspace(0.0, 4000.0, 4001)
    force = fault.tissue(replace(test, time=time), np.ones(4001))
    assert force[0] == pytest.approx(1.0)
    assert force[-1] == pytest.approx(1.0 - fault.sizes["g"], abs=2e-3)
    at_median = np.interp(fault.sizes["tau_s"], time, force)
    assert 1.0 - at_median == pytest.approx(fault.sizes["g"] * 0.6, rel=0.1)
    assert np.all(np.diff(force) <= 1e-12)


def test_a_size_that_was_not_simulated_is_no_record_without_effect():
    tilt = EFFECTS["platen_tilt"].make(np.random.default_rng(1), BODY, 0.3)
    with pytest.raises(ValueError, match=r"no curve at 0.3 times the nominal size: \['tilt'\]"):
        records.make_records(
            BODY, straight_curves(), [tilt], MU, "B", NO_FLOOR, 0.3, np.random.default_rng(1)
        )


def test_drainage_spares_shear():
    _, test, force = made("poroelastic_drainage", mode="shear")
    np.testing.assert_allclose(force, plain(test), atol=1e-12)


def test_compliance_solves_the_spring_in_series():
    fault, test, force = made("machine_compliance")
    reached = test.travel - fault.sizes["mm_per_N"] * force
    np.testing.assert_allclose(force, 1e-6 * MU * 30.0 * reached, atol=1e-6)


def test_backlash_is_a_constant_shift_of_the_way_back():
    fault, test, force = made("backlash")
    behind = (force - plain(test)) / (1e-6 * MU * 30.0)
    before = test.time < 30.0
    assert np.abs(behind[before]).max() < 1e-9
    assert behind[-2000] == pytest.approx(fault.sizes["play_mm"], rel=1e-6)


def test_offset_drift_and_weight_have_the_signs_of_the_machine():
    for name, key in (("force_offset", "compression_mN"), ("self_weight", "weight_mN")):
        fault, test, force = made(name)
        assert 1e3 * (plain(test) - force)[400] == pytest.approx(fault.sizes[key], rel=1e-6)
    fault, test, force = made("force_drift", mode="tension")
    slope = 1e3 * np.polyfit(test.time, force - plain(test), 1)[0]
    assert slope == pytest.approx(fault.sizes["mN_per_s"], rel=0.1)


def test_a_scale_is_a_scale():
    for name in ("gain", "rate_stiffening"):
        _, test, force = made(name)
        ratio = force[2000:8000] / plain(test)[2000:8000]
        assert np.ptp(ratio) < 1e-12
        assert ratio[0] > 1.005


def test_records_have_the_noise_and_the_floor_that_they_say():
    curves = straight_curves()
    noise, floor = [], []
    for seed in range(12):
        for percent in (0.0, 2.0):
            random = np.random.default_rng(seed)
            made_of = (BODY, curves, [], MU, "B", records.Floor(percent), 1.0, random)
            tension = records.make_records(*made_of)[0].table
            left = tension["force_N"] - 1e-6 * MU * 30.0 * tension["displacement_mm"].clip(0.0)
            (floor if percent else noise).append(left.to_numpy())
    assert np.std(np.diff([n[:200] for n in noise])) == pytest.approx(np.sqrt(2) * 1e-3, rel=0.05)
    peak = 1e-6 * MU * 30.0 * BODY.stroke("tension")
    held = [f[4000] for f in floor]
    assert 0.01 * peak < np.std(held) < 0.032 * peak


@pytest.mark.parametrize("family", records.FAMILIES)
def test_floors_of_every_family_have_the_size_that_they_say(family):
    """And differ in how smooth they are."""
    random, x = np.random.default_rng(3), np.linspace(0.0, 1.0, 401)
    draws = np.array([records.FAMILIES[family](random)(x) for _ in range(400)])
    assert np.sqrt(np.mean(draws**2)) == pytest.approx(1.0, rel=0.1)
    steps = np.sqrt(np.mean(np.diff(draws) ** 2))
    assert (steps > 0.05) == (family == "exponential")


def test_a_floor_of_misfits_is_one_of_them_either_way_up():
    misfits = pd.DataFrame({"study": ["s", "s"], "0": [0.0, 1.0], "0.5": [1.2, 1.0], "1": -1.0})
    draw, random, x = records.of_misfits(misfits), np.random.default_rng(4), [0.0, 0.5, 1.0]
    drawn = {tuple(np.round(draw(random)(np.array(x)), 9)) for _ in range(60)}
    one, other = (0.0, 1.2, -1.0), (1.0, 1.0, -1.0)
    assert drawn == {one, other, tuple(-v for v in one), tuple(-v for v in other)}


def test_a_scale_of_each_mode_is_one_of_all_of_its_record():
    floor, random = records.Floor(0.0, scale_percent=5.0), np.random.default_rng(2)
    made_of = (BODY, straight_curves(), [], MU, "C", floor, 1.0, random)
    scales = [
        np.abs(r.table["force_N"]).max() / (1e-6 * MU * 30.0 * BODY.stroke(r.mode))
        for r in records.make_records(*made_of)
    ]
    np.testing.assert_allclose(scales[::2], scales[1::2], rtol=0.01)
    assert 0.01 < np.std(np.log(scales)) < 0.15


def test_designs_are_what_they_say():
    curves = straight_curves()

    def lengths(design):
        random = np.random.default_rng(1)
        made_of = (BODY, curves, [], MU, design, NO_FLOOR, 1.0, random)
        return [(r.mode, r.table["time_s"].max()) for r in records.make_records(*made_of)]

    way = {mode: BODY.stroke(mode) / records.SPEED for mode in MODES}
    assert lengths("A") == [(m, pytest.approx(way[m], abs=0.02)) for m in MODES]
    assert lengths("B") == [(m, pytest.approx(62.0 + 2.0 * way[m], abs=0.02)) for m in MODES]
    assert [mode for mode, _ in lengths("C")] == [m for m in MODES for _ in range(2)]


def test_swapped_labels_are_swapped():
    curves = straight_curves()
    fault = KINDS["mixed_labels"].make(np.random.default_rng(1), BODY, 1.0)
    random = np.random.default_rng(1)
    made_of = (BODY, curves, [fault], MU, "B", NO_FLOOR, 1.0, random)
    assert [r.mode for r in records.make_records(*made_of)] == ["shear", "compression", "tension"]


def test_an_experiment_is_the_same_whenever_it_is_made_and_says_nothing_of_its_fault():
    experiment = Experiment("effect", ("force_offset",), "B", 1.0, 0.0, 5)
    one, again = (experiment.records(BODY, straight_curves(), NO_FLOOR) for _ in range(2))
    for a, b in zip(one, again, strict=True):
        pd.testing.assert_frame_equal(a.table, b.table)
        assert set(vars(a)) == {"mode", "table"}
        assert list(a.table) == ["time_s", "displacement_mm", "force_N"]
    planted = experiment.planted(BODY)
    assert planted["names"] == ["force_offset"]
    assert abs(planted["sizes"]["force_offset"]["shear_mN"]) == pytest.approx(5.0, rel=0.1)


def test_the_plan_holds_what_the_extent_asks_for():
    extent = Extent(seeds=2, nulls=3, pairs=4, first_seed=9)
    kinds = pd.Series([e.kind for e in plan(extent)]).value_counts()
    assert kinds.to_dict() == {"effect": 100, "scale": 8, "stranger": 24, "null": 6, "pair": 8}
    group = {name: title for title, names in GROUPS.items() for name in names}
    for experiment in plan(extent):
        if experiment.kind == "pair":
            one, other = experiment.names
            assert group[one] != group[other]
    assert plan(extent) == plan(extent)
    bodies = {e.body(Benches(cuboids=2, shapes=1)).name for e in plan(extent)}
    assert bodies == {"cuboid_700", "cuboid_701", "shape_700"}


def test_a_broken_seal_is_refused():
    assert opened({"experiments": [1]}, {"sha256": "ab"}, "ab") == [1]
    with pytest.raises(InputError, match="delete seal and answers"):
        opened({"experiments": [1]}, {"sha256": "ab"}, "cd")


def case(names, verdict, classes=(), kind="effect", size=1.0, **more):
    planted = {
        "kind": kind, "names": names, "design": "B", "floor_percent": 0.0, "size": size,
        "mu_pa": 1000.0, "sizes": {"force_drift": {"mN_per_s": 0.1}},
    }  # fmt: skip
    fitted = {"mN_per_s": {"value": 0.11, "low": 0.09, "high": 0.13}}
    mu = {"value": 1010.0, "low": 1000.0, "high": 1020.0}
    answer = {
        "verdict": verdict,
        "effects": [{"name": c[0], "class": c, "parameters": fitted} for c in classes],
        "theta_before": {"mu": {**mu, "value": 1100.0}},
        "theta_after": {"mu": mu},
        "recommended": mu,
        "held_out_percent": {
            "after_ramp": {"before": 2.0, "after": 0.5},
            "leave_out_shear": {"before": 0.01, "after": 0.05},
        },
        "reduced_chi_square": {"after": 1.21},
        "confidence": 0.8,
        "cpu_s": 1.0,
        **more,
    }
    return Case(planted, answer)


def test_the_score_counts_what_it_says():
    drift = "force_drift"
    cases = [
        case([drift], "explained", [[drift]]),
        case([drift], "explained", [["dehydration", drift]]),
        case([drift], "explained", [["gain"]]),
        case([drift], "unknown", recommended={"low": 1001.0, "high": 1020.0}),
        case([], "none", kind="null"),
        case([], "unknown", kind="null"),
        case(["x"], "none", kind="stranger"),
        case(["force_offset", drift], "explained", [[drift], ["gain"]], kind="pair"),
    ]
    rows = {row["goal"]: row for row in score(cases)}
    value = {goal: row["value"] for goal, row in rows.items()}
    assert value["1 false alarms"] == 0.5
    assert value["2 power force_drift"] == 1.0
    assert value["2 effects with power"] == 1
    assert value["3 class correct when noticed"] == 0.5
    assert value["4 exact effect first"] == 0.25
    assert value["5 confidently wrong"] == 0.25
    assert value["6 out of library: unknown or none"] == 1.0
    assert value["7 called unknown"] == 0.25
    assert value["8 pairs: both classes"] == 0.0
    assert value["8 pairs: at least one"] == 1.0
    assert value["8 pairs: wrong extra"] == 1.0
    assert value["9 held-out error removed"] == pytest.approx(0.75)
    assert value["9 of after_ramp"] == pytest.approx(0.75)
    assert rows["9 of leave_out"]["n"] == 0
    assert rows["8 pairs of effects with power: both classes"]["n"] == 0
    assert value["16 stated confidence less hits"] == pytest.approx(0.05)  # three of four hit
    assert value["11 white RMS after"] == pytest.approx(1.1)
    assert value["12 bias of mu removed"] == pytest.approx(0.9)
    assert value["13 cover of mu"] == value["13 cover of effects"] == 1.0
    assert value["13 cover of recommended mu"] == 0.75  # what was not recognised counts too
    assert value["14 error of the size"] == pytest.approx(0.1)
    assert rows["1 false alarms"]["n"] == 2
    table = confusion(cases).set_index("planted")
    assert table.loc[drift, drift] == 0.5
    assert table.loc["nothing", "none"] == 0.5


def test_every_answer_has_a_column_of_the_confusion():
    answers = [
        case(["force_drift"], "explained", [["compressible_foam"]]),
        case(["force_drift"], "explained_class"),
        case([], "explained_class"),
    ]
    table = confusion(answers).set_index("planted").drop(columns=["design", "floor_percent"])
    assert table.loc["force_drift", ["compressible_foam", "explained_class"]].tolist() == [0.5, 0.5]
    assert table.sum(axis=1).tolist() == [1.0, 1.0]


def test_the_error_of_a_size_is_counted_from_where_it_is_nothing():
    """A Poisson's ratio that did not move has missed all of a planted 0.48, not 2 % of it."""
    planted = {
        "names": ["poisson_ratio"], "sizes": {"poisson_ratio": {"nu": 0.48, "tau_s": 5.0}},
        "kind": "effect", "design": "B", "floor_percent": 0.0, "size": 1.0, "mu_pa": 1000.0,
    }  # fmt: skip
    answered = case(["poisson_ratio"], "explained", [["poisson_ratio"]])
    for nu, error in ((0.49, 1.0), (0.485, 0.5), (0.48, 0.0)):
        found = {name: {"value": value, "low": 0.0, "high": 9.0}
                 for name, value in (("nu", nu), ("tau_s", 9.0))}  # fmt: skip
        effect = {**answered.answer["effects"][0], "parameters": found}
        rows = score([Case(planted, {**answered.answer, "effects": [effect]})])
        (value,) = (row["value"] for row in rows if row["goal"] == "14 error of the size")
        assert value == pytest.approx(error, abs=1e-9)


def test_a_goal_that_no_experiment_speaks_of_is_null_in_the_file(tmp_path):
    write_json(tmp_path / "score.json", {"score": score([case([], "none", kind="null")])})
    rows = {row["goal"]: row for row in read_json(tmp_path / "score.json")["score"]}
    assert rows["1 false alarms"]["value"] == 0.0
    assert rows["8 pairs: both classes"] == {
        "goal": "8 pairs: both classes", "value": None, "bound": None, "n": 0,
        "design": "B", "floor_percent": 0.0, "size": None,
    }  # fmt: skip


def test_bounds_are_those_of_the_binomial_distribution():
    assert share("x", [True] * 59, "lower")["bound"] == pytest.approx(0.95, abs=1e-3)
    assert share("x", [True] * 12 + [False] * 388, "upper")["bound"] < 0.05
    assert share("x", [True] * 13 + [False] * 387, "upper")["bound"] > 0.05
    random = np.random.default_rng(4)
    below = [median("x", random.normal(size=41), "lower")["bound"] <= 0.0 for _ in range(2000)]
    assert 0.94 <= np.mean(below) < 0.99


def test_the_page_is_the_laboratory():
    page = (ROOT / "docs/blindlab.md").read_text(encoding="utf-8")
    assert page == blind_page.page(), "stale: run python benchmarks/blind_page.py"
    for name in KINDS:
        assert f"`{name}`" in page
    covered = [
        round(100.0 * row["value"])
        for row in read_json(ROOT / "docs/data/blind/score.json")["score"]
        if row["goal"] == "13 cover of effects"
    ]
    words = " ".join(page.split())
    assert "in {} % of the cases, with a floor in {} %.**".format(*covered) in words


def test_the_page_of_all_sizes_has_every_setting():
    cases = [
        case([name], "explained", [[name]], size=size)
        for name in blind_page.EFFECTS
        for size in (0.5, 1.0)
    ]
    found = {"score": score(cases), "experiments": {"planned": 60, "judged": len(cases)}}
    lines = "\n".join(blind_page._full(found))
    assert "50 of 60" in " ".join(lines.split())
    assert "| B | 0 | 100, 100 | 100, 100 | 0, 0 | – | – | – |" in lines


def test_a_sample_that_slips_gives_back_less():
    _, test, force = made("platen_slip")
    inside = test.travel > 0.1
    slope = force[inside] / (1e-6 * MU * test.travel[inside])
    returning = test.comes_back[inside]
    np.testing.assert_allclose(slope[~returning], 27.0, rtol=1e-9)
    np.testing.assert_allclose(slope[returning], 24.0, rtol=1e-9)
    assert 0.05 < returning.mean() < 0.5
    *_, tilted = made("platen_tilt")  # without a curve of its own, the way back is the way there
    np.testing.assert_allclose(tilted[inside], 27e-6 * MU * test.travel[inside], rtol=1e-9)


def test_friction_takes_work_from_the_laboratory_s_own_cycle():
    curves = planted_curves(BODY, [1.0], 3.0, SolverSettings(loading_time_s=0.2))
    slip = curves[curves["mode"] == "compression"].set_index("curve")
    there, back = (slip.loc[name, "area_mm2"].to_numpy() for name in ("slip", SLIP_BACK))
    travel = slip.loc["slip", "displacement_mm"].to_numpy()
    within = travel <= BODY.stroke("compression")
    lost = np.trapezoid((there - back)[within], travel[within])
    assert 0.0 < lost < 0.2 * np.trapezoid(there[within], travel[within])
    turn = np.interp(BODY.stroke("compression"), travel, there - back)
    assert abs(turn) < 0.01 * there.max()


def test_a_pressed_sample_is_sheared_from_there():
    """Small pressure changes little, in proportion; none of it is in the axial tests' curves."""
    curves = planted_curves(BODY, [0.5, 1.0], 3.0, SolverSettings(loading_time_s=0.2))
    assert set(curves[curves["curve"] == "pressed"]["mode"]) == {"shear"}
    shear = curves[curves["mode"] == "shear"].set_index(["curve", "size"])
    plain = shear.loc[("plain", 0.0), "area_mm2"].to_numpy()
    less, more = (shear.loc[("pressed", s), "area_mm2"].to_numpy() - plain for s in (0.5, 1.0))
    late = plain > 0.3 * plain.max()
    assert np.all(np.abs(more[late]) < 0.2 * plain[late])
    assert np.linalg.norm(more[late]) == pytest.approx(2.0 * np.linalg.norm(less[late]), rel=0.3)


def test_compression_only_pushes():
    curve = {"compression": lambda u: 30.0 * u}
    test = Trial("compression", np.arange(3.0), np.arange(3.0), 2.0, 13.0, MU, curve)
    assert test.elastic(np.array([-1.0, 0.0, 1.0])).tolist() == [0.0, 0.0, pytest.approx(0.03)]
    nothing = Fault("nothing")
    assert nothing.travel(test, test.travel) is test.travel
