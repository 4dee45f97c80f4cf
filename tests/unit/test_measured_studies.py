"""Study folders of measured sets: table, records and settings; written once and reproducibly."""

import os
from dataclasses import fields

import pandas as pd
import pytest
import yaml

from softsample.holdout import Selection
from softsample.io import read_samples, read_yaml
from softsample.measured.__main__ import main
from softsample.measured.folder import (
    COLUMNS,
    STUDIES,
    chosen_studies,
    sample_table,
    within,
    write_study,
)
from softsample.measured.readers import READERS
from softsample.measured.sample import Sample, cuboid, cylinder, record
from softsample.study import ROOT
from softsample.validation import overlaid, refusals

HELD_OUT = {"hold_out", "leave_out"}
SELECTIONS = {field.name for field in fields(Selection)}


def samples():
    shear = record([-1.0, 0.0, 1.0], [-0.1, 0.0, 0.1], force_normal_N=[0.1, 0.0, 0.1])
    press = record([0.0, -0.5, -2.0, -0.5], [0.0, -1.0, -3.0, -0.9], time_s=[0.0, 1.0, 4.0, 7.0])
    return [
        Sample("a_1", "a", "shear", cuboid(3.0, 4.0, 5.0), shear),
        Sample("b_1", "b", "compression", cylinder(8.0, 2.5 - 0.55), press, "B", "first"),
    ]


STUDY = {"ends": "sliding", "settings": {"hold_out": [{"strain_above": 0.3}]}}


def test_table_has_the_columns_of_a_study(tmp_path):
    write_study(tmp_path / "s", samples(), STUDY)
    table = read_samples(tmp_path / "s/samples.tsv")
    assert tuple(table.columns) == COLUMNS
    first, second = table.to_dict("records")
    assert (first["shape"], first["width_mm"], first["diameter_mm"]) == ("cuboid", "4", "")
    assert (first["specimen"], first["cycle"], first["ends"]) == ("a_1", "", "sliding")
    assert (second["shape"], second["height_mm"], second["length_mm"]) == ("cylinder", "1.95", "")
    assert (second["specimen"], second["cycle"]) == ("B", "first")
    assert read_yaml(tmp_path / "s/study.yaml") == STUDY["settings"]


def test_records_hold_only_what_was_measured(tmp_path):
    write_study(tmp_path, samples(), STUDY)
    shear, press = (pd.read_csv(tmp_path / f"records/{name}.csv") for name in ("a_1", "b_1"))
    assert list(shear) == ["displacement_mm", "force_N", "force_normal_N"]
    assert list(press) == ["time_s", "displacement_mm", "force_N"]
    pd.testing.assert_frame_equal(press, samples()[1].record, check_dtype=False)


def test_unchanged_files_are_left_alone_and_changed_ones_are_not(tmp_path):
    write_study(tmp_path, samples(), STUDY)
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    before = {path: path.read_bytes() for path in files}
    for path in files:
        os.utime(path, (1.0, 1.0))
    write_study(tmp_path, samples(), STUDY)
    assert {path: path.read_bytes() for path in files} == before
    assert {path.stat().st_mtime for path in files} == {1.0}
    write_study(tmp_path, samples(), {**STUDY, "ends": "bonded"})
    changed = {path.name for path in files if path.stat().st_mtime != 1.0}
    assert changed == {"samples.tsv"}


def test_rows_beyond_a_strain_are_left_out_on_both_ways():
    _, cut = within(samples(), 0.5)
    assert cut.record["time_s"].tolist() == [0.0, 1.0, 7.0]
    assert within(samples(), None)[1].record is not None
    assert len(within(samples(), None)[1].record) == 4


def test_studies_are_chosen_by_their_name_or_their_set():
    assert list(chosen_studies(["brain-budday"])) == ["brain-budday"]
    assert list(chosen_studies(["muscle-compression"])) == [
        "muscle-compression-rate",
        "muscle-compression-magnitude",
    ]
    assert {study["reader"] for study in chosen_studies().values()} == set(READERS)


def test_a_wrong_name_or_root_is_one_message(tmp_path, capsys):
    assert main([str(tmp_path), str(tmp_path / "out"), "brains"]) == 1
    assert "no measured study or set brains" in capsys.readouterr().err
    assert main([str(tmp_path / "nowhere"), str(tmp_path / "out"), "brain-budday"]) == 1
    assert f"the measured data are not in {tmp_path / 'nowhere'}" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", read_yaml(STUDIES)["studies"])
def test_settings_of_a_study_follow_the_schema(name):
    study = read_yaml(STUDIES)["studies"][name]
    assert set(study) <= {"reader", "ends", "strain_max", "settings"}
    assert study["ends"] in ("bonded", "sliding", "unknown")
    settings = study["settings"]
    assert HELD_OUT & set(settings)
    if set(settings) >= HELD_OUT:
        assert settings["leave_out"] == "group"
    for selection in settings.get("hold_out", []):
        assert set(selection) <= SELECTIONS
    assert settings.get("leave_out", "sample") in ("group", "specimen", "mode", "sample")
    config = yaml.safe_load((ROOT / "config/config.yaml").read_text(encoding="utf-8"))
    schema = read_yaml(ROOT / "workflow/schemas/config.schema.yaml")
    known = {key: value for key, value in settings.items() if key in schema["properties"]}
    assert set(settings) - set(known) <= HELD_OUT
    assert list(refusals(overlaid(config, known), schema)) == []


def test_a_table_without_samples_has_its_columns():
    assert list(sample_table([], "bonded")) == list(COLUMNS)
