"""Verdicts against a made-up truth."""

import pandas as pd
import pytest

from softsample.scoring import verdict_score


def truth(*effects):
    known = [{"name": name, "right": right} for name, right in effects]
    return {"effects": known, "material": {"mu1_Pa": 600.0, "mu2_Pa": 400.0}}


def verdict(kind, classes=(), before=2.0, after=1.0):
    fold = {"last quarter": {"shear": {"rms_N_structured": before}}}
    return {
        "verdict": kind,
        "effects": [{"name": members[0], "class": list(members)} for members in classes],
        "theta_before": {"mu": {"value": 900.0}},
        "theta_after": {"mu": {"value": 1010.0}},
        "held_out_before": fold,
        "held_out_after": {"last quarter": {"shear": {"rms_N_structured": after}}},
    }


DRIFT, OFFSET = ("force_drift", ["force_drift"]), ("self_weight", ["self_weight", "force_offset"])


@pytest.mark.parametrize(
    ("effects", "found", "right", "one", "wrong"),
    [
        ([], verdict("none"), True, True, 0),
        ([], verdict("unknown"), False, False, 0),
        ([], verdict("explained", [("gain",)]), False, False, 1),
        ([DRIFT], verdict("explained", [("adhesion", "force_drift")]), True, True, 0),
        ([DRIFT], verdict("none"), False, False, 0),
        ([DRIFT], verdict("explained", [("force_drift",), ("gain",)]), True, True, 1),
        ([DRIFT, OFFSET], verdict("explained", [("force_offset",)]), False, True, 0),
        (
            [DRIFT, OFFSET],
            verdict("explained", [("force_drift",), ("self_weight",)]),
            True,
            True,
            0,
        ),
    ],
)
def test_each_true_effect_has_to_be_in_a_named_class(effects, found, right, one, wrong):
    row = verdict_score({"A": found}, {"A": truth(*effects)}).iloc[0]
    assert (row["right"], row["one_right"], row["wrong"]) == (right, one, wrong)


def test_errors_of_modulus_and_held_out_are_before_and_after():
    row = verdict_score({"A": verdict("none")}, {"A": truth()}).iloc[0]
    assert row["mu_error_before_percent"] == pytest.approx(-10.0)
    assert row["mu_error_after_percent"] == pytest.approx(1.0)
    assert row["held_out_removed_percent"] == pytest.approx(50.0)
    nothing = verdict_score({"A": verdict("none", before=0.0, after=0.0)}, {"A": truth()}).iloc[0]
    assert pd.isna(nothing["held_out_removed_percent"])
