"""Bonded area and modulus by rule against a row by hand."""

import numpy as np
import pytest

from softsample.report.bond import bond_table, modulus_factor


def fit(geometry, mu):
    change = {"T": {"mu_pa": -6.0}, "C": {"mu_pa": -4.0}}
    uncertainty = {"per_percent_of_force": change}
    return {"group": "G", "geometry": geometry, "model": "ogden2", "mu_pa": mu,
            "uncertainty": uncertainty}  # fmt: skip


ROWS = {"T": {"group": "G", "mode": "tension"}}
AREAS = {"within_depth_mm2": 300.0, "contact_mm2": 150.0}
PIECES = {"T": "T", "C": "C"}


def table(**report):
    reports = {"T": {"rule": "within_depth", "force_percent": -20.0, **AREAS, **report}}
    fits = [fit("real", 1000.0), fit("ideal", 500.0), {**fit("real", 1.0), "model": "ogden1"}]
    (row,) = bond_table(reports, {"T": {"ideal_area_mm2": 400.0}}, ROWS, fits, PIECES).to_dict(
        "records"
    )
    return row


def test_a_weaker_bond_asks_for_a_larger_modulus():
    row = table()
    assert (row["within_depth_percent"], row["contact_percent"]) == (75.0, 37.5)
    assert row["within_depth_mu_pa"] == 1000.0
    assert row["contact_mu_pa"] == pytest.approx(1000.0 * 0.8**-0.6)
    assert row["within_depth_bias_percent"] == pytest.approx(-50.0)
    assert row["contact_bias_percent"] == pytest.approx(100.0 * (0.5 * 0.8**0.6 - 1.0))


def test_a_study_with_the_other_rule_is_told_from_its_own_side():
    row = table(rule="contact")
    assert row["contact_mu_pa"] == 1000.0
    assert row["within_depth_mu_pa"] == pytest.approx(1000.0 * 0.8**0.6)


def test_a_test_that_could_not_be_simulated_leaves_the_other_rule_open():
    row = table(force_percent=None)
    assert row["within_depth_mu_pa"] == 1000.0
    assert np.isnan([row["contact_mu_pa"], row["contact_bias_percent"], row["force_percent"]]).all()


def test_a_shear_sample_alone_has_the_modulus_of_the_inverse_force():
    alone = {
        **fit("real", 1000.0),
        "uncertainty": {"per_percent_of_force": {"S": {"mu_pa": -10.0}}},
    }
    reports = {"S": {"rule": "within_depth", "force_percent": -20.0}}
    assert modulus_factor(alone, reports, {"S": "S"}) == pytest.approx(1.0 / 0.8)
