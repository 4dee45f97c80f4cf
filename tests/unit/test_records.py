import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import pytest
import yaml

from softsample.errors import InputError
from softsample.io import read_table, read_yaml
from softsample.lone import lone_rows
from softsample.protocol import Course
from softsample.records import Record, RecordSettings, aligned_record
from softsample.shapes import IdealShape

ROOT = Path(__file__).resolve().parents[2]
SCHEMA = read_yaml(ROOT / "workflow/schemas/record.schema.yaml")


def record(sign=-1.0, noise=1e-3, rest=0.5, seed=2):
    """0.5 s of rest and a ramp to 3.9 mm and 1 N; the index is the line in an imagined file."""
    time = np.round(np.arange(0.0, rest + 13.0, 0.01), 2)
    travel = np.clip(time - rest, 0.0, None) * 0.3
    random = np.random.default_rng(seed)
    force = (travel / 3.9) ** 2 + noise * random.normal(size=len(time))
    columns = {"time_s": time, "displacement_mm": sign * travel, "force_N": sign * force}
    return pd.DataFrame(columns, index=np.arange(4, 4 + len(time)))


def check(table, mode="compression"):
    """Facts of a table that is read as it stands."""
    return aligned(table, mode)[1]


def test_facts_of_a_good_record():
    facts = check(record())
    assert facts["sampling_rate_hz"] == pytest.approx(100.0)
    assert facts["travel_mm"] == pytest.approx(-3.9, abs=0.02)
    assert facts["peak_force_N"] == pytest.approx(-1.0, abs=0.01)
    assert facts["force_noise_N"] == pytest.approx(1e-3, rel=0.4)
    assert [phase["kind"] for phase in facts["phases"]] == ["baseline", "ramp"]
    assert facts["warnings"] == []


@pytest.mark.parametrize(
    ("file", "mode", "travel"),
    [("C1", "compression", -3.9), ("T1", "tension", 3.25), ("S1", "shear", 3.9)],
)
def test_shipped_records_are_accepted(file, mode, travel):
    table = read_table(ROOT / f"resources/cohort/records/{file}.csv")
    assert check(table, mode)["travel_mm"] == pytest.approx(travel, abs=0.03)


def put(column, row, value):
    def change(table):
        table[column] = table[column].astype(object)
        table.loc[row, column] = value
        return table

    return change


REFUSED = {
    "unknown column": (
        lambda t: t.assign(force_mN=1e3 * t["force_N"]),
        "column 'force_mN': unknown name; did you mean 'force_N'",
    ),
    "NaN": (
        put("force_N", 100, np.nan),
        "line 100, column 'force_N': empty is not a number",
    ),
    "channels in turn": (
        lambda t: t.assign(force_N=t["force_N"].where(np.arange(len(t)) % 2 == 0)),
        "column 'force_N': empty is not a .*; record all channels at the same times; if the cells "
        "are formulas of a workbook, save it",
    ),
    "line of channel numbers": (
        put("time_s", 4, 1.0),
        "line 5, column 'time_s': 0.01 s follows 1 s, .*; delete line 4 if they are no readings",
    ),
    "infinite": (
        put("force_N", 100, np.inf),
        "line 100, column 'force_N': inf is not a number",
    ),
    "text": (
        put("displacement_mm", 77, "1,5"),
        "line 77, column 'displacement_mm': '1,5' is not a number",
    ),
    "force in uN": (
        lambda t: t.assign(force_N=1e6 * t["force_N"]),
        "column 'force_N': -1[0-9.]+ is less than the minimum of -10000; .*was it written",
    ),
    "displacement in m": (
        lambda t: t.assign(displacement_mm=1e-3 * t["displacement_mm"]),
        "moves 0.0039 mm only; is the column in m instead of mm",
    ),
    "time runs back": (
        put("time_s", 50, 0.0),
        "line 50, column 'time_s': 0 s follows 0.45 s, but .*; let the time go on if it begins",
    ),
    "rounded time": (
        lambda t: t.assign(time_s=t["time_s"].round(1)),
        r"0 s follows 0 s.*; \d{4} times are rounded .* more decimals, or take its column out",
    ),
    "stored backwards": (
        lambda t: t.iloc[::-1],
        "follows 13.49 s, but time must rise from line to line; turn the lines round",
    ),
    "a last line of zeros": (
        lambda t: pd.concat([t, pd.DataFrame([0.0 * t.iloc[0]], index=[t.index[-1] + 1])]),
        "0 s follows 13.49 s, .*; delete lines from 1354 on if they are no readings, else let the",
    ),
    "one time twice": (
        lambda t: t.assign(time_s=t["time_s"].where(t.index != t.index[5], t["time_s"].iloc[4])),
        "0.04 s follows 0.04 s, .*; delete one of these lines if it repeats the other",
    ),
    "force of the wrong sign": (
        lambda t: t.assign(force_N=-t["force_N"]),
        "line 1353, column 'force_N': [0-9.]+ in the loading that ends here, but negative is right "
        "in compression .*tell the machine's sign",
    ),
    "displacement of the wrong sign": (
        lambda t: t.assign(displacement_mm=-t["displacement_mm"]),
        "column 'displacement_mm': 3.8.* in the loading that ends here, but negative is right",
    ),
    "at rest": (
        lambda t: t.assign(displacement_mm=0.0 * t["displacement_mm"]),
        "column 'displacement_mm': .*there is no loading ramp",
    ),
    "few samples": (
        lambda t: t.iloc[:4],
        "column 'time_s': a list of 4 is too short; expected: time \\[s\\], at least 5 rows",
    ),
    "coarse ramp": (
        lambda t: pd.concat([t.iloc[:50], t.iloc[50::500]]),
        "the loading ramp .* has [1-4] samples; record at least 5",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_bad_record_is_refused_with_place_and_cure(name):
    change, message = REFUSED[name]
    with pytest.raises(InputError, match=message):
        check(change(record()))


def test_a_hole_in_the_ramp_is_doubted():
    hole = check(pd.concat([record().iloc[:400], record().iloc[700:]]))
    assert any(
        "line 704: 3.01 s are missing in the loading ramp" in warning
        for warning in hole["warnings"]
    )
    assert not any("missing" in warning for warning in check(record())["warnings"])


def test_signs_depend_on_the_mode():
    assert check(record(sign=1.0), "tension")["peak_force_N"] > 0.0
    with pytest.raises(InputError, match="positive is right in tension"):
        check(record(sign=-1.0), "tension")


def test_a_channel_of_zeros_is_refused_as_such():
    with pytest.raises(InputError, match="column 'force_N': 0 all along; is it the right column"):
        check(record().assign(force_N=0.0))


@pytest.mark.parametrize("row", [10, 700, 1352])
@pytest.mark.parametrize("value", [1.2e4, -1.2e4])
def test_a_single_cell_beyond_its_bounds_is_found(row, value):
    strong = record().assign(force_N=lambda table: 9e3 + 1.8e4 * table["force_N"])
    with pytest.raises(InputError, match=f"r.csv, line {row}, column 'force_N': -?12000.0 is"):
        check(put("force_N", row, value)(strong))


def test_what_is_doubtful_is_a_warning():
    assert "force zero and noise are not known" in check(record(rest=0.0))["warnings"][0]
    clipped = record(noise=0.0)
    clipped["force_N"] = clipped["force_N"].clip(lower=-0.8)
    assert "overloaded" in check(clipped)["warnings"][0]


def test_few_digits_are_no_limit_of_a_cell():
    coarse = record(noise=0.0)
    coarse["force_N"] = (20.0 * coarse["force_N"]).round() / 20.0  # about 65 readings each
    assert check(coarse)["warnings"] == []
    coarse["force_N"] = coarse["force_N"].clip(lower=-0.5)
    assert "the force stays at -0.5 N" in check(coarse)["warnings"][0]


def test_a_reading_that_stands_alone_is_a_warning():
    (warning,) = check(put("force_N", 700, 0.3)(record()))["warnings"]
    assert re.match("line 700: the force is 0.3 N, far from", warning)
    two = put("force_N", 900, -2.0)(put("force_N", 700, 0.3)(record()))
    assert "beside it, and 1 more;" in check(two)["warnings"][0]


@pytest.mark.parametrize(
    ("column", "value", "of_others"),
    [
        ("force_N", 4.61, " N in all others"),
        ("force_N", -0.2, " N in all others"),
        ("displacement_mm", -0.113, "-3.897 to -0.003 mm in all others"),
    ],
)
def test_a_first_row_alone_is_refused_before_all_that_rests_on_it(column, value, of_others):
    turned = record(rest=0.0).assign(force_N=lambda table: -table["force_N"])  # a sign is wrong too
    turned.loc[4, column] = value
    for zero in ({}, {"force": "start"}):
        with pytest.raises(InputError, match=of_others) as refusal:
            aligned(turned, zero=zero)
        place = f"r.csv, line 4, column '{column}': {value:g} "
        assert str(refusal.value).startswith(place)
        assert str(refusal.value).endswith("; delete the line")
        assert "\n" not in str(refusal.value)
    with pytest.raises(InputError, match="positive: {force: loading}"):
        aligned(turned.iloc[1:])


def test_a_row_between_others_that_decides_the_range_is_refused():
    for column, value in (("force_N", -2.5), ("force_N", 1.8), ("displacement_mm", -12.0)):
        spike = put(column, 700, value)(record())
        with pytest.raises(InputError, match=f"r.csv, line 700, column '{column}': .*delete"):
            check(spike)
        assert check(spike.drop(700).astype(float))["warnings"] == []


@pytest.mark.parametrize(("row", "travel"), [(700, -2.05), (700, -1.0), (1353, 0.0)])
def test_a_displacement_that_stands_alone_is_a_warning(row, travel):
    (warning,) = check(put("displacement_mm", row, travel)(record()))["warnings"]
    assert re.match(f"line {row}: the displacement is {travel:g} mm, far from", warning)


@pytest.mark.parametrize("travel", [(0, 2, 2, 2), (0, 0.6, 1.3, 2), (2, 1.3, 0.6, 0)])
def test_a_sudden_step_is_no_row_alone(travel):
    """Ramps of few samples, up or down, on the way to a hold."""
    steps = np.array([*travel, *[travel[-1]] * 20, *(travel[-1] + np.array(travel)), 3.0])
    table = pd.DataFrame({"displacement_mm": steps, "force_N": steps**2})
    table.insert(0, "time_s", 0.5 * np.arange(len(steps)))
    assert lone_rows(table, "r.csv") == ([], [])


@pytest.mark.parametrize(
    ("column", "told"),
    [
        ("displacement_mm", "the displacement jumps from -1.5 to 0 mm, while the force does not"),
        ("force_N", "the force jumps from -0.1.* to .* N, while the displacement does not"),
    ],
)
@pytest.mark.parametrize("timed", [True, False])
def test_a_channel_that_is_zeroed_within_the_record_is_a_warning(column, told, timed):
    table = record(noise=0.0)
    after = table["displacement_mm"] < -1.501
    table.loc[after, column] -= table.loc[after.idxmax(), column]
    faults, doubts = lone_rows(table if timed else table.drop(columns="time_s"), "r.csv")
    assert not faults
    (doubt,) = doubts
    assert re.search(
        f"line {after.idxmax()}: {told}; .* zeroed there, add -[01].* to it from", doubt
    )


def test_lost_readings_are_a_warning():
    table = record(noise=0.0)
    table.loc[700:704, ["displacement_mm", "force_N"]] = 0.0
    _, doubts = lone_rows(table, "r.csv")
    assert len(doubts) == 2
    told = r"line 700: the .* jumps from -\d.* to 0 .*, and back; .* delete the 5 lines"
    assert all(re.match(told, doubt) for doubt in doubts)


def test_a_sudden_step_that_the_force_follows_is_no_zeroed_channel():
    table = record(noise=0.0)
    step = table["time_s"] >= 5.0
    table["displacement_mm"] = np.where(step, -2.0, 0.0)
    table["force_N"] = np.where(step, -0.5 - 0.5 * np.exp(5.0 - table["time_s"]), 0.0)
    assert lone_rows(table, "r.csv")[1] == []


@pytest.mark.parametrize(("column", "name"), [("displacement_mm", "displac"), ("force_N", "force")])
def test_few_different_readings_are_a_warning(column, name):
    table = record()
    coarse = (table[column] / 0.3).round() * 0.3 if name == "displac" else table[column].round(1)
    said = [one for one in check(table.assign(**{column: coarse}))["warnings"] if "readings" in one]
    assert len(said) == 1
    assert re.search(rf"the {name}\w* has 1\d different readings only in \d+ samples", said[0])


def test_noise_does_not_stand_alone():
    noisy = record(noise=0.05)  # the peak is 1 N or so
    assert not [w for w in check(noisy)["warnings"] if "far from" in w]


def test_noise_beside_a_cell_at_its_limit_does_not_stand_alone():
    clipped = record(noise=0.05)
    clipped["force_N"] = clipped["force_N"].clip(lower=-0.15)  # most of the readings
    (warning,) = check(clipped)["warnings"]
    assert "overloaded" in warning
    with pytest.raises(InputError, match="line 300, column 'force_N': 0.9 N in this row stands"):
        check(put("force_N", 300, 0.9)(clipped))


def test_the_corners_of_a_coarse_record_do_not_stand_alone():
    travel = np.concatenate([np.zeros(12), -np.arange(0.0, 3.6, 0.3), -np.arange(3.3, -0.1, -0.3)])
    table = pd.DataFrame({"displacement_mm": travel, "force_N": 0.1 * travel})
    table.insert(0, "time_s", 0.5 * np.arange(len(travel)))
    assert not [w for w in check(table)["warnings"] if "far from" in w]


def test_a_ramp_that_begins_loaded_or_away_from_zero_is_a_warning():
    begun = record()
    begun["displacement_mm"] -= 2.0
    (warning,) = check(begun)["warnings"]
    assert "the ramp begins at -2 mm" in warning
    assert "zero: {displacement: rest}" in warning
    loaded = record()
    loaded["force_N"] -= 0.2
    (warning,) = check(loaded)["warnings"]
    assert "the force before the ramp is -0.2 N" in warning
    assert "zero: {force: rest}" in warning
    small = record()
    small["force_N"] -= 0.02
    assert check(small)["warnings"] == []


@pytest.mark.parametrize(("free", "told"), [(0.0, False), (0.1, False), (0.4, True)])
def test_a_loading_that_begins_without_force_is_a_warning(free, told):
    table = record(noise=0.005)
    way = table["displacement_mm"].min()
    reached = np.minimum(table["displacement_mm"] - free * way, 0.0)
    noise = np.random.default_rng(1).normal(0.0, 0.005, len(table))
    table["force_N"] = reached / way / (1.0 - free) * -1.0 + noise
    found = [w for w in check(table)["warnings"] if "within its noise" in w]
    assert bool(found) == told
    for warning in found:
        over = float(re.search(r"over the first (\S+) mm", warning)[1])
        assert over == pytest.approx(abs(free * way), abs=0.05 * abs(way))
        assert "zero: {displacement: start}" in warning


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("free", "told"), [(0, False), (4, True)])
def test_free_travel_of_a_coarse_record_is_a_warning(free, told):
    """Of twelve samples the first four, a third, touch nothing."""
    travel = np.concatenate([np.zeros(12), 0.3 * np.arange(1.0, 13.0)])
    force = np.maximum(0.0, travel - 0.3 * free) + 1e-4 * np.cos(np.arange(24))
    table = pd.DataFrame({"displacement_mm": travel, "force_N": force})
    table.insert(0, "time_s", 0.5 * np.arange(24))
    warnings = check(table, "tension")["warnings"]
    assert any("stays within its noise over the first" in w for w in warnings) == told


@pytest.mark.parametrize(("mode", "sign"), [("tension", 1.0), ("compression", -1.0)])
def test_a_cell_that_was_not_tared_is_no_wrong_sign(mode, sign):
    table = record(sign=sign, rest=0.0)
    table["force_N"] -= 1.5 * sign
    with pytest.raises(InputError, match="changes as it should .*zero: {force: start}") as refusal:
        aligned(table, mode)
    assert "positive: {force" not in str(refusal.value)
    cured, facts = aligned(table, mode, zero={"force": "start"})
    assert sign * facts["peak_force_N"] == pytest.approx(1.0, abs=0.01)
    assert not cured["calibrated"].eq(0).all()
    table["force_N"] += 3.0 * sign
    (_, warning) = aligned(table, mode)[1]["warnings"]
    assert re.match("the force before the ramp is -?1.5 N; .*zero: {force: start}", warning)


@pytest.mark.parametrize(("first", "told"), [(0.08, True), (0.03, False)])
def test_a_first_reading_off_zero_is_doubted_without_a_rest_too(first, told):
    table = record(rest=0.0)
    table["force_N"] -= first
    saying = "the force before the ramp is -0.08"
    assert any(warning.startswith(saying) for warning in check(table)["warnings"]) == told


def test_a_force_that_falls_all_along_may_have_the_wrong_sign():
    """Compression is positive in the file, from a cell that was not tared."""
    table = record(rest=0.0).assign(force_N=lambda table: -table["force_N"] - 1.5)
    (warning,) = [w for w in check(table)["warnings"] if w.startswith("the force falls from -1.5")]
    cure = yaml.safe_load(warning.split("`")[-2])["records"]
    assert cure == {"positive": {"force": "loading"}}
    positive = {"displacement": "tension", **cure["positive"]}
    with pytest.raises(InputError, match="changes as it should .*zero: {force: start}"):
        aligned(table, positive=positive)
    (facts,) = aligned(table, positive=positive, zero={"force": "start"})[1:]
    assert facts["peak_force_N"] == pytest.approx(-1.0, abs=0.01)
    failed = record(rest=0.0)
    failed["force_N"] = failed["force_N"].where(failed["displacement_mm"] > -2.0, 0.0)
    assert "instead" not in check(failed)["warnings"][1]


def test_a_deformed_sample_may_be_loaded_as_the_record_begins():
    table = record().iloc[400:]
    assert not [w for w in check(table)["warnings"] if "force before" in w]


@pytest.mark.parametrize("seed", range(4))
def test_a_sample_that_fails_in_loading_is_a_warning(seed):
    table = record(rest=0.0, seed=seed)
    left = 1e-3 * np.random.default_rng(seed).normal(size=len(table))
    table["force_N"] = table["force_N"].where(table["displacement_mm"] > -2.0, left)
    (_, warning, jump) = check(table)["warnings"]
    assert "look whether the sample slipped or failed" in jump
    assert re.match("the force falls from -0.2[0-9]* N to .* N along the loading", warning)


@pytest.mark.parametrize("mode", ["tension", "compression", "shear"])
@pytest.mark.parametrize("setting", ["tension", "compression", "loading"])
def test_the_cure_of_a_wrong_sign_turns_it(mode, setting):
    """A file whose displacement is wrong with a setting is right with the one that is advised."""
    reading = {"compressive": []}

    def aligned(table, positive):
        settings = RecordSettings({}, {}, positive, {"displacement": "file", "force": "file"})
        return aligned_record(table, reading, mode, settings, SCHEMA, "r.csv")

    right = -1.0 if mode == "compression" else 1.0
    factor = {"tension": 1.0, "compression": -1.0, "loading": right}[setting]
    table = record(sign=right)
    table["displacement_mm"] *= -factor
    positive = {"displacement": setting, "force": "tension"}
    with pytest.raises(InputError, match="positive: {displacement: ") as refusal:
        aligned(table, positive)
    advised = str(refusal.value).split("{displacement: ")[1].split("}")[0]
    assert aligned(table, {**positive, "displacement": advised})[1]["travel_mm"] * right > 3.0


def test_a_title_that_decides_on_the_sign_is_named():
    as_in_file = {"displacement": "file", "force": "file"}
    tensile = dict.fromkeys(as_in_file, "tension")
    settings = RecordSettings({}, {}, tensile, as_in_file)
    table = record(sign=-1.0)
    with pytest.raises(InputError, match="column 'force_N': .*rename the column, whose title"):
        aligned_record(table, {"compressive": ["force"]}, "compression", settings, SCHEMA, "r.csv")


class Size(NamedTuple):
    """100 mm2 and 10 mm."""

    area: float = 1e-4
    height: float = 10e-3


AS_IN_FILE = {"displacement": "file", "force": "file"}


def aligned(
    table, mode="compression", size=None, which="largest", compressive=(), columns=(), **settings
):
    given = {"positive": dict.fromkeys(AS_IN_FILE, "tension"), "zero": AS_IN_FILE, **settings}
    reading = {"compressive": [*compressive], "columns": dict(columns)}
    read = RecordSettings({}, {}, **given)
    return aligned_record(table, reading, mode, read, SCHEMA, "r.csv", size, which)


@pytest.mark.parametrize("cohort", ["cohort", "undeclared"])
def test_shipped_records_are_marked_as_the_ramp_that_was_calibrated_before(cohort):
    samples = pd.read_csv(ROOT / f"resources/{cohort}/samples.tsv", sep="\t", comment="#")
    for mode, file in zip(samples["mode"], samples["record"], strict=True):
        raw = read_table(ROOT / f"resources/{cohort}" / file)
        table, facts = aligned(raw, mode)
        course = Course.of(raw["time_s"].to_numpy(), 1e-3 * raw["displacement_mm"].to_numpy())
        ramp = course.chosen().ramps[-1]
        assert np.flatnonzero(table["calibrated"]).tolist() == [*range(ramp.start, ramp.stop)]
        assert facts["calibrated_loading"] == table["cycle"].iloc[ramp.start]


def test_a_record_comes_back_from_its_file(tmp_path):
    raw = record().assign(force_normal_N=0.25, torque_Nmm=3.0)
    table, _ = aligned(raw)
    table.to_csv(tmp_path / "r.csv", index=False)
    back = Record.of_table(read_table(tmp_path / "r.csv"))
    assert set(back.phase) == {"baseline", "ramp"}
    assert back.calibrated.dtype == bool
    assert back.calibrated.sum() == np.sum(back.phase == "ramp")
    assert back.cycle.tolist() == [*back.calibrated.astype(int)]
    assert (back.force_normal[0], back.torque[0]) == (0.25, pytest.approx(3e-3))
    assert back.displacement.min() == pytest.approx(-3.9e-3, abs=1e-4)
    pd.testing.assert_frame_equal(back.table, table.reset_index(drop=True), check_dtype=False)
    plain = Record.of_table(raw)
    assert list(plain.table) == [*raw.columns]
    assert len(plain.phase) == 0


def test_without_time_samples_stand_in_their_order():
    timed, facts = aligned(record())
    table, told = aligned(record().drop(columns="time_s"))
    for mark in ("phase", "cycle", "calibrated"):
        assert table[mark].tolist() == timed[mark].tolist()
    for key in ("sampling_rate_hz", "duration_s", "ramp_speed_mm_s"):
        assert told[key] is None
        assert facts[key] is not None
    assert told["timed"] is False
    assert told["phases"][0] == {"kind": "baseline", "start": 0, "end": told["phases"][0]["end"]}
    untimed = Record.of_table(table)
    assert (untimed.timed, untimed.time) == (False, None)
    assert untimed.clock.tolist() == [*range(len(table))]
    assert "time_s" not in untimed.table


@pytest.mark.parametrize("positive", ["loading", "tension"])
def test_a_record_that_is_stored_backwards_is_told(positive):
    """Its signs are right or wrong, but its loading is an unloading."""
    table = record().drop(columns="time_s").iloc[:260]
    loading = table.iloc[: int(table["displacement_mm"].abs().argmax()) + 1]
    backwards = loading.iloc[::-1].reset_index(drop=True)
    if positive == "tension":
        backwards = -backwards
    with pytest.raises(InputError, match="stored from the last to the first, turn them round"):
        aligned(backwards)


def test_a_published_curve_of_few_points_is_enough_without_time():
    """As mean curves of brain in shear: a sweep of 33 points, and a loading of 11."""
    strain = np.linspace(-0.2, 0.2, 33)
    sweep = pd.DataFrame({"displacement_mm": 5.0 * strain, "force_N": strain**3})
    table, facts = aligned(sweep, "shear")
    assert [phase["kind"] for phase in facts["phases"]] == ["unloading", "ramp"]
    assert table["calibrated"].tolist() == [0] * 16 + [1] * 17
    assert facts["ramp_start_mm"] == 0.0
    half = sweep.iloc[16:].iloc[::2].reset_index(drop=True)
    for few in (half, half.assign(time_s=np.arange(9.0))):
        assert aligned(few, "shear")[1]["samples"] == 9


def cycles(*peaks, rest=1.0, step=0.02):
    """Loadings of 2 s to each peak [mm] and back; the force is cubic."""
    corners = np.cumsum([0.0, rest, *[2.0] * (2 * len(peaks))])
    ends = [0.0, 0.0, *(end for peak in peaks for end in (peak, 0.0))]
    time = np.arange(0.0, corners[-1], step)
    travel = np.interp(time, corners, ends)
    return pd.DataFrame({"time_s": time, "displacement_mm": travel, "force_N": travel**3})


@pytest.mark.parametrize(
    ("which", "number", "begins"),
    [("largest", 2, 5.0), ("first", 1, 1.0), ("last", 3, 9.0), ("3", 3, 9.0)],
)
def test_the_loading_that_is_named_is_calibrated(which, number, begins):
    table, facts = aligned(cycles(1.0, 2.0, 2.0), "tension", which=which)
    assert (facts["loadings"], facts["calibrated_loading"]) == (3, number)
    chosen = table[table["calibrated"] == 1]
    assert chosen["time_s"].iloc[0] == pytest.approx(begins, abs=0.06)
    assert set(chosen["cycle"]) == {number}
    assert facts["travel_mm"] == pytest.approx(1.0 if number == 1 else 2.0, abs=0.05)
    with pytest.raises(InputError, match="r.csv, column 'displacement_mm': no loading 4: .* has 3"):
        aligned(cycles(1.0, 2.0, 2.0), "tension", which="4")


def test_a_staircase_is_calibrated_on_its_ramps():
    """Holds between the steps are no gap of the ramp, and not calibrated."""
    corners = np.array([0, 1, 3, 60, 62, 120, 122, 150.0])
    time = np.arange(0.0, 150.0, 0.05)
    travel = np.interp(time, corners, [0, 0, 1, 1, 2, 2, 3, 3])
    table = pd.DataFrame({"time_s": time, "displacement_mm": travel, "force_N": travel})
    found, facts = aligned(table, "tension")
    moving = found[found["calibrated"] == 1]
    assert len(moving) == pytest.approx(3 * 41, abs=6)
    assert moving["displacement_mm"].min() == pytest.approx(0.0, abs=0.1)
    assert facts["travel_mm"] == pytest.approx(3.0, abs=0.1)
    assert facts["ramp_speed_mm_s"] == pytest.approx(0.5, rel=0.05)


def of_material(table):
    """The record as nominal stress and strain of a sample of 100 mm2 and 10 mm."""
    return pd.DataFrame(
        {
            "time_s": table["time_s"],
            "strain": table["displacement_mm"] / 10.0,
            "stress_Pa": table["force_N"] / 1e-4,
        }
    )


def test_stress_and_strain_become_force_and_displacement():
    want, _ = aligned(record())
    table, facts = aligned(of_material(record()), size=Size())
    pd.testing.assert_frame_equal(table[list(want)], want)
    assert facts["strain"] == [pytest.approx(-0.39, abs=2e-3), pytest.approx(0.0, abs=2e-3)]
    assert facts["stress_pa"] == [pytest.approx(-1e4, rel=0.01), pytest.approx(0.0, abs=100)]
    positive = of_material(record(sign=1.0))
    table, told = aligned(positive, size=Size(), compressive=("strain", "stress"))
    np.testing.assert_allclose(table["displacement_mm"], want["displacement_mm"], atol=1e-12)
    assert told["positive"] == {"displacement_mm": "compression", "force_N": "compression"}
    with pytest.raises(InputError, match="r.csv: strain and stress_Pa need dimensions.*or shape"):
        aligned(of_material(record()))


@pytest.mark.parametrize(
    ("mode", "own", "told"),
    [
        ("compression", {"height_mm": 10.2, "area_mm2": 99.0}, ()),
        ("compression", {"height_mm": 12.0}, ("over 12 mm, but the height in the table is 10 mm",)),
        (
            "compression",
            {"area_mm2": 10.0},
            ("over 10 mm2, but the section in the table is 100 m",),
        ),
        ("indentation", {"height_mm": 12.0}, ()),
    ],
)
def test_dimensions_that_a_file_was_made_with_are_compared_with_the_table(mode, own, told):
    read = RecordSettings({}, {}, dict.fromkeys(AS_IN_FILE, "tension"), AS_IN_FILE)
    reading, size = {"compressive": [], "own_size": own}, IdealShape("cuboid", 0.01, 0.01, 0.01)
    facts = aligned_record(record(), reading, mode, read, SCHEMA, "r.csv", size)[1]
    doubts = [one for one in facts["warnings"] if "the file's own" in one]
    assert len(doubts) == len(told)
    assert all(words in doubt for words, doubt in zip(told, doubts, strict=True))


def test_a_plain_strain_under_a_title_in_percent_is_told_as_such():
    table = of_material(record()).assign(strain=lambda t: 1e-2 * t["strain"])
    told = {"strain": {"title": "Strain (%)", "unit": "%"}}
    message = r"'Strain \(%\)': the platen moves 0.039 mm only; .* write 1 in place of %"
    with pytest.raises(InputError, match=message):
        aligned(table, size=Size(), columns=told)
    with pytest.raises(InputError, match="is the column in m instead of mm"):
        aligned(table, size=Size())


def test_a_small_sample_may_move_little():
    """Half a percent of a height that is stated, 0.1 mm of one that is not."""
    table = record().assign(displacement_mm=lambda t: 0.0155 * t["displacement_mm"] / 3.9)
    flat = IdealShape("cylinder", 6e-3, 6e-3, 2e-3)
    kept, _ = aligned(table, size=flat)
    assert np.ptp(kept["displacement_mm"]) == pytest.approx(0.0155, rel=0.01)
    for size in (None, IdealShape("cylinder", 6e-3, 6e-3, 4e-3)):
        with pytest.raises(InputError, match="moves 0.0155 mm only; is the column in m instead"):
            aligned(table, size=size)


def test_stretch_is_below_one_in_compression_whatever_the_settings_say():
    table = of_material(record())
    table["stretch"] = 1.0 + table.pop("strain")
    settings = {"positive": {"displacement": "compression", "force": "tension"}}
    got, _ = aligned(table, size=Size(), **settings)
    np.testing.assert_allclose(got["displacement_mm"], record()["displacement_mm"], atol=1e-9)
    table["stretch"] = 2.0 - table["stretch"]
    with pytest.raises(InputError, match="exchange tension and compression in the column mode"):
        aligned(table, size=Size(), **settings)


def test_the_normal_force_has_a_sign_and_a_zero():
    raw = record(sign=1.0).assign(force_normal_N=0.5, torque_Nmm=2.0)
    raw.loc[raw["displacement_mm"] > 0.0, "force_normal_N"] = 1.5
    zero = {**AS_IN_FILE, "force_normal": "rest"}
    positive = {**dict.fromkeys(AS_IN_FILE, "tension"), "force_normal": "compression"}
    table, facts = aligned(raw, "shear", positive=positive, zero=zero)
    assert table["force_normal_N"].iloc[-1] == pytest.approx(-1.0, abs=0.05)
    assert table["force_normal_N"].iloc[0] == pytest.approx(0.0, abs=0.05)
    assert (table["torque_Nmm"] == 2.0).all()
    assert facts["positive"]["force_normal_N"] == "compression"


def test_a_hold_taken_for_a_loading_is_a_warning():
    table = record(noise=0.0)
    table["force_N"] = -1.0 + 0.3 * (1.0 - np.exp(-table["time_s"]))
    assert any("as in a hold" in warning for warning in check(table)["warnings"])
    assert not any("as in a hold" in warning for warning in check(record())["warnings"])


def test_cures_name_the_block_of_formats_that_a_record_is_read_by():
    table = record(sign=1.0)
    settings = {"columns": {}, "units": {}, "zero": AS_IN_FILE, "block": "press"}
    read = RecordSettings(positive=dict.fromkeys(AS_IN_FILE, "tension"), **settings)
    with pytest.raises(InputError) as refused:
        aligned_record(table, {"compressive": []}, "compression", read, SCHEMA, "r.csv")
    assert "`formats: {press: {positive: {displacement: loading" in str(refused.value)


def test_a_record_without_time_says_which_column_may_be_it():
    table = record().drop(columns="time_s")
    read = RecordSettings({}, {}, dict.fromkeys(AS_IN_FILE, "tension"), AS_IN_FILE)
    for rising, told in ((["t"], "columns: {time: t}, units: {time: s}"), (["t", "n"], "of order")):
        reading = {"compressive": [], "ascending": rising}
        facts = aligned_record(table, reading, "compression", read, SCHEMA, "r.csv")[1]
        (warning,) = (one for one in facts["warnings"] if "no column is known to hold" in one)
        assert (told in warning) is (len(rising) == 1)


def turned():
    """A ramp to 10 degrees and 3 N mm, of a cylinder of 20 mm."""
    way = np.linspace(0.0, 1.0, 101)
    of = {"angle_rad": np.radians(10.0) * way, "torque_Nmm": 3.0 * way}
    table = pd.DataFrame({"time_s": 10.0 * way, **of})
    return aligned(table, "torsion", IdealShape("cylinder", 20e-3, 20e-3, 8e-3))[0]


def test_in_torsion_rim_and_torque_over_radius_do_the_work():
    found = turned()
    assert found["displacement_mm"].iloc[-1] == pytest.approx(np.radians(10.0) * 10.0)
    assert found["force_N"].iloc[-1] == pytest.approx(3.0 / 10.0)
    assert not {"angle_rad", "torque_Nmm"} & set(found)


def test_torsion_needs_the_radius():
    way = np.linspace(0.0, 1.0, 101)
    table = pd.DataFrame({"time_s": 10.0 * way, "angle_rad": way, "torque_Nmm": way})
    with pytest.raises(InputError, match="the radius is not known; give shape cylinder"):
        aligned(table, "torsion")


def test_the_zero_of_the_torque_is_that_of_the_force():
    way = np.linspace(0.0, 1.0, 101)
    zero = {**AS_IN_FILE, "torque": "start"}
    table = pd.DataFrame({"time_s": 10.0 * way, "angle_rad": way, "torque_Nmm": 3.0 * way + 1.0})
    size = IdealShape("cylinder", 20e-3, 20e-3, 8e-3)
    found, _ = aligned(table, "torsion", size, zero=zero)
    assert found["force_N"].iloc[[0, -1]].tolist() == pytest.approx([0.0, 0.3])
