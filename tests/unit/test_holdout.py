"""What is held out follows from the table and the displacement, and from nothing else."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from softsample.errors import InputError
from softsample.holdout import (
    Selection,
    check_hold_out,
    folds,
    held_out,
    hold_out_text,
    in_turn,
    wholly_held_out,
)
from softsample.io import read_yaml
from softsample.records import Record

ROOT = Path(__file__).resolve().parents[2]
SCHEMA = read_yaml(ROOT / "workflow/schemas/config.schema.yaml")
ROWS = [
    {"sample": "S1", "group": "G", "mode": "shear"},
    {"sample": "C1", "group": "G", "mode": "compression", "specimen": "P"},
    {"sample": "C2", "group": "G", "mode": "compression", "specimen": "P"},
    {"sample": "T1", "group": "H", "mode": "tension"},
]
HEIGHT = 10e-3


@pytest.fixture
def record():
    """1 s of rest, then twice 4 s down to 4 mm, 2 s of hold and 4 s up; ten samples a second."""
    time = np.arange(0.0, 21.0, 0.1)
    corners = [0, 1, 5, 7, 11, 15, 17, 21]
    depth = np.interp(time, corners, 1e-3 * np.array([0, 0, 4, 4, 0, 4, 4, 0.0]))
    return Record(time, -depth, -depth, force_normal=depth).marked("compression")


def held(record, *selections, row=ROWS[1], channel="force"):
    return held_out(record, row, HEIGHT, channel, selections)


def times(record, mask):
    """First and last time of what is held out, and how many samples."""
    found = record.time[mask]
    return round(found[0], 1), round(found[-1], 1), len(found)


def test_nothing_is_held_out_without_a_selection(record):
    assert not held(record).any()
    assert not wholly_held_out(ROWS[0], [])
    assert folds(ROWS, None) == []


def test_phases_are_held_out(record):
    assert times(record, held(record, {"phase": "hold"})) == (5.0, 16.9, 40)
    assert times(record, held(record, {"phase": "hold", "cycle": 1})) == (5.0, 6.9, 20)
    unloading = held(record, {"phase": ["hold", "unloading"], "cycle": 2})
    assert times(record, unloading) == (15.0, 20.9, 60)
    loading = held(record, {"phase": "loading"})  # the rest before it as well
    assert times(record, loading) == (0.0, 14.9, 90)
    every = held(record, *({"phase": phase} for phase in ("loading", "hold", "unloading")))
    assert every.all()


def test_larger_strains_are_held_out_to_either_side(record):
    above = held(record, {"strain_above": 0.3, "cycle": [1]})
    assert times(record, above) == (4.1, 7.9, 39)
    turned = replace(record, displacement=-record.displacement)
    np.testing.assert_array_equal(held(turned, {"strain_above": 0.3, "cycle": [1]}), above)
    twice = held_out(record, ROWS[1], 2 * HEIGHT, "force", [{"strain_above": 0.3}])
    assert not twice.any()


def test_one_side_of_the_zero_is_held_out(record):
    swept = replace(record, displacement=record.displacement + 1e-3)
    for side, sign in (("positive", 1.0), ("negative", -1.0)):
        selection = {"direction": side}
        np.testing.assert_array_equal(held(swept, selection), sign * swept.displacement > 0.0)
        assert not wholly_held_out(ROWS[1], [selection])


@pytest.mark.parametrize(
    ("pattern", "fitting"),
    [("C*", ["C1", "C2"]), ("*[2-5]", ["C2"]), (["S1", "T?"], ["S1", "T1"]), ("C", [])],
)
def test_a_name_may_be_a_pattern(pattern, fitting):
    selection = Selection.of({"sample": pattern})
    assert [row["sample"] for row in ROWS if selection.fits(row)] == fitting


def test_keys_of_one_selection_go_together_and_selections_add_up(record):
    of_group = {"group": "G", "phase": "hold"}
    assert held(record, of_group).any()
    assert not held(record, of_group, row=ROWS[3]).any()
    assert not held(record, {**of_group, "mode": "shear"}).any()
    assert held(record, {**of_group, "mode": ["shear", "compression"]}).any()
    both = held(record, {"cycle": 2}, {"phase": "unloading", "cycle": 1})
    assert times(record, both) == (7.0, 20.9, 140)


def test_a_channel_is_held_out_alone(record):
    normal = {"channel": "force_normal", "sample": "C1"}
    assert held(record, normal, channel="force_normal").all()
    assert not held(record, normal).any()
    assert not wholly_held_out(ROWS[1], [normal])


def test_no_force_is_read(record):
    selections = [{"phase": "hold"}, {"strain_above": 0.2}, {"cycle": 2, "channel": "force"}]
    other = replace(record, force=np.full(len(record.time), np.nan), force_normal=None)
    np.testing.assert_array_equal(held(other, *selections), held(record, *selections))


def test_samples_are_held_out_as_a_whole():
    selections = [{"specimen": "P", "mode": "compression"}, {"sample": ["T1", "X"]}]
    assert [wholly_held_out(row, selections) for row in ROWS] == [False, True, True, True]
    assert wholly_held_out(ROWS[0], [{"specimen": "S1"}])  # a sample is a piece of its own
    assert not wholly_held_out(ROWS[0], [{"group": "G", "phase": "hold"}])


@pytest.mark.parametrize(
    ("leave_out", "expected"),
    [
        ("mode", [("shear", ["S1"]), ("compression", ["C1", "C2"])]),
        ("specimen", [("S1", ["S1"]), ("P", ["C1", "C2"])]),
        ("sample", [("S1", ["S1"]), ("C1", ["C1"]), ("C2", ["C2"])]),
        ("group", []),
    ],
)
def test_each_is_left_out_in_turn(leave_out, expected):
    assert folds(ROWS[:3], leave_out) == expected


def test_groups_are_left_out_of_a_study():
    assert folds(ROWS, "group") == [("G", ["S1", "C1", "C2"]), ("H", ["T1"])]


def test_a_selection_of_nothing_or_of_everything_is_refused():
    check_hold_out(ROWS, [{"mode": "shear"}, {"group": "H", "phase": "hold"}])
    with pytest.raises(InputError, match=r"hold_out.1: no sample fits it; there are group: G, H$"):
        check_hold_out(ROWS, [{"mode": "shear"}, {"group": "K", "phase": "hold"}])
    check_hold_out(ROWS, [{"sample": "C*"}])
    with pytest.raises(InputError, match="all samples of group 'H' are held out"):
        check_hold_out(ROWS, [{"sample": "C*"}, {"mode": "tension"}])


def test_keys_are_those_of_the_schema():
    keys = SCHEMA["properties"]["hold_out"]["items"]["properties"]
    assert set(keys) == {field.name for field in fields(Selection)}


@pytest.mark.parametrize(
    ("selections", "leave_out", "groups", "expected"),
    [
        ([{"phase": "unloading"}], "group", "abcd", True),
        ([{"phase": "unloading"}], "group", "abc", False),
        ([{"phase": "unloading"}], "specimen", "abcd", False),
        ([], "group", "abcd", False),
    ],
)
def test_parts_are_held_out_of_one_group_at_a_time_if_the_others_are_enough(
    selections, leave_out, groups, expected
):
    assert in_turn(selections, leave_out, groups) is expected


def test_the_rule_says_in_words_that_groups_take_turns():
    text = hold_out_text([{"strain_above": 0.3}, {"phase": "unloading"}], "group", pooled=True)
    assert text == "held out of one group at a time: strain above 0.3; phase unloading"
    listed = [{"sample": ["C1", "C2"], "cycle": [2, 3]}]
    assert hold_out_text(listed, None) == "held out: sample C1 or C2 and cycle 2 or 3"
