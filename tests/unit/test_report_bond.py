"""Bonded area and modulus by rule against a row by hand."""

import numpy as np
import pytest

from softsample.report.bond import bond_table


def fit(geometry, mu):
    return {"group": "G", "geometry": geometry, "model": "ogden2", "mu_pa": mu}


ROWS = {"T": {"group": "G", "mode": "tension"}}
AREAS = {"within_depth_mm2": 300.0, "contact_mm2": 150.0}


def table(other, **report):
    reports = {"T": {"rule": "within_depth", "force_percent": -20.0, **AREAS, **report}}
    fits = [fit("real", 1000.0), fit("ideal", 500.0), {**fit("real", 1.0), "model": "ogden1"}]
    (row,) = bond_table(
        reports, {"T": {"ideal_area_mm2": 400.0}}, ROWS, fits, {"G": other}
    ).to_dict("records")
    return row


def test_either_rule_has_its_area_modulus_and_bias():
    row = table({"mu_pa": 1250.0})
    assert (row["within_depth_percent"], row["contact_percent"]) == (75.0, 37.5)
    assert (row["within_depth_mu_pa"], row["contact_mu_pa"]) == (1000.0, 1250.0)
    assert row["within_depth_bias_percent"] == pytest.approx(-50.0)
    assert row["contact_bias_percent"] == pytest.approx(-60.0)


def test_a_study_with_the_other_rule_is_told_from_its_own_side():
    row = table({"mu_pa": 800.0}, rule="contact")
    assert (row["within_depth_mu_pa"], row["contact_mu_pa"]) == (800.0, 1000.0)


def test_a_test_that_could_not_be_simulated_leaves_the_other_rule_open():
    row = table(None, force_percent=None)
    assert row["within_depth_mu_pa"] == 1000.0
    assert np.isnan([row["contact_mu_pa"], row["contact_bias_percent"], row["force_percent"]]).all()
