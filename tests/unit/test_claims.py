"""The table of claims of the paper: its numbers are those of the tables, its verdicts theirs."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from softsample.io import read_table
from softsample.report.claims import ALIKE, claims_table

DATA = Path(__file__).resolve().parents[2] / "docs/data/reproduction"


@pytest.fixture
def tables():
    return {path.stem: read_table(path) for path in DATA.glob("*.csv") if path.stem != "claims"}


def of(table, words):
    (row,) = table[table["claim"].str.contains(words)].to_dict("records")
    return row


def test_the_page_has_the_claims_of_its_tables(tables):
    pd.testing.assert_frame_equal(read_table(DATA / "claims.csv"), claims_table(tables))
    page = (DATA.parents[1] / "reproduction.md").read_text()
    for row in claims_table(tables).to_dict("records"):
        if row.pop("by_construction"):
            row["verdict"] += "; alike by construction"
        assert " | ".join(map(str, row.values())) in page
    assert f"± {ALIKE:g} points" in page


@pytest.mark.parametrize(
    ("mean", "sd", "verdict"),
    [
        (-46.5, 2.0, "reproduced"),
        (-70.0, 2.0, "differs"),
        (-45.0, 20.0, "not testable"),  # holds the paper's mean, as it would hold any
        (-90.0, 20.0, "differs"),
    ],
)
def test_a_mean_is_reproduced_if_a_narrow_interval_holds_the_papers(tables, mean, sd, verdict):
    rows = tables["summary"]
    here = (rows["quantity"] == "modulus_two_term") & (rows["mode"] == "tension+compression")
    rows.loc[here, ["mean_percent", "sd_percent", "paper_sd_percent"]] = mean, sd, sd
    row = of(claims_table(tables), "by 47.5 %")
    assert row["verdict"] == verdict
    assert ("not resolved by 5 samples" in row["why"]) == (verdict == "not testable")
    half = 1.859548 * np.sqrt(2.0 * sd**2 / 5.0)  # Student's t of 8 degrees of freedom, 95 %
    assert f"{mean + 47.5:+.1f}".replace("-", "−") + f" ± {half:.1f} points" in row["why"]


def test_what_the_cohort_was_made_like_confirms_nothing(tables):
    table = claims_table(tables)
    built = table[table["by_construction"]]
    assert built["claim"].str.contains("areas|real geometry fit|displacements serve").all()
    assert len(built) == 6


def test_the_bias_in_shear_is_said_for_both_bonds(tables):
    row = of(claims_table(tables), "by 10 %")
    shear = tables["bond"][tables["bond"]["mode"] == "shear"]
    for rule in ("within_depth", "contact"):
        assert f"{shear[f'{rule}_bias_percent'].mean():+.1f}".replace("-", "−") in row["why"]
    assert row["why"].endswith("the paper lies between")
    tables["bond"]["contact_bias_percent"] = -9.0
    assert "between" not in of(claims_table(tables), "by 10 %")["why"]


def test_exponents_are_reproduced_if_all_that_records_bound_are_close(tables):
    rows = tables["exponents"]
    rows["alpha1"], rows["alpha1_low"], rows["alpha1_high"] = -8.2, -8.5, -7.9
    rows["alpha2"], rows["alpha2_low"], rows["alpha2_high"] = 15.5, 15.0, 16.5
    rows.loc[0, ["alpha1", "alpha1_low"]] = -2.0, np.nan  # not bounded
    rows.loc[0, "alpha1_high"] = -3.0
    row = of(claims_table(tables), "free exponents")
    assert row["verdict"] == "reproduced"
    assert "α1 within 10 % of −8 in 9 of 9 groups that bound it" in row["found"]
    assert "inside the interval in 10 of 10" in row["found"]
    rows.loc[1, ["alpha1", "alpha1_low", "alpha1_high"]] = -9.0, -9.2, -8.8
    row = of(claims_table(tables), "free exponents")
    assert row["verdict"] == "differs"
    assert "inside the interval in 9 of 10" in row["found"]


def test_a_claim_without_its_table_is_not_testable():
    table = claims_table({})
    assert set(table["verdict"]) == {"not testable"}
    assert of(table, "mesh-independent")["why"] == "without sensitivity, fit_errors"
