"""Known effects on top of measured records."""

import numpy as np
import pandas as pd
import pytest

from softsample.errors import InputError
from softsample.io import read_json, read_table, write_json, write_table, write_text
from softsample.measured.known import EFFECTS, MULTIPLE, main, score, write

TABLE = "sample\tgroup\tmode\trecord\nA1\tA\tcompression\tr/A1.csv\nB1\tB\tshear\tr/B1.csv\n"


def record(sign):
    """A ramp there and back, force in proportion."""
    way = np.concatenate([np.linspace(0.0, 2.0, 41), np.linspace(1.95, 0.0, 40)])
    time = 0.1 * np.arange(len(way))
    return pd.DataFrame({"time_s": time, "displacement_mm": sign * way, "force_N": 3 * sign * way})


def verdict(effects=(), limits=(), kind="none"):
    known = {name: {"value": value, "unit": ""} for name, value in dict(limits).items()}
    named = [{"name": names[0], "class": list(names)} for names in effects]
    return {"verdict": kind, "effects": named, "detection_limits": known}


@pytest.fixture
def results(tmp_path):
    """Two groups, of which one shows late contact, both an offset, neither a normal force."""
    folder = tmp_path / "measured"
    study = folder / "studies/set"
    write_text(study / "samples.tsv", TABLE)
    write_text(study / "study.yaml", "loop: {}\n")
    for name, sign in (("A1", -1.0), ("B1", 1.0)):
        write_table(study / f"r/{name}.csv", record(sign))
    limits = {"force_offset": 20.0, "late_contact": 0.1, "channel_crosstalk": 0.1}
    for group in "AB":
        write_json(folder / f"set/loop/{group}/verdict.json", verdict(limits=limits))
    return folder


def test_each_effect_has_its_own_form_and_leaves_the_rest():
    one = record(-1.0).assign(force_normal_N=0.0)
    changed = {name: change(one, 0.5) for name, (change, *_) in EFFECTS.items()}
    force, way = one["force_N"], one["displacement_mm"]
    assert (changed["force_offset"]["force_N"] - force).unique() == pytest.approx(5e-4)
    drift = changed["force_drift"]["force_N"] - force
    assert drift.iloc[-1] == pytest.approx(5e-4 * 8.0, rel=0.01)
    assert drift.iloc[0] == 0.0
    given = changed["machine_compliance"]["displacement_mm"] - way
    np.testing.assert_allclose(given, 0.5 * force)
    late = changed["channel_lag"]["force_N"]
    np.testing.assert_allclose(late[10:40], force[10:40] + 0.5 * 3 * 0.5)  # at 0.5 mm/s
    np.testing.assert_allclose(changed["channel_crosstalk"]["force_normal_N"], 0.5 * force)
    gap = changed["late_contact"]
    assert gap["displacement_mm"].min() == pytest.approx(-2.5)
    assert np.abs(gap["force_N"][gap["displacement_mm"] > -0.45]).max() < 0.4
    assert gap["time_s"].is_monotonic_increasing
    assert len(gap) == len(one) + 10
    resting = pd.concat([one.iloc[:1].assign(time_s=0.5 * t - 15.0) for t in range(30)] + [one])
    assert len(EFFECTS["late_contact"][0](resting, 0.5)) == len(resting) + 10


def test_an_effect_is_added_where_it_would_be_seen(results, tmp_path):
    folders = write(results, tmp_path / "known", ["set"])
    assert [f.name for f in folders] == ["set-force_offset", "set-late_contact"]
    offset = read_table(folders[0] / "r/B1.csv")["force_N"] - record(1.0)["force_N"]
    np.testing.assert_allclose(offset, 1e-3 * MULTIPLE * 20.0, rtol=1e-6)
    cases = read_json(tmp_path / "known/ground_truth.json")["experiments"]
    assert [(c["effect"], c["group"]) for c in cases] == [
        ("force_offset", "A"), ("force_offset", "B"), ("late_contact", "A"),
    ]  # fmt: skip


def test_answers_are_right_wrong_or_missed(results, tmp_path):
    target = tmp_path / "known"
    write(results, target, ["set"])
    right = verdict([["self_weight", "force_offset"]], kind="explained")
    wrong = verdict([["slack"]], kind="explained")
    write_json(target / "results/set-force_offset/loop/A/verdict.json", right)
    write_json(target / "results/set-force_offset/loop/B/verdict.json", wrong)
    assert score(results, target)["answer"].tolist() == ["right", "wrong", "missed"]
    assert main([str(results), str(target)]) == 0
    assert read_table(target / "score.csv")["verdict"].tolist()[2] == "failed"
    write_json(target / "ground_truth.json", {"experiments": []})
    with pytest.raises(InputError, match="not the ground truth that was withheld"):
        score(results, target)


def test_without_a_verdict_nothing_can_be_added(results, tmp_path, capsys):
    (results / "set/loop/A/verdict.json").unlink()
    assert main([str(results), str(tmp_path / "known"), "set"]) == 1
    assert "run `make measured` first" in capsys.readouterr().err
