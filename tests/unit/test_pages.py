"""Pages of results in docs/: rendered from committed tables, nothing typed, nothing stale."""

import re
from pathlib import Path

import pandas as pd
import pytest
from jinja2 import UndefinedError
from reference import assumptions

from softsample.files import sha256
from softsample.io import read_json, read_table
from softsample.report.page import fixed, mean, render_page, signed

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
DATA, FIGURES = DOCS / "data/reproduction", DOCS / "figures/reproduction"
OF_RUNS = ROOT / "workflow/report/verdict.md.j2"
"""Template of pages that a study writes; docs/ has none of them."""
TEMPLATES = sorted({*(ROOT / "workflow/report").glob("*.md.j2")} - {OF_RUNS})
PAGES = [template.name.removesuffix(".j2") for template in TEMPLATES]
OURS = ROOT / "results"


def tables(page="reproduction.md"):
    folder = DOCS / "data/measured" if page == "measured.md" else DATA
    return {path.stem: read_table(path) for path in sorted(folder.glob("*.csv"))}


@pytest.mark.parametrize("page", PAGES)
def test_a_page_is_what_its_template_makes_of_its_tables(page):
    template = ROOT / "workflow/report" / f"{page}.j2"
    written = (DOCS / page).read_text(encoding="utf-8")
    assert render_page(template, tables(page)) == written, "run make docs, or make measured-docs"


def test_tables_and_figures_are_those_that_the_study_wrote():
    sums = read_table(DATA / "SHA256.csv")
    there = {path.name: path for folder in (DATA, FIGURES) for path in folder.iterdir()}
    del there["SHA256.csv"]
    assert dict(zip(sums["file"], sums["sha256"], strict=True)) == {
        name: sha256(path) for name, path in there.items()
    }


def test_the_readme_has_the_results_of_the_tables():
    text = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    rows = tables()
    summary = rows["summary"].set_index(["quantity", "mode"]).loc["modulus_two_term"]
    biases = [
        f"{fixed(row['mean_percent'])} % ({fixed(row['sd_percent'])}; "
        f"{fixed(row['paper_mean_percent'])})"
        for row in (summary.loc["shear"], summary.loc["tension+compression"])
    ]
    assert f"(SD; paper) | {' | '.join(biases)} |" in text
    errors = rows["recovery"].groupby("group")["error_percent"].first()
    axial = errors.index.str.startswith("TC")
    ranges = [
        f"{signed(part.min())} to {signed(part.max())} %"
        for part in (errors[~axial], errors[axial])
    ]
    assert f"error | {' | '.join(ranges)} |" in text
    loop = rows["loop"].assign(axial=rows["loop"]["group"].str.startswith("TC"))
    for geometry, named in (("real", ("none", "none")), ("ideal", ("none", "real_geometry"))):
        cells = []
        for axial, name in zip((False, True), named, strict=True):
            part = loop[(loop["geometry"] == geometry) & (loop["axial"] == axial)]
            right = part["classes"].fillna(part["verdict"]) == name
            cells.append(f"{right.sum()} of {len(part)} `{name}`")
        assert f" | {' | '.join(cells)} |" in text
    claims = rows["claims"]
    count = claims["verdict"].value_counts()
    built = (claims["by_construction"] & (claims["verdict"] == "reproduced")).sum()
    assert (
        f"paper's {len(claims)} [claims](docs/reproduction.md), {count['reproduced']} are "
        f"reproduced ({built} by construction of the samples), {count['differs']} differ and "
        f"{count['not testable']} are not testable"
    ) in text
    blind = read_json(DOCS / "data/blind/score.json")["score"]
    (covered,) = [
        row["value"]
        for row in blind
        if (row["goal"], row["floor_percent"]) == ("13 cover of effects", 0.0)
    ]
    assert f"[{100.0 * covered:.0f} % of the cases](docs/blindlab.md#score)" in text
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) < 150


@pytest.mark.parametrize("page", PAGES)
def test_all_pictures_and_links_of_a_page_are_there(page):
    text = (DOCS / page).read_text(encoding="utf-8")
    links = re.findall(r"\]\(([^)#]+)\)", text)
    assert links
    assert not [link for link in links if not (DOCS / link).exists()]


@pytest.mark.parametrize("template", TEMPLATES, ids=lambda path: path.name)
def test_no_result_is_typed_into_a_template(template):
    """Outside of Jinja's braces: no decimals, percentages or lengths but the truth's elements."""
    text = re.sub(r"{{.*?}}|{%.*?%}", "", template.read_text(encoding="utf-8"), flags=re.DOTALL)
    text = re.sub(r"section 3\.1|(hexahedra|elements) of 1 mm|to [25] % up to", "", text)
    assert re.findall(r"\d+\.\d+|\d+ ?%|\d+ mm", text) == []


@pytest.mark.skipif(not (OURS / "scoring/recovery.csv").is_file(), reason="no study was run here")
def test_the_tables_are_those_of_the_study_that_was_run_here():
    """A newer study than the page: run make docs. What the jobs cost differs from run to run."""
    for path in sorted(set(DATA.glob("*.csv")) - {DATA / "costs.csv"}):
        for folder in ("tables", "scoring"):
            source = OURS / folder / path.name
            if source.is_file():
                pd.testing.assert_frame_equal(read_table(path), read_table(source), rtol=1e-6)


def test_numbers_have_a_true_minus_and_no_minus_zero():
    assert fixed(-1.25, 1) == "−1.2"
    assert signed(3.14159, 2) == "+3.14"
    assert signed(-0.04, 1) == "0.0"
    assert fixed(float("nan")) == "–"
    assert mean([{"a": 1.0}, {"a": float("nan")}, {"a": 3.0}], "a") == 2.0


def test_a_template_that_asks_for_what_is_not_there_is_refused(tmp_path):
    template = tmp_path / "page.md.j2"
    template.write_text("{% for row in table %}{{ row.mu | fixed }} {% endfor %}{{ other }}")
    with pytest.raises(UndefinedError, match="'other' is undefined"):
        render_page(template, {"table": pd.DataFrame({"mu": [1.0, 2.5]})})
    template.write_text("{% for row in table %}{{ row.mu | fixed }} {% endfor %}")
    assert render_page(template, {"table": pd.DataFrame({"mu": [1.0, 2.5]})}) == "1.0 2.5 "


def test_every_assumption_is_listed():
    listed = list(assumptions(ROOT / "src"))
    marks = sum(
        line.count("# ASSUME: ")
        for path in (ROOT / "src").rglob("*.py")
        for line in path.read_text().splitlines()
    )
    assert len([line for line in listed if line.startswith("| `")]) == marks >= 10
    (two_lines,) = [line for line in listed if "videos" in line]
    assert "`bond: rule: contact` simulates it" in two_lines
    assert "#" not in two_lines
