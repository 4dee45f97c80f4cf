"""A study folder of one's own: made, filled, and checked as a whole."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import nibabel
import numpy as np
import openpyxl
import pytest
from snakemake.cli import parse_config

import machines
from softsample.__main__ import _joined, command_line, main
from softsample.errors import InputError
from softsample.io import read_samples, write_surface
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.cylinder import mesh_cylinder
from softsample.meshing.surface import TriangleSurface
from softsample.study import run
from softsample.study.check import check_study, each_cure_once
from softsample.study.folder import add_sample

ROOT = Path(__file__).resolve().parents[2]
AFFINE = np.diag([0.4, 0.4, 0.4, 1.0])


def image(path, shape=(40, 40, 30), affine=AFFINE):
    """A bright block of 9.6 x 8 x 8 mm, if voxels have 0.4 mm, on a dark platen."""
    values = np.random.default_rng(0).integers(0, 20, shape).astype(np.int16)
    values[8:32, 10:30, 6:26] += 300
    nibabel.save(nibabel.Nifti1Image(values, affine), path)
    return path


@pytest.fixture
def study(tmp_path):
    """A study as `new` makes it, in a folder with a space and a letter beyond ASCII."""
    folder = tmp_path / "Größe 1"
    assert main(["new", str(folder)]) == 0
    return folder


def add(study, name="C7", mode="compression", record=None):
    """Exit status of `add` with a made-up image and a record of a machine."""
    elsewhere = study.parent / "from the scanner"
    elsewhere.mkdir(exist_ok=True)
    picture = image(elsewhere / f"{name}.nii.gz")
    test = machines.write(elsewhere / f"{name}.csv", record or default_record())
    arguments = ["--mode", mode, "--image", str(picture), "--record", str(test)]
    return main(["add", str(study), *arguments])


def default_record():
    return machines.univert(*machines.compression())


@pytest.mark.parametrize("joined", [False, True])
def test_an_axis_that_begins_with_a_dash_is_a_value(study, joined):
    axis = ["--loading-axis=-z"] if joined else ["--loading-axis", "-z"]
    given = ["--sample", "D1", "--mode", "compression", "--record", "a.csv", *axis]
    seen = command_line().parse_args(_joined(["add", str(study), *given]))
    assert seen.loading_axis == "-z"


def test_a_new_study_is_sound_and_names_the_next_command(tmp_path, capsys):
    study = tmp_path / "lab"
    main(["new", str(study)])
    assert f"make check-study DIR={study}" in capsys.readouterr().out
    assert main(["check", str(study)]) == 0
    told = capsys.readouterr().out
    assert "samples: 1" in told
    assert "make study DIR=" in told
    comments = [c for c in (study / "samples.tsv").read_text().splitlines() if c.startswith("#")]
    for column in ("sample", "group", "mode", "image", "record"):
        assert any(comment.startswith(f"# {column} ") for comment in comments)


def test_a_study_is_not_overwritten(study, capsys):
    before = (study / "samples.tsv").read_text()
    assert main(["new", str(study)]) == 1
    assert "is there already" in capsys.readouterr().err
    assert (study / "samples.tsv").read_text() == before


def test_an_added_sample_takes_the_place_of_the_worked_one(study):
    assert add(study) == 0
    assert add(study, "T7") == 0
    rows = [r for r in (study / "samples.tsv").read_text().splitlines() if r and r[0] != "#"]
    assert rows[1:] == [
        "C7\tC7\tcompression\tC7.nii.gz\tC7.csv",
        "T7\tT7\tcompression\tT7.nii.gz\tT7.csv",
    ]
    result = check_study(study)
    assert result.faults == []
    assert len(result.seen) == 2


def test_a_folder_of_slices_is_added_as_the_table_wants_it(study):
    """Its name has dots as a rule, and would be taken for a file's ending."""
    slices = study.parent / "1.2.840.113619"
    slices.mkdir()
    (slices / "1.dcm").touch()
    arguments = [
        "--mode",
        "tension",
        "--image",
        str(slices),
        "--record",
        str(study.parent / "R.csv"),
    ]
    (study.parent / "R.csv").touch()
    assert main(["add", str(study), *arguments, "--sample", "D1"]) == 0
    assert "D1\tD1\ttension\t1.2.840.113619/\tR.csv" in (study / "samples.tsv").read_text()
    assert not [fault for fault in check_study(study).faults if "another form" in fault]


def test_an_added_sample_overwrites_nothing(study, capsys):
    assert add(study) == 0
    kept = (study / "C7.csv").read_bytes()
    assert add(study, record="other") == 1
    assert "'C7' stands in row" in capsys.readouterr().err
    elsewhere = study.parent / "from the scanner"
    (elsewhere / "C7.nii.gz").write_bytes(b"of another piece")
    again = ["--mode", "compression", "--image", str(elsewhere / "C7.nii.gz"), "--sample", "D7"]
    assert main(["add", str(study), *again, "--record", str(elsewhere / "C7.csv")]) == 1
    assert "C7.nii.gz is there already" in capsys.readouterr().err
    assert (study / "C7.csv").read_bytes() == kept
    assert main(["add", str(study), "--mode", "shear", "--image", "no", "--record", "no"]) == 1
    assert "no: no such image; correct its path" in capsys.readouterr().err


def test_a_piece_that_is_tested_again_has_its_image_already(study):
    """The same image from elsewhere is no other one; its tests are named by their records."""
    assert add(study) == 0
    elsewhere = study.parent / "from the scanner"
    (elsewhere / "C7 again").mkdir()
    image = shutil.copy(elsewhere / "C7.nii.gz", elsewhere / "C7 again")
    record = shutil.copy(elsewhere / "C7.csv", elsewhere / "C7 again" / "E7.csv")
    again = ["--mode", "shear", "--image", str(image), "--record", str(record), "--specimen", "C7"]
    assert main(["add", str(study), *again]) == 0
    row = (study / "samples.tsv").read_text().splitlines()[-1].split("\t")
    assert row[:6] == ["E7", "C7", "shear", "C7.nii.gz", "E7.csv", "C7"]


def test_units_signs_and_zero_are_told(study, capsys):
    time_s, travel, force = machines.compression()
    add(study, record=machines.bluehill(time_s, -travel - 0.5, -force - 0.125))
    settings = study / "study.yaml"
    text = settings.read_text().replace("tension, force: tension", "loading, force: compression")
    settings.write_text(text.replace("file, force: file", "file, force: rest"))
    capsys.readouterr()
    assert main(["check", str(study)]) == 0
    told = capsys.readouterr().out
    assert "Instron Bluehill" in told
    assert "force_N from 'Load' in kN, times 1000" in told
    assert (
        "displacement_mm: loading is positive in the file; zero is that of the file, and the ramp "
        "begins at 0.5" in told
    )
    assert "force_N: compression is positive in the file; 0.1" in told
    assert "was subtracted, and the force at rest is" in told
    peak = told.split("mm/s to ")[1].split(" N")[0]
    assert float(peak) == pytest.approx(force.min(), abs=2e-3)


def test_everything_that_is_wrong_is_told_at_once(study, capsys):
    add(study)
    add(study, "T8")
    bad = default_record().splitlines()
    bad[60] = bad[60].rsplit(",", 1)[0] + ",?"
    machines.write(study / "T8.csv", "\n".join(bad))
    image(study / "C7.nii.gz", affine=np.diag([400.0, 400.0, 400.0, 1.0]))
    table = study / "samples.tsv"
    table.write_text(table.read_text() + "T8\tg\tpull\tno.nii\tC7.doc\n")
    (study / "study.yaml").write_text("records: {zero: {force: begin}}\nmesh: {size: 1}\n")
    assert main(["check", str(study)]) == 1
    told = capsys.readouterr().err
    line = len(table.read_text().splitlines())
    for fault in (
        "Faults: 8",
        "records.zero.force: 'begin' is not one of file, rest, start",
        "mesh.size: unknown name",
        f"samples.tsv, row {line} (T8), column 'mode': 'pull' is not one of",
        f"row {line} (T8), column 'record': 'C7.doc' has a wrong extension; expected",
        f"row {line} (T8), column 'sample': 'T8' stands in row {line - 1} already",
        f"row {line} (T8): {study}/no.nii: no such image; correct its path",
        f"row {line - 2} (C7): {study}/C7.nii.gz: voxels of 400 x 400 x 400 mm, expected 0.05",
        f"row {line - 1} (T8): {study}/T8.csv, line 61, column 'force_N': '?' is not a number",
    ):
        assert fault in told, fault


def test_masks_and_labels_are_checked_too(study):
    add(study)
    labels = np.zeros((40, 40, 30), dtype=np.int16)
    labels[10:20] = 3
    nibabel.save(nibabel.Nifti1Image(labels, AFFINE), study / "labels.nii")
    away = AFFINE + np.array([[0, 0, 0, 1e3]] * 3 + [[0, 0, 0, 0]])
    nibabel.save(nibabel.Nifti1Image(labels, away), study / "mask.nii")
    table = study / "samples.tsv"
    text = table.read_text().replace("image\trecord\n", "image\trecord\tsegmentation\tlabels\n")
    table.write_text(text.replace("C7.csv\n", "C7.csv\tmask.nii\tlabels.nii\n"))
    faults = "\n".join(check_study(study).faults)
    assert "mask.nii: marks no voxel of the image" in faults
    assert "labels.nii: labels 3 have no stiffness" in faults
    (study / "study.yaml").write_text("material: {region_stiffness: {3: 2.0}}\n")
    assert "stiffness" not in "\n".join(check_study(study).faults)


def add_stated(study, name, *cells, mode="compression", record=None):
    """Exit status of `add` of a sample without an image."""
    test = machines.write(study.parent / f"{name}.csv", record or default_record())
    return main(["add", str(study), "--mode", mode, "--record", str(test), *cells])


def test_a_mask_and_an_axis_are_added_with_the_sample(study):
    mask = image(study.parent / "glue.nii.gz")
    picture, test = study.parent / "M1.nii.gz", study.parent / "M1.csv"
    image(picture)
    machines.write(test, default_record())
    files = ("--image", str(picture), "--record", str(test), "--bond-mask", str(mask))
    assert main(["add", str(study), "--mode", "tension", *files, "--loading-axis=-z"]) == 0
    row = read_samples(study / "samples.tsv").iloc[-1]
    assert row[["sample", "bond_mask", "loading_axis"]].tolist() == ["M1", "glue.nii.gz", "-z"]
    assert (study / "glue.nii.gz").read_bytes() == mask.read_bytes()


def test_files_of_one_name_are_not_added_over_each_other(study, capsys):
    before = sorted(study.iterdir())
    files = {
        "--image": "M1.nii.gz",
        "--segmentation": "a/mask.nii.gz",
        "--bond-mask": "mask.nii.gz",
    }
    (study.parent / "a").mkdir()
    named = [part for name, file in files.items() for part in (name, str(study.parent / file))]
    for number, file in enumerate(files.values()):
        image(study.parent / file, (40 + number, 40, 30))
    test = machines.write(study.parent / "M1.csv", default_record())
    assert main(["add", str(study), "--mode", "tension", "--record", str(test), *named]) == 1
    assert "mask.nii.gz: the file of column" in capsys.readouterr().err
    assert main(["add", str(study), "--mode", "tension", "--record", ""]) == 1
    assert "samples.tsv: a sample needs a record; name its file" in capsys.readouterr().err
    assert sorted(study.iterdir()) == before


def test_a_platen_that_pulls_during_unloading_is_doubted(study):
    """The modelled one releases the sample, unless the settings say that it is bonded."""
    time, travel, force = machines.compression()
    back = (2.0 * time[-1] - time[::-1], travel[::-1])
    for name, pull in (("D1", 0.02), ("D2", 0.2)):
        way = force[::-1] + pull * (1.0 - travel[::-1] / travel.min())
        record = machines.univert(
            np.append(time, back[0][1:]), np.append(travel, back[1][1:]), np.append(force, way[1:])
        )
        assert add_stated(study, name, *ROUND, record=record) == 0
    (doubt,) = (line for line in check_study(study).doubts if "platen pulls" in line)
    pulled = re.search(r"D2.csv: during unloading the platen pulls with (\S+) N", doubt)
    assert pulled
    assert float(pulled[1]) == pytest.approx(0.2, rel=0.05)
    assert "set `contact: {release: false}`" in doubt
    (study / "study.yaml").write_text("contact: {release: false}\n")
    assert "platen pulls" not in "\n".join(check_study(study).doubts)


def test_a_table_may_end_its_titles_with_a_tab(study):
    table = study / "samples.tsv"
    table.write_text(re.sub("(?m)^(sample\t.*)$", "\\1\t", table.read_text()))
    assert add_stated(study, "D1", *ROUND) == 0
    assert check_study(study).faults == []
    assert read_samples(table).iloc[-1][["sample", "diameter_mm"]].tolist() == ["D1", "20"]


def test_selections_pass_over_cells_that_are_wrong(study):
    add_stated(study, "D1", *ROUND)
    table = study / "samples.tsv"
    table.write_text(table.read_text().replace("D1\tD1\t", "D 1\t\t"))
    (study / "study.yaml").write_text("hold_out: [{mode: shear}, {phase: loading}]\n")
    assert "column 'sample': 'D 1'" in "\n".join(check_study(study).faults)


def test_sheets_of_one_workbook_are_tests_of_their_own(study):
    book = openpyxl.Workbook()
    for name in ("First", "Second"):
        sheet = book.create_sheet(name)
        sheet.append(["Time (s)", "Extension (mm)", "Load (N)"])
        for row in zip(*map(np.ndarray.tolist, machines.compression()), strict=True):
            sheet.append(row)
    for name in ("D1.xlsx", "D2.xlsx"):
        book.save(study.parent / name)
        record = ("--record", str(study.parent / name), "--format", "second")
        assert main(["add", str(study), "--mode", "compression", *record, *ROUND]) == 0
    table, settings = study / "samples.tsv", study / "study.yaml"
    table.write_text(table.read_text().replace("D2.xlsx", "D1.xlsx"))
    settings.write_text("formats: {second: {sheet: Second}}\n")
    assert "D1.xlsx stands in the row of D1 already" in "\n".join(check_study(study).doubts)
    head, _, last = table.read_text().strip().rpartition("\n")
    table.write_text(f"{head}\n{last.replace('second', '')}\n")
    assert "stands in the row of D1" not in "\n".join(check_study(study).doubts)


def test_a_cure_is_told_of_a_sample_without_a_sound_name(study):
    time_s, travel, force = machines.compression()
    add_stated(study, "D1", *ROUND, record=machines.univert(time_s, -travel, -force))
    add_stated(study, "D2", *ROUND)
    table = study / "samples.tsv"
    table.write_text(table.read_text().replace("D1\tD1\t", "D 1\tD1\t"))
    faults = "\n".join(check_study(study).faults)
    assert "column 'sample': 'D 1'" in faults
    assert "`formats: {machine: {positive: " in faults


ROUND = ("--shape", "cylinder", "--diameter", "20", "--height", "10")


def test_samples_of_any_shape_are_added_to_one_table(study, capsys):
    """Columns that the table lacks are added, and rows before keep their cells."""
    assert add(study) == 0
    options = ("--ends", "0.3", "--specimen", "P1", "--format", "bose", "--cycle", "last")
    assert add_stated(study, "D1", *ROUND, *options, "--group", "C7") == 0
    edges = ("--shape", "cuboid", "--length", "20", "--width", "21", "--height", "10")
    assert add_stated(study, "D2", *edges, "--sample", "D2b") == 0
    (study / "study.yaml").write_text("formats: {bose: {positive: {force: tension}}}\n")
    rows = {row["sample"]: row for _, row in read_samples(study / "samples.tsv").iterrows()}
    assert rows["C7"]["image"] == "C7.nii.gz"
    assert rows["D1"][["diameter_mm", "ends", "cycle"]].tolist() == ["20", "0.3", "last"]
    assert rows["D2b"][["length_mm", "diameter_mm", "image"]].tolist() == ["20", "", ""]
    capsys.readouterr()
    assert main(["check", str(study)]) == 0
    told = capsys.readouterr().out
    assert "cylinder of diameter 20 mm, height 10 mm: section 314.2 mm2\n    ends 0.3\n" in told
    assert "ends bonded, as the cell is empty (unknown: the diagnosis compares" in told
    assert "nominal strain -20 to 0" in told
    assert "nominal stress -2.8" in told
    assert re.search(r"sample of about 9\.\d+ x [78]\.\d+ x 8(\.\d+)? mm, 6\d\d(\.\d)? mm3", told)
    assert "samples: 3" in told


def test_a_wrong_row_is_not_added(study, capsys):
    before = (study / "samples.tsv").read_text()
    assert add_stated(study, "D1", *ROUND[:4]) == 1
    told = capsys.readouterr().err
    assert "sample D1 is not added to" in told
    assert "column 'height_mm': is missing; a cylinder needs diameter_mm, height_mm" in told
    assert add_stated(study, "D1") == 1
    assert "give an image, a surface, or a shape" in capsys.readouterr().err
    assert (study / "samples.tsv").read_text() == before
    assert not (study / "D1.csv").exists()


def test_a_surface_is_added_and_checked(study, capsys):
    block = mesh_cuboid(20e-3, 20e-3, 10e-3, 5e-3)
    quads = block.boundary_quads
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    write_surface(study.parent / "D3.stl", TriangleSurface(block.points, triangles))
    assert add_stated(study, "D3", "--surface", str(study.parent / "D3.stl")) == 0
    capsys.readouterr()
    assert main(["check", str(study)]) == 0
    assert "triangles, 20 x 20 x 10 mm, 4000 mm3" in capsys.readouterr().out
    turned = block.points[:, [2, 0, 1]] @ np.array([[1, 0, 0], [0, 0.8, 0.6], [0, -0.6, 0.8]])
    write_surface(study / "D3.stl", TriangleSurface(turned, triangles))
    assert "its lowest face is not flat" in "\n".join(check_study(study).faults)
    machines.write(study / "D3.stl", "solid nothing\nendsolid\n")
    assert "not a readable STL file" in "\n".join(check_study(study).faults)


@pytest.mark.parametrize("height", [0.5e-3, 10e-3, 60e-3])
def test_a_round_surface_is_proposed_as_a_cylinder_and_a_square_one_is_not(height, study, capsys):
    for name, mesh in (
        ("round", mesh_cylinder(20e-3, 10e-3, 1e-3)),
        ("square", mesh_cuboid(20e-3, 20e-3, 10e-3, 5e-3)),
    ):
        quads = mesh.boundary_quads
        triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        points = mesh.points * [1.0, 1.0, height / 10e-3]
        write_surface(study.parent / f"{name}.stl", TriangleSurface(points, triangles))
        assert add_stated(study, name, "--surface", str(study.parent / f"{name}.stl")) == 0
    found = {one.row["sample"]: "\n".join(one.found) for one in check_study(study).seen}
    assert "write cylinder into column shape" in found["round"]
    assert "write cylinder into column shape" not in found["square"]


def test_a_file_whose_name_is_no_id_needs_one(study, capsys):
    with pytest.raises(InputError, match=r"cannot be a sample's id.*--sample"):
        add_sample(study, {"record": "größe 1.csv", "mode": "compression"})


def test_paths_of_options_are_those_from_where_one_is(capsys):
    with pytest.raises(SystemExit):
        main(["add", "--help"])
    assert "relative to the table" not in " ".join(capsys.readouterr().out.split())
    assert main(["show", "missing.json"]) == 1
    assert capsys.readouterr().err == "missing.json: no such file; correct its path\n"


def picture(study, name, inside):
    """An image of a bright body of 10 mm height on a dark platen."""
    x, y, z = (0.4 * np.arange(n) - middle for n, middle in ((70, 14), (70, 14), (40, 2)))
    place = np.meshgrid(x, y, z, indexing="ij")
    values = np.where(inside(*place[:2]) & (place[2] > 0.0) & (place[2] < 10.0), 300, 20)
    nibabel.save(nibabel.Nifti1Image(values.astype(np.int16), AFFINE), study / name)


def test_a_round_sample_is_proposed_as_a_cylinder(study):
    add(study)
    for name, inside, looks_round in (
        ("disc", lambda x, y: np.hypot(x, y) < 9.0, True),
        ("square", lambda x, y: np.maximum(abs(x), abs(y)) < 9.0, False),
    ):
        picture(study, "C7.nii.gz", inside)
        told = "\n".join(check_study(study).found)
        assert ("write cylinder into column shape" in told) is looks_round, name
    picture(study, "C7.nii.gz", lambda x, y: np.hypot(x, y) < 9.0)
    table = study / "samples.tsv"
    text = table.read_text().replace("image\trecord\n", "image\trecord\tshape\n")
    table.write_text(text.replace("C7.csv\n", "C7.csv\tcylinder\n"))
    assert "looks round" not in "\n".join(check_study(study).found)


def test_formats_and_selections_are_checked(study):
    add_stated(study, "D1", *ROUND, "--format", "bose")
    line = len((study / "samples.tsv").read_text().splitlines())
    settings = study / "study.yaml"
    settings.write_text("hold_out: [{mode: shear}]\n")
    (fault,) = check_study(study).faults
    assert f"row {line} (D1), column 'format': 'bose' is no block of `formats`" in fault
    blocks = "formats: {bose: {positive: {force: compression, displacement: compression}}}\n"
    settings.write_text(blocks + "hold_out: [{mode: shear}]\n")
    faults = "\n".join(check_study(study).faults)
    assert "hold_out.0: no sample fits it; there are mode: compression" in faults
    assert "D1.csv, line" in faults  # read with the signs of its format
    time_s, travel, force = machines.compression()
    machines.write(study / "D1.csv", machines.univert(time_s, -travel, -force))
    settings.write_text(
        blocks + "hold_out: [{strain_above: 0.01}, {strain_above: 0.9}, {cycle: 7}]"
    )
    checked = check_study(study)
    assert checked.faults == []
    empty = [doubt for doubt in checked.doubts if "selects nothing of any record" in doubt]
    assert [doubt.split(": ")[1] for doubt in empty] == ["hold_out.1", "hold_out.2"]
    assert "{'strain_above': 0.9}" in empty[0]


@pytest.mark.parametrize("part", ["group", "specimen", "mode", "sample"])
def test_parts_that_cannot_be_left_out_are_doubted(study, part):
    add_stated(study, "D1", *ROUND)
    (study / "study.yaml").write_text(f"leave_out: {part}\n")
    said = [doubt for doubt in check_study(study).doubts if "leave_out" in doubt]
    where = "the study" if part == "group" else "each group"
    assert len(said) == 1
    assert f"leave_out: {part} leaves nothing out, as {where} has one {part} only" in said[0]
    group = "D2" if part == "group" else "D1"
    table = study / "samples.tsv"
    row = next(line for line in table.read_text().splitlines() if line.startswith("D1\t"))
    second = row.replace("D1\tD1\tcompression", f"D2\t{group}\ttension", 1)
    table.write_text(f"{table.read_text()}{second}\n")
    assert "leaves nothing out" not in "\n".join(check_study(study).doubts)


@pytest.mark.parametrize("column", ["bond_mask", "labels"])
def test_marks_that_are_no_whole_numbers_are_refused_before_the_run(study, column):
    add(study)
    marks = np.full((40, 40, 30), 0.5, dtype=np.float32)
    nibabel.save(nibabel.Nifti1Image(marks, AFFINE), study / "marks.nii")
    table = study / "samples.tsv"
    text = table.read_text().replace("image\trecord\n", f"image\trecord\t{column}\n")
    text = text.replace("\tcompression\t", "\ttension\t")
    table.write_text(text.replace("C7.csv\n", "C7.csv\tmarks.nii\n"))
    assert "48000 voxels hold no whole number from 0 on" in "\n".join(check_study(study).faults)


@pytest.mark.parametrize(
    "command", [["check"], ["add", "--mode", "shear", "--image", "a", "--record", "b"]]
)
def test_a_folder_without_a_study_says_how_to_make_one(command, tmp_path, capsys):
    assert main([*command, str(tmp_path / "none")]) == 1
    assert "no such table; make a study with: softsample new " in capsys.readouterr().err


@pytest.mark.parametrize("content", ["", "- a\n", "a: [\n", "\0", "records: 3\n"])
def test_settings_of_any_content_are_a_fault_or_nothing(study, content):
    (study / "study.yaml").write_text(content)
    faults = check_study(study).faults
    assert bool(faults) is (content != "")
    assert all("study.yaml" in fault for fault in faults)


@pytest.mark.study
def test_thirty_samples_are_checked_at_once(tmp_path):
    """The cohort twice, as any lab's folder; times depend on the machine and are no test."""
    rows = ["sample\tgroup\tmode\timage\trecord"]
    for kind in ("images", "records"):
        shutil.copytree(ROOT / "resources/cohort" / kind, tmp_path / kind)
    cohort = (ROOT / "resources/cohort/samples.tsv").read_text().splitlines()[1:]
    for repeat in "ab":
        rows += [repeat + row.replace("\t", f"\t{repeat}", 1) for row in cohort]
    (tmp_path / "samples.tsv").write_text("\n".join(rows) + "\n")
    result = check_study(tmp_path)
    assert (len(result.seen), result.faults) == (30, [])


def test_a_cure_that_many_rows_need_is_said_once():
    lines = ["row 2: no; paste `a`", "row 3: no; paste `a`", "row 4: no; paste `b`", "row 5: no"]
    assert each_cure_once(lines) == [lines[0], "row 3: no; as above", *lines[2:]]


def test_a_cure_that_was_said_further_up_is_said_of_which_row():
    lines = ["t, row 2 (A): no; cut it", "t, row 3 (B): no; add it", "t, row 4 (C): no; cut it"]
    assert each_cure_once(lines)[2] == "t, row 4 (C): no; as for row 2 (A)"
    assert each_cure_once([line.replace("row", "line") for line in lines])[2].endswith("; cut it")


def test_a_reader_that_has_seen_enough_is_no_error(study):
    add(study)
    command = f"{sys.executable} -m softsample check '{study}' | true; echo ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert (done.stderr, done.stdout) == ("", "141\n")


@pytest.mark.parametrize("own", [False, True])
def test_after_a_run_with_failures_the_finished_groups_are_reported(own, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "samples.tsv").touch()
    called = []
    statuses = iter([1, 0])
    monkeypatch.setattr(run, "_call", lambda words: called.append(words) or next(statuses))
    assert run.run_study(tmp_path if own else None) == 1
    first, second = called
    assert "reported" in second
    assert "reported" not in first
    settings = second[second.index("--config") + 1 :]
    given = (
        [f'samples= "{tmp_path}/samples.tsv" ', f'results= "{tmp_path}/results" '] if own else []
    )
    assert settings == [*given, "report={groups: finished}"]


def test_names_of_folders_are_no_yaml(tmp_path, monkeypatch):
    """Snakemake parses what follows `--config`: a sign for a comment, a colon, a number."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "Mouse #3: a"
    folder.mkdir()
    (folder / "samples.tsv").touch()
    called = []
    monkeypatch.setattr(run, "_call", lambda words: called.append(words) or 0)
    run.run_study(folder, results="2026")
    words = called[0][called[0].index("--config") + 1 :]
    assert parse_config(words) == {"samples": f"{folder}/samples.tsv", "results": "2026"}


@pytest.mark.parametrize("of_others", [True, False])
def test_a_target_is_made_of_the_groups_that_came_through_if_they_have_it(
    of_others, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "samples.tsv").touch()
    called, looked = [], []
    statuses = iter([1, 0])
    monkeypatch.setattr(run, "_call", lambda words: called.append(words) or next(statuses))
    monkeypatch.setattr(
        run.subprocess, "call", lambda words, **_: looked.append(words) or int(not of_others)
    )
    assert run.run_study(tmp_path, targets=["tables/table1.csv"]) == 1
    assert [words[-2:] for words in looked] == [["--quiet", "all"]]
    of_the_others = [words for words in called[1:] if "report={groups: not_failed}" in words]
    assert len(of_the_others) == len(called) - 1 == int(of_others)
    assert all("tables/table1.csv" in words for words in called)
    assert ("Results: " in capsys.readouterr().out) == of_others


@pytest.fixture
def called(tmp_path, monkeypatch):
    """Commands that are called where a study is in the folder `lab`, none of which is run."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    (tmp_path / "lab/samples.tsv").touch()
    called = []
    monkeypatch.setattr(run, "_call", lambda words: called.append(words) or 0)
    return called


@pytest.mark.parametrize(
    ("targets", "told"),
    [
        ([], "Report: lab/results/report.html"),
        (["reported"], "Report: lab/results/report.html"),
        (["verdicts"], "Results: lab/results"),
    ],
)
def test_a_report_is_announced_only_by_runs_that_make_it(targets, told, called, capsys):
    assert run.run_study("lab", targets=targets) == 0
    assert capsys.readouterr().out == f"{told}\n"


def test_several_targets_are_made_in_one_run(called, capsys):
    verdicts = [f"results/loop/{group}/verdict.json" for group in "AB"]
    assert main(["run", "lab", "--target", verdicts[0], "--target", verdicts[1]]) == 0
    (words,) = called
    first = words.index(f"lab/{verdicts[0]}")
    assert words[first : first + 2] == [f"lab/{verdict}" for verdict in verdicts]
    capsys.readouterr()
    with pytest.raises(SystemExit):
        main(["run", "--help"])
    told = " ".join(capsys.readouterr().out.split())
    assert "rule or file (default: all); may be repeated" in told


@pytest.mark.parametrize("results", [None, "elsewhere"])
def test_a_path_in_results_is_one_in_the_results_of_the_study(results, called):
    targets = ["results/loop/A/verdict.md", "verdicts", "lab/results/report.html"]
    assert run.run_study("lab", results=results, targets=targets) == 0
    asked = [f"{results or 'lab/results'}/loop/A/verdict.md", *targets[1:]]
    assert [word for word in called[0] if word in {*asked, *targets}] == asked
