from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from softsample.errors import InputError
from softsample.io import read_record_table, read_yaml
from softsample.records import RecordSettings, aligned_record, check_record

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
    return check_record(table, mode, SCHEMA, "r.csv")


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
    table = read_record_table(ROOT / f"resources/cohort/records/{file}.csv")
    assert check(table, mode)["travel_mm"] == pytest.approx(travel, abs=0.03)


def put(column, row, value):
    def change(table):
        table[column] = table[column].astype(object)
        table.loc[row, column] = value
        return table

    return change


REFUSED = {
    "missing column": (
        lambda t: t.drop(columns="force_N"),
        "r.csv, column 'force_N': is missing; give force",
    ),
    "unknown column": (
        lambda t: t.rename(columns={"force_N": "force_mN"}),
        "column 'force_mN': unknown name; did you mean 'force_N'",
    ),
    "NaN": (
        put("force_N", 100, np.nan),
        "line 100, column 'force_N': empty is not a number",
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
        "travels 0.0039 mm only; is the column in m instead of mm",
    ),
    "time runs back": (
        put("time_s", 50, 0.0),
        "line 50, column 'time_s': 0 s follows 0.45 s; time must rise",
    ),
    "force of the wrong sign": (
        lambda t: t.assign(force_N=-t["force_N"]),
        "line 1353, column 'force_N': [0-9.]+ at the end of loading, but negative is right in "
        "compression .*tell the machine's sign",
    ),
    "displacement of the wrong sign": (
        lambda t: t.assign(displacement_mm=-t["displacement_mm"]),
        "column 'displacement_mm': 3.8.* at the end of loading, but negative is right",
    ),
    "at rest": (
        lambda t: t.assign(displacement_mm=0.0 * t["displacement_mm"]),
        "column 'displacement_mm': .*there is no loading ramp",
    ),
    "few samples": (
        lambda t: t.iloc[:15],
        "column 'time_s': .*expected: time \\[s\\], at least 20 rows",
    ),
    "coarse ramp": (
        lambda t: pd.concat([t.iloc[:50], t.iloc[50::100]]),
        "the loading ramp .* has 1[0-9] samples; record at least 20",
    ),
    "hole in the ramp": (
        lambda t: pd.concat([t.iloc[:400], t.iloc[700:]]),
        "line 704: 3.01 s are missing in the loading ramp",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_bad_record_is_refused_with_place_and_cure(name):
    change, message = REFUSED[name]
    with pytest.raises(InputError, match=message):
        check(change(record()))


def test_signs_depend_on_the_mode():
    assert check(record(sign=1.0), "tension")["peak_force_N"] > 0.0
    with pytest.raises(InputError, match="positive is right in tension"):
        check(record(sign=-1.0), "tension")


def test_what_is_doubtful_is_a_warning():
    assert "force zero and noise are not known" in check(record(rest=0.0))["warnings"][0]
    clipped = record(noise=0.0)
    clipped["force_N"] = clipped["force_N"].clip(lower=-0.8)
    assert "overloaded" in check(clipped)["warnings"][0]


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
