"""Summary of the verdicts on measured sets: columns, and errors of the declared folds only."""

import json

import numpy as np
import pandas as pd
import pytest

from softsample.io import read_table, write_table
from softsample.measured.misfits import TRAVELS, misfit_table
from softsample.measured.summary import about_table, main, source_table
from softsample.report.measured import SUMMARY, overview_table, summary_table


def errors(**percent):
    return {name: {"rms_N": 0.1, "rms_percent": value} for name, value in percent.items()}


def verdict(name="explained", effects=()):
    return {
        "verdict": name,
        "effects": [{"name": c[0], "class": c} for c in effects],
        "elastic_law": {"name": "ogden1", "parameters": {}},
        "rule": "leave out: mode",
        "held_out_before": {
            "leave_out_shear": errors(a=3.0, b=4.0),
            "leave_out_tension": errors(c=0.0, d=5.0),
            "last_part": errors(a=1000.0),
        },
        "held_out_after": {"held_out": errors(a=2.0)},
        "error_before": {
            "a": {"all": {"rms_percent": 6.0}, "ramp": {"rms_percent": 99.0}},
            "b": {"all": {"rms_percent": 8.0}},
        },
        "error_after": {},
    }


def test_misfits_are_what_a_verdict_leaves_on_the_way_to_what_is_fitted(tmp_path):
    """Of a compression and its return, whose end is held out: a bow of 2 % of the peak."""
    way = np.concatenate([np.linspace(0.0, 1.0, 101), np.linspace(0.99, 0.0, 100)])
    bow = np.where(np.arange(201) <= 100, np.sin(np.pi * way / 0.8), 5.0)
    record = pd.DataFrame({
        "sample": "a", "mode": "compression", "channel": "force", "displacement_mm": -2.0 * way,
        "force_N": -way, "after_N": -way - 0.02 * bow, "held_out": way > 0.8,
    })  # fmt: skip
    write_table(tmp_path / "set/loop/one/residual.csv", record)
    write_table(tmp_path / "set/loop/two/residual.csv", record.iloc[:19])
    (row,) = misfit_table(tmp_path).to_dict("records")
    assert (row["study"], row["group"], row["sample"]) == ("set", "one", "a")
    assert row["rms_percent"] == pytest.approx(2.0 / np.sqrt(2.0), rel=0.02)
    found = [row[f"{x:g}"] for x in TRAVELS]
    np.testing.assert_allclose(found, np.sqrt(2.0) * np.sin(np.pi * TRAVELS), atol=0.03)


def test_summary_has_the_agreed_columns_and_a_row_a_group():
    found = [
        ("gels", "one", verdict(effects=[["late_contact", "slack"], ["gain"]])),
        ("gels", "two", None),
    ]
    table = summary_table(found)
    assert tuple(table.columns) == SUMMARY
    first, second = table.to_dict("records")
    assert (first["set"], first["group"], first["law"]) == ("gels", "one", "ogden1")
    assert first["effects"] == "late_contact|slack; gain"
    assert first["rule"] == "leave out: mode"
    # the fold that is not declared does not count: (9 + 16 + 0 + 25) / 4
    assert first["held_out_before_percent"] == pytest.approx(np.sqrt(12.5))
    assert first["held_out_after_percent"] == pytest.approx(2.0)
    assert first["fitted_before_percent"] == pytest.approx(np.sqrt(50.0))
    assert np.isnan(first["fitted_after_percent"])
    assert second["verdict"] == "failed"
    assert np.isnan(second["held_out_before_percent"])


def test_a_study_without_held_out_parts_or_law_has_empty_cells():
    bare = {**verdict("none"), "held_out_before": None, "held_out_after": None, "elastic_law": None}
    (row,) = summary_table([("s", "g", bare)]).to_dict("records")
    assert row["law"] == ""
    assert np.isnan(row["held_out_before_percent"])


def test_overview_counts_verdicts_and_takes_medians():
    table = pd.DataFrame(
        {
            "set": ["s", "s", "s", "t"],
            "rule": ["", "r", "r", "q"],
            "verdict": ["failed", "none", "none", "unknown"],
            "effects": ["", "slack|gain; tilt", "tilt", ""],
            "held_out_before_percent": [np.nan, 2.0, 4.0, 9.0],
            "held_out_after_percent": [np.nan, 1.0, 2.0, 9.0],
        }
    )
    first, second = overview_table(table).to_dict("records")
    assert (first["rule"], first["groups"], first["verdicts"]) == ("r", 3, "2 none, 1 failed")
    assert (first["held_out_before_percent"], first["held_out_after_percent"]) == (3.0, 1.5)
    assert first["found"] == "2 tilt, 1 slack"
    assert (second["set"], second["found"]) == ("t", "")


def test_every_study_has_its_paragraph_and_every_set_its_source():
    about = about_table()
    named = ", ".join(about["studies"]).split(", ")
    assert "ventricular-myocardium" in named
    assert "brain-budday" in named
    assert about["about"].is_unique
    catalogue = pd.DataFrame(
        {"set": ["a", "a", "b"], "file": ["1", "2", "3"], "source": "s", "licence": "l"}
    )
    assert source_table(catalogue)["files"].tolist() == [2, 1]


def test_summary_and_page_are_written_and_a_failed_group_is_in_them(tmp_path):
    name = "muscle-compression-rate"
    study = tmp_path / "studies" / name
    study.mkdir(parents=True)
    (study / "samples.tsv").write_text("sample\tgroup\na\talong\nb\talong\nc\tacross\n")
    found = tmp_path / name / "loop/along/verdict.json"
    found.parent.mkdir(parents=True)
    found.write_text(json.dumps(verdict("none")))
    assert main([str(tmp_path)]) == 0
    table = read_table(tmp_path / "summary.csv")
    assert table["group"].tolist() == ["along", "across"]
    assert table["verdict"].tolist() == ["none", "failed"]
    page = (tmp_path / "docs/measured.md").read_text()
    assert "-rate` | leave out: mode | 2 | 1 none, 1 failed | – | 3.5 | 2.0 |" in page
    assert (tmp_path / "docs/figures/measured/held_out.png").stat().st_size > 1000
    assert "Porcine skeletal muscle" in (tmp_path / "report.html").read_text()


def test_a_summary_of_failures_alone_is_written(tmp_path):
    study = tmp_path / "studies/brain-budday"
    study.mkdir(parents=True)
    (study / "samples.tsv").write_text("sample\tgroup\na\tCX\n")
    assert main([str(tmp_path)]) == 0
    assert read_table(tmp_path / "summary.csv")["verdict"].tolist() == ["failed"]
    assert "| 1 | 1 failed | – | – | – |" in (tmp_path / "docs/measured.md").read_text()
