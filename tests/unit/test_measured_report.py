"""Tables and page of verdicts on others' records: columns as promised, the unknown first."""

import pandas as pd

from softsample.report.measured import (
    channel_table,
    effect_table,
    evidence_table,
    set_page,
    summary_table,
    unstated_table,
    zero_table,
)

EFFECT = {
    "name": "late_contact",
    "class": ["late_contact", "displacement_zero"],
    "parameters": {"gap_mm": {"value": 0.2, "unit": "mm", "low": 0.1, "high": 0.3}},
    "evidence": 40.0,
    "separating_experiment": "scan the top",
}


def group(name, verdict, before, after, effects=(), withheld=()):
    return {
        "record_group": name, "model": "bonded", "verdict": verdict, "effects": list(effects),
        "withheld": list(withheld), "held_out_before_percent": before,
        "held_out_after_percent": after, "records": 3,
        "held_out_by": {"shear": {"before_percent": before, "after_percent": after}},
    }  # fmt: skip


VERDICT = {
    "set": "gels",
    "groups": [
        group("one", "none", 1.0, 1.0),
        group("two", "explained", 9.0, 4.0, [EFFECT]),
        group("three", "unknown", 30.0, 30.0, withheld=["force_drift"]),
    ],
    "unstated": ["friction"],
    "independent_evidence": {"bench_mm_per_N": 0.06},
}


def test_summary_has_the_promised_columns_and_a_row_a_group():
    table = summary_table([VERDICT])
    assert list(table.columns) == [
        "set", "record_group", "verdict", "class", "held_out_before_percent",
        "held_out_after_percent", "records",
    ]  # fmt: skip
    assert table["record_group"].tolist() == ["one/bonded", "two/bonded", "three/bonded"]
    assert table["class"].tolist() == ["", "late_contact|displacement_zero", ""]
    assert table.loc[2, "held_out_after_percent"] == 30.0


def test_effects_come_with_size_interval_and_experiment():
    (row,) = effect_table([VERDICT]).to_dict("records")
    assert (row["value"], row["low"], row["high"], row["unit"]) == (0.2, 0.1, 0.3, "mm")
    assert row["experiment"] == "scan the top"
    assert evidence_table([VERDICT])["value"].tolist() == [0.06]
    assert unstated_table([VERDICT])["unstated"].tolist() == ["friction"]


def test_each_mode_has_its_own_error():
    table = channel_table([VERDICT])
    assert table["channel"].tolist() == ["shear"] * 3
    assert table["before_percent"].tolist() == [1.0, 9.0, 30.0]
    assert table["after_percent"].tolist() == [1.0, 4.0, 30.0]


def test_the_page_says_the_unknown_first_and_what_was_withheld():
    text = set_page(VERDICT)
    assert text.index("three/bonded: unknown") < text.index("two/bonded") < text.index("one/bonded")
    assert "not supported by the fitted part: force_drift" in text
    assert "late_contact or displacement_zero" in text
    assert "held-out error 9.0 % before, 4.0 % after" in text
    assert "(errors.png)" in text


def test_zeros_are_sorted_by_how_far_off_they_are():
    zeros = pd.DataFrame({"record": ["a", "b"], "effect": "x", "class": "x", "size": 1.0,
                          "unit": "N", "sigmas": [3.0, -9.0]})  # fmt: skip
    table = zero_table({"gels": zeros, "clots": zeros.iloc[:0]})
    assert table["record"].tolist() == ["b", "a"]
    assert table["set"].tolist() == ["gels", "gels"]
    assert len(zero_table({})) == 0
