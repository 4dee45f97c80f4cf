"""Terms and limits of the intervals against rows computed by hand."""

import re
from pathlib import Path

import numpy as np
import pytest

from softsample.io import read_yaml
from softsample.report.intervals import FLOOR, force_terms, interval_rows, interval_table
from softsample.report.page import with_interval
from softsample.response.floor import FloorSettings

ROOT = Path(__file__).resolve().parents[2]
SETTINGS = FloorSettings(1.0, (0.5, 1.0), {"compression": (4.0, 8.0), "shear": (1.0, 2.0)})
CHANGES = {
    "twice the hourglass stiffness": {"modulus_percent": 0.2},
    "elements of twice the size": {"modulus_percent": -6.0},
}


BAND = {"low_percent": -1.0, "high_percent": 3.0}
CURVES = {"error_bound_percent": 0.5}


def terms(mode="compression", size=0.5, settings=SETTINGS, band=BAND, curves=CURVES, bond=None):
    return force_terms(mode, band, bond, CHANGES, curves, size, settings)


def test_terms_by_hand():
    root = np.sqrt(3.0)
    assert terms() == pytest.approx(
        {"geometry": 2.0, "time": 0.5 / root, "mesh": -6.0 / root, "hourglass": 0.2 / root,
         "element": 4.0 / root, "bond": 0.0}
    )  # fmt: skip


@pytest.mark.parametrize(("rule", "sign"), [("within_depth", 1.0), ("contact", -1.0)])
def test_the_other_rule_of_the_bond_is_a_limit_of_the_force(rule, sign):
    found = terms(bond={"rule": rule, "force_percent": -20.0})["bond"]
    assert found == pytest.approx(sign * 100.0 * np.log(0.8) / np.sqrt(3.0))
    assert np.isnan(terms(bond={"rule": rule, "force_percent": None})["bond"])


def test_a_second_order_mesh_leaves_a_third_of_the_difference():
    second = FloorSettings(2.0, SETTINGS.element_size_mm, SETTINGS.element_percent)
    assert terms(settings=second)["mesh"] == pytest.approx(terms()["mesh"] / 3.0)


@pytest.mark.parametrize(
    ("size", "percent"), [(0.25, 1.0), (0.5, 1.0), (0.5**0.5, 1.5), (1.0, 2.0)]
)
def test_element_term_is_interpolated_over_the_logarithm_of_the_size(size, percent):
    assert terms("shear", size)["element"] == pytest.approx(percent / np.sqrt(3.0))


def fit(model="ogden2"):
    scatter = {"mu_pa": {"sd": 3.0}, "mu1_pa": {"sd": 4.0}, "mu2_pa": {"sd": 5.0}}
    percent = {"mu_pa": -6.0, "mu1_pa": -8.0, "mu2_pa": 2.0}
    return {
        "group": "G", "geometry": "real", "model": model, "samples": ["T", "C"],
        "mu_pa": 1000.0, "mu1_pa": 800.0, "mu2_pa": 200.0, "active_bounds": [],
        "uncertainty": {
            "confidence": 0.9,
            "bootstrap": scatter,
            "per_percent_of_force": {"T": percent, "C": {k: 2.0 * v for k, v in percent.items()}},
            "contact_zero": {"C": {"mu_pa": -40.0, "mu1_pa": -30.0, "mu2_pa": -10.0}},
        },
    }  # fmt: skip


def force(**terms):
    return dict.fromkeys(("geometry", "time", "bond", *FLOOR), 0.0) | terms


FORCES = {
    ("T", "real", "ogden2"): force(geometry=1.0, mesh=3.0),
    ("C", "real", "ogden2"): force(time=0.5, mesh=2.0, element=1.0),
}


EACH = {"T": "T", "C": "C"}
"""Every sample is a piece of its own."""


def test_row_of_the_modulus_by_hand():
    table = interval_table([fit()], FORCES, EACH).set_index("modulus")
    assert list(table.index) == ["mu", "mu1", "mu2"]
    row = table.loc["mu"]
    expected = {
        "statistics": 3.0, "contact_zero": 40.0, "geometry": 6.0, "time": 6.0,
        "mesh": 18.0 + 24.0, "hourglass": 0.0, "element": 12.0,
    }  # fmt: skip
    for name, value in expected.items():
        assert row[f"{name}_percent"] == pytest.approx(0.1 * value)
    measured = 1.644854 * np.sqrt(9.0 + 1600.0 + 36.0 + 36.0)
    assert row["high_without_floor_pa"] - 1000.0 == pytest.approx(measured, rel=1e-6)
    assert 1000.0 - row["low_without_floor_pa"] == pytest.approx(measured, rel=1e-6)
    total = np.hypot(measured, 1.644854 * np.sqrt(42.0**2 + 144.0))
    assert row["high_pa"] - 1000.0 == pytest.approx(total, rel=1e-6)
    assert row["high_without_bond_pa"] == row["high_pa"]
    assert table.loc["mu2", "statistics_percent"] == pytest.approx(2.5)


def test_errors_of_the_bond_add_up_over_pieces():
    forces = {key: {**of, "bond": 2.0} for key, of in FORCES.items()}
    row = interval_table([fit()], forces, EACH).set_index("modulus").loc["mu"]
    assert row["bond_percent"] == pytest.approx(0.1 * (12.0 + 24.0))
    before = interval_table([fit()], FORCES, EACH).set_index("modulus").loc["mu"]
    assert row["high_without_bond_pa"] == before["high_pa"]
    wider = np.hypot(before["high_pa"] - 1000.0, 1.644854 * 36.0)
    assert row["high_pa"] - 1000.0 == pytest.approx(wider, rel=1e-6)


def test_a_term_at_its_bound_has_limits_and_no_percent():
    """`mu2` of 0 Pa: an interval from 0 upward, and nothing to take a percent of."""
    table = interval_table([fit() | {"mu2_pa": 0.0}], FORCES, EACH).set_index("modulus")
    row = table.loc["mu2"]
    assert row["low_pa"] == row["low_without_floor_pa"] == 0.0 < row["high_pa"]
    assert np.isnan(row["statistics_percent"])


def test_a_mesh_too_stiff_in_one_test_and_too_soft_in_the_other_cancels():
    forces = FORCES | {("C", "real", "ogden2"): force(mesh=-1.5)}
    row = interval_table([fit()], forces, EACH).set_index("modulus").loc["mu"]
    assert row["mesh_percent"] == pytest.approx(0.0)


def test_records_of_one_piece_share_the_errors_of_its_model():
    """A percent of force moves mu by -6 and -12 Pa; as one piece by -18 Pa, not by 13.4 Pa."""
    forces = {("T", "real", "ogden2"): force(geometry=1.0, mesh=2.0)}
    same = interval_table([fit()], forces, {"T": "T", "C": "T"}).set_index("modulus").loc["mu"]
    assert same["geometry_percent"] == pytest.approx(1.8)
    assert same["mesh_percent"] == pytest.approx(3.6)


def test_what_is_not_known_is_empty_and_not_in_the_interval():
    unknown = {key: {**value, "geometry": np.nan} for key, value in FORCES.items()}
    none = {key: {**value, "geometry": 0.0} for key, value in FORCES.items()}
    row, other = (interval_table([fit()], each, EACH).iloc[0] for each in (unknown, none))
    assert np.isnan(row["geometry_percent"])
    assert (row["low_pa"], row["high_pa"]) == (other["low_pa"], other["high_pa"])
    assert np.isnan(terms(band=None)["geometry"])


def test_a_closed_form_has_no_error_of_mesh_and_loading_time():
    found = terms(band=None, curves={"method": "closed form"})
    assert {name: value for name, value in found.items() if value} == {
        "geometry": pytest.approx(np.nan, nan_ok=True)
    }


def test_element_term_of_the_other_modes():
    tension = FloorSettings(1.0, (0.5, 1.0), {"tension": (3.0, 6.0)})
    assert tension.element("pure_shear", 1.0) == pytest.approx(6.0)
    assert tension.element("confined_compression", 1.0) == 0.0
    own = FloorSettings(1.0, (0.5, 1.0), {"tension": (3.0, 6.0), "pure_shear": (1.0, 2.0)})
    assert own.element("pure_shear", 1.0) == pytest.approx(2.0)


def test_one_term_has_one_row():
    forces = {(s, "real", "ogden1"): value for (s, *_), value in FORCES.items()}
    assert list(interval_table([fit("ogden1")], forces, EACH)["modulus"]) == ["mu"]


def test_the_floor_is_what_the_verification_found():
    """Element term of the config = three-field column of docs/verification.md, sign aside."""
    page = (ROOT / "docs/verification.md").read_text(encoding="utf-8")
    floor = FloorSettings(**read_yaml(ROOT / "config/config.yaml")["floor"])
    for size, *row in zip(floor.element_size_mm, *floor.element_percent.values(), strict=True):
        for mode, percent in zip(floor.element_percent, row, strict=True):
            found = re.search(rf"\| {size:g} mm \| {mode} \| [^|]* \| -([\d.]+) \|", page)
            assert found, (size, mode)
            assert percent == float(found[1])


def test_a_modulus_at_its_largest_has_no_upper_limit():
    forces = {name: terms() for name in ("T", "C")}
    pieces = {"T": "T", "C": "C"}
    at_bound = {**fit(), "active_bounds": ["mu at its maximum"]}
    (free,), (held,) = (interval_rows(one, forces, pieces)[:1] for one in (fit(), at_bound))
    assert held["low_pa"] == free["low_pa"]
    assert np.isnan([held["high_pa"], held["high_without_floor_pa"]]).all()
    shown = with_interval(held["value_pa"], held["low_pa"], held["high_pa"])
    assert re.fullmatch(r"1000 \(\d+ or more\)", shown)
    assert with_interval(1000.0, None, None) == "1000"
