"""Which files a study reads and makes, for a group of every kind."""

import pytest

from softsample.errors import InputError
from softsample.study.files import RESULTS, Files
from softsample.study.plan import Plan

CUBOID = {"shape": "cuboid", "length_mm": "20", "width_mm": "18", "height_mm": "12"}


def study(folder="lab"):
    """A group with images, one of dimensions with two records of a piece, one of open ends."""
    rows = {
        "T1": {"group": "TC1", "mode": "tension", "image": "t1.nii"},
        "C1": {"group": "TC1", "mode": "compression", "image": "../c1.nii"},
        "A1": {"group": "A", "mode": "compression", "ends": "sliding", **CUBOID},
        "A2": {"group": "A", "mode": "compression", "ends": "sliding", **CUBOID},
        "U": {"group": "U", "mode": "compression", "ends": "unknown", **CUBOID},
    }
    return Files(Plan({name: {**row, "sample": name} for name, row in rows.items()}), folder)


def below(names):
    return [name.removeprefix(RESULTS) for name in names]


def test_named_files_are_beside_the_table():
    files = study()
    assert files.given("image", "T1") == "lab/t1.nii"
    assert files.given("image", "C1") == "c1.nii"
    assert files.given("image", "A1") == files.given("bond_mask", "T1") == []
    assert study("").given("image", "T1") == "t1.nii"


def test_a_missing_file_is_told_and_no_input(tmp_path):
    (tmp_path / "t1.nii").touch()
    files = study(tmp_path / "lab")
    assert files.missing("A1") == {}
    assert files.missing("T1") == {"image": str(tmp_path / "lab/t1.nii")}
    assert files.missing("T1", ["record"]) == {}
    assert files.there("image", "T1") == files.image("image", "T1") == []
    assert study(tmp_path).missing("T1") == {}
    assert study(tmp_path).there("image", "T1") == str(tmp_path / "t1.nii")


def test_an_image_is_its_files_for_the_real_geometry(tmp_path):
    folder = tmp_path / "t1.nii"
    folder.mkdir()
    (folder / "a.dcm").touch()
    files = study(tmp_path)
    assert files.image("image", "T1") == [str(folder), str(folder / "a.dcm")]
    assert files.image("image", "T1", "ideal") == files.image("labels", "T1") == []


def test_only_what_was_imaged_is_segmented_and_has_a_real_geometry():
    files = study()
    assert files.segmentation(".json", "T1") == "<results>/segmentation/T1.json"
    assert files.for_geometry(".json", "T1", "real") == "<results>/segmentation/T1.json"
    assert files.segmentation(".json", "A1") == files.for_geometry(".json", "A1", "ideal") == []
    with pytest.raises(InputError, match="'A1' are stated in the table: it has no real geometry"):
        files.for_geometry(".json", "A1", "real")


def test_a_uniform_field_needs_no_mesh_to_run_on():
    files = study()
    assert files.mesh_of_runs("_coarse", None, "U", "ideal") == "<results>/mesh/U/ideal_coarse.vtu"
    assert files.mesh_of_runs("", "sliding", "U", "ideal") == []
    assert files.mesh_of_runs("", None, "A1", "ideal") == []


def test_a_pattern_is_filled_for_each_sample():
    files = study()
    asked = files.each("{sample} {piece} {geometry}{ends} {model}", ["C1", "A2", "U"], model="m")
    assert asked == ["C1 C1 real m", "A2 A1 ideal m", "U U ideal_sliding m"]
    assert files.each("{geometry} {sample}", ["C1"], geometry="ideal", sample="x") == ["ideal C1"]


def test_calibrations_are_those_of_the_group_on_each_geometry_with_each_model():
    files = study()
    assert files.calibration("csv", "A2", "ideal") == "<results>/calibration/A/ideal/ogden2.csv"
    assert files.calibration_of_group("TC1") == "<results>/calibration/TC1/real/ogden2.json"
    assert files.calibration_of_group("TC1", "ideal").endswith("TC1/ideal/ogden2.json")
    assert [name.split("/")[2] for name in files.fitted_curves("T1")] == ["TC1", "TC1"]
    assert len(files.calibrations(["TC1", "A"])) == 4 + 2
    assert files.fitted_groups("ogden1") == {"real": ["TC1"], "ideal": ["TC1", "A", "U"]}
    assert files.fits("ogden1", "json")["real"] == ["<results>/calibration/TC1/real/ogden1.json"]
    assert below(files.curve_reports("T1", "real")) == ["curves/T1/real/ogden2.json"]
    assert len(files.curve_reports("C1", "real")) == 2


def test_verdicts_are_of_each_group_and_of_its_ideal_shape_beside_the_real_one():
    files = study()
    assert list(files.verdicts) == [
        ("TC1", "real"), ("A", "ideal"), ("U", "ideal"), ("TC1", "ideal")
    ]  # fmt: skip
    assert files.verdicts["TC1", "ideal"] == "<results>/loop/TC1/ideal/verdict.json"
    assert files.open_ends_verdicts("U") == files.told("A") == []


def test_a_target_of_a_sample_builds_its_group():
    found = below(study().of_sample("T1"))
    assert {name.split("/")[0] for name in found} == {
        "calibration", "fields", "checks", "sensitivity"
    }  # fmt: skip
    assert "fields/C1/ideal.vtu" in found
    assert not [name for name in found if "A1" in name]
    assert "export/A2/ideal.feb" in below(study().exports("A2"))


def test_tables_and_figures_are_those_that_the_samples_can_fill():
    files = study()
    assert {"tables/table2.csv", "tables/bond.csv", "tables/contact.csv"} <= {*below(files.tables)}
    assert {"figures/figure2.pdf", "figures/figure6.png"} <= {*below(files.figures)}
    sheared = Files(Plan({"D": {"group": "D", "mode": "shear", **CUBOID}}))
    assert not {"tables/table2.csv", "tables/bond.csv", "tables/band.csv", "tables/contact.csv"} & {
        *below(sheared.tables)
    }
    assert not [name for name in sheared.figures if "figure2" in name or "figure6" in name]
    assert below(files.pictures)[:2] == ["figures/samples/T1.png", "figures/samples/C1.png"]
    assert "tables/prescribed.csv" in below(files.geometry_effects)
    assert not [name for name in sheared.geometry_effects if "prescribed" in name]
    assert len(files.checks) == 2 * 2 + 2 + 3


def finish(files, results, group):
    for name in below(files.reported(group)):
        (results / name).parent.mkdir(parents=True, exist_ok=True)
        (results / name).touch()


def test_a_group_is_finished_when_all_is_there_and_no_job_of_it_failed_since(tmp_path):
    files = study()
    assert not files.finished(tmp_path, [])
    for group in ("TC1", "A"):
        finish(files, tmp_path, group)
    assert list(files.finished(tmp_path, [])) == ["T1", "C1", "A1", "A2"]
    for job, left in (
        ("export/T1_real", 4), ("segment/T1", 2), ("diagnose/A_ideal", 2), ("measure/T1x", 4),
    ):  # fmt: skip
        assert len(files.finished(tmp_path, [(job, "why")])) == left, job
    (tmp_path / "bond/moduli/TC1.json").unlink()
    assert list(files.finished(tmp_path, [])) == ["A1", "A2"]
    failed = [("mesh/A1_real", "why")]
    assert {*files.plan.rows} - {*files.finished(tmp_path, failed, False)} == {"A1", "A2"}
