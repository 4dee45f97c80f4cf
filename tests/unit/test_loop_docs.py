"""docs/loop.md tells of undeclared records and cohort what the committed tables say."""

from pathlib import Path

import pandas as pd
import pytest

DOCS = Path(__file__).parents[2] / "docs"
LINES = (DOCS / "loop.md").read_text(encoding="utf-8").splitlines()
PAGE = " ".join(" ".join(LINES).split())
WHEN = ("before", "after")
DATA = DOCS / "data/undeclared"
SCORE = pd.read_csv(DATA / "after_changes_score.csv", keep_default_na=False)
LOOP = pd.read_csv(DATA / "after_changes_loop.csv", keep_default_na=False)
COHORT = pd.read_csv(DOCS / "data/reproduction/loop.csv", keep_default_na=False)
IDEAL = {
    "undeclared": LOOP[LOOP["geometry"] == "ideal"],
    "cohort": COHORT[(COHORT["geometry"] == "ideal") & COHORT["group"].str.startswith("TC")],
}


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
    removed = "held_out_removed_percent"
    assert f"median of all nine falls by {with_effect[removed].median():.0f} %" in PAGE
    assert f"{SCORE['right'].sum()} of {len(SCORE)} are right" in PAGE


@pytest.mark.parametrize("name", IDEAL)
def test_held_out_errors_of_the_ideal_shape_are_those_of_the_table(name):
    """Written numbers, to half a unit of their last digit, of the table's lowest and highest."""
    (line,) = (line for line in LINES if line.startswith(f"| {name}, "))
    groups, *cells = (cell.split() for cell in line.strip("| ").split("|"))
    assert int(groups[-1]) == len(IDEAL[name])
    columns = [f"held_out_{of}{when}_percent" for of in ("", "worst_") for when in WHEN]
    for (low, _, high), column in zip(cells, columns, strict=True):
        errors = IDEAL[name][column].astype(float)
        for written, value in ((low, errors.min()), (high, errors.max())):
            unit = 10.0 ** -len(written.partition(".")[2])
            assert abs(float(written) - value) <= 0.5 * unit + 1e-9


def test_every_group_that_got_worse_in_its_worst_fold_is_named():
    found = pd.concat(IDEAL.values())
    worst = [found[f"held_out_worst_{when}_percent"].astype(float) for when in WHEN]
    named = {name for name in found["group"] if f"In {name} one fold got worse" in PAGE}
    assert named == set(found["group"][worst[1] > worst[0]])


def test_real_geometry_is_named_in_as_many_groups_as_the_page_says():
    (undeclared, n), (cohort, m) = (
        (rows["classes"].str.contains("real_geometry").sum(), len(rows)) for rows in IDEAL.values()
    )
    assert f"is named in {undeclared} of the {n} groups" in PAGE
    assert f"alone in its class, in {cohort} of the {m} groups" in PAGE
    alone = IDEAL["cohort"]["classes"].str.split("; ").map(lambda of: "real_geometry" in of)
    assert alone.all()


def test_second_effects_and_moduli_of_the_cuboid_are_those_of_the_table():
    by = {kind: rows.set_index("group") for kind, rows in LOOP.groupby("geometry")}
    named = []
    for row in SCORE[SCORE["truth"] != ""].itertuples():
        classes = [of.split("|") for of in by["ideal"].loc[row.group, "classes"].split("; ")]
        beside = [effect for of in classes if "real_geometry" not in of for effect in of]
        named.append(set(row.truth.split("; ")) <= set(beside))
    assert f"the second effect or its class in {sum(named)} of {len(named)}" in PAGE
    ratio = by["ideal"]["mu_after_pa"].astype(float) / by["real"]["mu_after_pa"].astype(float)
    assert f"within {100.0 * (ratio - 1.0).abs().max():.1f} % of those on the real" in PAGE


def test_the_cohort_is_that_of_its_tables():
    real = COHORT[COHORT["geometry"] == "real"]
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
