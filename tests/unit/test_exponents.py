"""Free exponents: tables of groups, and whether groups share them."""

import numpy as np
import pandas as pd
import pytest

from softsample.errors import CalibrationError, InputError
from softsample.figures.exponents import exponents_figure
from softsample.laws.candidates import Candidate
from softsample.laws.exponents import common_table, exponent_table
from softsample.laws.shared import shared_value

FREE, STUDY = "ogden(-18:-2)+ogden(4:26)", "ogden(-8)+ogden(16)"


def test_a_candidate_within_ranges_goes_no_further():
    law = Candidate.of(FREE)
    assert law.name == FREE
    assert [(s.name, s.low, s.high) for s in law.shape] == [
        ("mu1_fraction", 0.0, 1.0), ("alpha1", -18.0, -2.0), ("alpha2", 4.0, 26.0)
    ]  # fmt: skip
    assert all(s.low <= s.default <= s.high for s in law.shape)
    mixed = Candidate.of("neo_hooke+ogden(-20:-4)")
    assert [(s.low, s.high) for s in mixed.shape] == [(0.0, 1.0), (-20.0, -4.0)]


@pytest.mark.parametrize("term", ["ogden(-2:-18)", "ogden(-18)", "ogden(-80:0)", "ogden(a:b)",
                                  "neo_hooke(0:1)", "foam(1:2)"])  # fmt: skip
def test_a_range_that_a_law_cannot_have_is_refused_with_those_it_has(term):
    with pytest.raises(InputError, match=r"no range low:high of each shape parameter"):
        Candidate.of(term)


def test_shared_value_of_two_groups_by_hand():
    """Of one parameter with equal variances: the mean, and squares of half the difference."""
    found = shared_value([np.array([1.0]), np.array([3.0])], [np.array([[2.0]])] * 2)
    assert found["value"] == pytest.approx([2.0])
    assert found["deviance"] == pytest.approx(1.0)
    assert (found["degrees_of_freedom"], found["groups"]) == (1, 2)
    assert found["p_value"] == pytest.approx(0.3173, abs=1e-4)
    with pytest.raises(CalibrationError, match="one group alone"):
        shared_value([np.ones(1)], [np.eye(1)])


def test_groups_with_one_truth_are_told_apart_at_the_level_of_the_test():
    """Over 400 sets of correlated estimates p-values are uniform."""
    rng = np.random.default_rng(2)
    root = np.array([[0.2, 0.0], [0.6, 0.5]])
    values = []
    for _ in range(400):
        groups = [np.array([-8.0, 16.0]) + root @ rng.normal(size=2) for _ in range(5)]
        values.append(shared_value(groups, [root @ root.T] * 5)["p_value"])
    assert np.mean(np.array(values) < 0.1) == pytest.approx(0.1, abs=0.04)


def report_of(modes, alpha, simpler=(STUDY,), low=-9.0):
    ends = {"value": 0.0, "low": None, "high": 18.0}
    names = ("mu", "mu1_fraction", "alpha1", "alpha2")
    values = (1000.0, 0.9, *alpha)
    fit = {
        "mu_pa": 1000.0, "shape": dict(zip(names[1:], values[1:], strict=True)),
        "intervals": {n: {**ends, "value": v} for n, v in zip(names, values, strict=True)},
        "covariance_of_shape": np.diag([1e-4, 0.01, 0.04]).tolist(),
        "error_fitted_percent": 0.7, "simpler": list(simpler),
        "at_bound": ["alpha1 at its maximum, -2"], "open": ["alpha2"],
    }  # fmt: skip
    fit["intervals"]["alpha1"]["low"] = low
    return {"modes": modes, "laws": {FREE: fit, STUDY: {}}}


def test_row_of_free_exponents_by_hand():
    reports = {"S": report_of(["shear"], (-8.0, 15.0)),
               "TC": report_of(["tension", "compression"], (-8.2, 16.0), simpler=())}  # fmt: skip
    runs = dict.fromkeys(reports, pd.DataFrame({"difference_percent": [0.2, 0.4]}))
    table = exponent_table(FREE, reports, runs)
    row = table.iloc[0]
    assert list(table["mode"]) == ["shear", "tension+compression"]
    assert (row["mu1_pa"], row["mu2_pa"]) == pytest.approx((900.0, 100.0))
    assert row["error_percent"] == 0.7
    assert np.isnan(row["alpha2_low"])
    assert (row["alpha2"], row["alpha2_high"], row["mesh_curve_percent"]) == (15.0, 18.0, 0.4)
    assert (row["active_bounds"], row["open"]) == ("alpha1 at its maximum, -2", "alpha2")
    assert list(table["study_rejected"]) == [False, True]


def test_a_group_whose_law_was_crushed_has_no_exponents_but_the_reason():
    reason = "elements are crushed where it fits best"
    crushed = {"modes": ["shear"], "laws": {STUDY: {}}, "skipped": {FREE: reason}}
    reports = {"S": crushed, "T": bounded(["shear"], (-8.0, 15.0))}
    runs = dict.fromkeys(reports, pd.DataFrame({"difference_percent": []}))
    table = exponent_table(FREE, reports, runs).set_index("group")
    assert table.loc["S", "open"] == reason
    assert np.isnan(table.loc["S", "alpha1"])
    assert table.loc["T", "alpha1"] == -8.0
    assert common_table(FREE, reports).empty  # one group shares nothing
    assert exponents_figure(table.reset_index(), [(-18.0, -2.0), (4.0, 26.0)], (-8.0, 16.0))


def bounded(modes, alpha):
    report = report_of(modes, alpha)
    for interval in report["laws"][FREE]["intervals"].values():
        interval["low"], interval["high"] = -20.0, 20.0
    return report


def test_exponents_are_constant_unless_they_differ_by_more_than_their_covariance():
    alike = [bounded(["shear"], (-8.0, alpha)) for alpha in (15.0, 15.2)]
    apart, open_ = bounded(["tension"], (-9.5, 15.0)), report_of(["shear"], (-2.0, 25.0))
    reports = dict(zip("ABCD", [*alike, apart, open_], strict=True))
    table = common_table(FREE, reports).set_index("mode")
    assert list(table.index) == ["all", "shear"]  # tension has one group
    assert list(table["groups"]) == [3, 2]  # the open one tells nothing
    assert table.loc["shear", "alpha2"] == pytest.approx(15.1)
    assert list(table["verdict"]) == ["not constant", "constant"]


def test_an_open_end_is_an_arrow():
    reports = {"S": report_of(["shear"], (-8.0, 15.0)), "T": report_of(["shear"], (-7.0, 9.0))}
    runs = dict.fromkeys(reports, pd.DataFrame({"difference_percent": [0.2]}))
    table = exponent_table(FREE, reports, runs)
    figure = exponents_figure(table, [(-18.0, -2.0), (4.0, 26.0)], (-8.0, 16.0))
    marks = [[line.get_marker() for line in ax.lines if line.get_marker() in "<>|"]
             for ax in figure.axes]  # fmt: skip
    assert marks == [["|", "|"] * 2, ["<", "|"] * 2]
    assert [text.get_text() for text in figure.axes[0].get_yticklabels()] == ["S", "T"]
