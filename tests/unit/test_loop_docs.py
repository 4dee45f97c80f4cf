"""docs/loop.md tells of undeclared records and cohort what the committed tables say."""

from pathlib import Path

import pandas as pd
import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGE = " ".join((DOCS / "loop.md").read_text(encoding="utf-8").split())
DATA = DOCS / "data/undeclared"
SCORE = pd.read_csv(DATA / "after_changes_score.csv", keep_default_na=False)
LOOP = pd.read_csv(DATA / "after_changes_loop.csv", keep_default_na=False)


def classes(named):
    return named.replace("|", " or ") or "–"


@pytest.mark.parametrize("row", list(SCORE.itertuples()), ids=SCORE["group"])
def test_each_group_has_its_line(row):
    cells = (
        row.group,
        row.truth or "none",
        row.verdict,
        classes(row.named),
        "yes" if row.right else "no",
        f"{row.held_out_removed_percent:.0f}",
        f"{row.mu_error_before_percent:+.1f}, {row.mu_error_after_percent:+.1f}",
    )
    assert f"| {' | '.join(cells)} |" in PAGE


def test_medians_are_those_of_the_table():
    with_effect = SCORE[SCORE["truth"] != ""]
    seen = with_effect[with_effect["right"]]
    removed = "held_out_removed_percent"
    assert f"median of all nine falls by {with_effect[removed].median():.0f} %" in PAGE
    assert f"that of the {len(seen)} that are seen by {seen[removed].median():.0f} %" in PAGE
    assert f"{SCORE['right'].sum()} of {len(SCORE)} are right" in PAGE


def test_held_out_errors_of_the_cuboid_are_those_of_the_table():
    ideal = LOOP[LOOP["geometry"] == "ideal"]
    named = ideal["classes"].str.contains("real_geometry")
    before, after = (ideal[f"held_out_{when}_percent"] for when in ("before", "after"))
    assert f"is named in {named.sum()} of the {len(ideal)} groups" in PAGE
    assert f"from {before.min():.0f} to {before.max():.0f} % of the peak" in PAGE
    assert f"to {after.min():.1f} to {after.max():.0f} %" in PAGE


def test_second_effects_and_moduli_of_the_cuboid_are_those_of_the_table():
    by = {kind: rows.set_index("group") for kind, rows in LOOP.groupby("geometry")}
    named = []
    for row in SCORE[SCORE["truth"] != ""].itertuples():
        classes = [of.split("|") for of in by["ideal"].loc[row.group, "classes"].split("; ")]
        beside = [effect for of in classes if "real_geometry" not in of for effect in of]
        named.append(set(row.truth.split("; ")) <= set(beside))
    assert f"the second effect or its class in {sum(named)} of {len(named)}" in PAGE
    ratio = by["ideal"]["mu_after_pa"].astype(float) / by["real"]["mu_after_pa"].astype(float)
    assert f"within {100.0 * (ratio - 1.0).abs().max():.0f} % of those on the real" in PAGE


def test_the_cohort_is_that_of_its_tables():
    cohort = pd.read_csv(DOCS / "data/loop/cohort.csv", keep_default_na=False)
    ideal = cohort[(cohort["geometry"] == "ideal") & cohort["group"].str.startswith("TC")]
    named = ideal["classes"].str.contains("real_geometry").sum()
    assert f"In the cohort it is {named} of the {len(ideal)} groups" in PAGE
    before, after = (ideal[f"held_out_{when}_percent"] for when in ("before", "after"))
    assert (after < before).all()
    fall = f"from {before.min():.0f} to {before.max():.0f} % of the peak"
    assert f"{fall} to {after.min():.1f} to {after.max():.0f} % in all five" in PAGE
    real = cohort[cohort["geometry"] == "real"]
    assert (real["verdict"] == "none").all()
    assert "On the real geometry all ten groups are `none`" in PAGE
    known = (
        pd.read_csv(DOCS / "data/reproduction/recovery.csv").groupby("group")["mu_true_pa"].first()
    )
    axial = (
        real[real["group"].str.startswith("TC")].set_index("group")["mu_before_pa"].astype(float)
    )
    off = 100.0 * (axial / known[axial.index] - 1.0)
    assert f"are {off.min():+.1f} to {off.max():+.1f} % off" in PAGE
