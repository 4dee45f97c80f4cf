import json
import os
import subprocess
import sys
import textwrap
import time

import nibabel
import numpy as np
import pandas as pd
import pytest

from softsample.errors import InputError
from softsample.formats import header_doubts
from softsample.images import image_doubts
from softsample.io import (
    read_distance,
    read_image,
    read_json,
    read_mesh,
    read_mesh_with_data,
    read_samples,
    read_table,
    write_image,
    write_json,
    write_mesh,
    write_table,
    write_text,
    written_aside,
)
from softsample.meshing.mesh import HexMesh


def unit_hex():
    """One element of 1 mm; written by hand, in metres."""
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1]]
    return HexMesh(1e-3 * np.array([*corners, [0, 1, 1]], dtype=float), np.arange(8)[None])


def test_a_failure_while_writing_leaves_the_old_file_and_no_other(tmp_path):
    target = tmp_path / "result.json"
    write_json(target, {"value": 1})

    def fail_half_way():
        with written_aside(target) as aside:
            aside.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail_half_way()
    assert read_json(target) == {"value": 1}
    assert os.listdir(tmp_path) == ["result.json"]


def test_a_process_killed_while_writing_leaves_the_old_file(tmp_path):
    target = tmp_path / "result.csv"
    write_text(target, "whole\n")
    code = """
        import sys, time
        from softsample.io import written_aside
        with written_aside(sys.argv[1]) as aside:
            aside.write_text("half")
            print("writing", flush=True)
            time.sleep(60)
    """
    process = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(code), str(target)],
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert process.stdout.readline() == b"writing\n"
    process.kill()
    process.wait()
    assert target.read_text() == "whole\n"
    write_text(target, "new\n")
    assert os.listdir(tmp_path) == ["result.csv"]  # what the other left is gone


def test_a_reader_of_the_old_file_is_not_disturbed(tmp_path):
    target = tmp_path / "result.csv"
    write_text(target, "old\n")
    with target.open() as reader:
        write_text(target, "new\n")
        assert reader.read() == "old\n"
    assert target.read_text() == "new\n"


@pytest.mark.parametrize("bad", [np.nan, np.inf, np.float32("nan"), np.array([1.0, np.nan])])
def test_a_result_that_is_not_finite_is_refused_by_name(tmp_path, bad):
    with pytest.raises(InputError, match=r"a\.json: fit: mu_pa.* a result must be finite"):
        write_json(tmp_path / "a.json", {"fit": {"mu_pa": bad}})
    assert not (tmp_path / "a.json").exists()


def test_numpy_values_become_plain_json(tmp_path):
    path = tmp_path / "deep" / "a.json"
    write_json(path, {"n": np.int64(3), "flag": np.bool_(True), "x": np.arange(2), "none": None})
    assert json.loads(path.read_text()) == {"n": 3, "flag": True, "x": [0, 1], "none": None}


def test_a_damaged_json_file_says_what_to_do(tmp_path):
    path = tmp_path / "a.json"
    path.write_text('{"a": ')
    with pytest.raises(InputError, match=r"a\.json: not valid JSON .*delete it and run again"):
        read_json(path)


def test_tables_keep_ten_digits_and_ids_stay_text(tmp_path):
    path = tmp_path / "a.csv"
    write_table(path, {"sample": ["007"], "mu_pa": [1234.567891234]})
    table = read_table(path)
    assert table["sample"].tolist() == ["007"]
    assert table["mu_pa"][0] == pytest.approx(1234.567891234, rel=1e-9)


def test_samples_are_read_as_text_with_empty_cells(tmp_path):
    path = tmp_path / "samples.tsv"
    path.write_text("# mine\nsample\tgroup\tmode\n01\t\ttension\n")
    table = read_samples(path)
    assert table.to_dict("records") == [{"sample": "01", "group": "", "mode": "tension"}]


def test_a_missing_table_of_samples_names_the_option(tmp_path):
    with pytest.raises(InputError, match="no such table of samples; give its path with --config"):
        read_samples(tmp_path / "none.tsv")


@pytest.mark.parametrize("separator", [",", ";"])
def test_a_table_of_samples_with_another_separator_is_refused_in_one_line(tmp_path, separator):
    path = tmp_path / "samples.tsv"
    path.write_text("# a note\n" + separator.join(["sample", "group"]) + "\n")
    with pytest.raises(
        InputError, match=f"row 2: titles are separated by '{separator}'; .* one tab"
    ):
        read_samples(path)


def test_images_come_back_with_their_affine(tmp_path):
    path = tmp_path / "a.nii.gz"
    data = np.random.default_rng(1).normal(size=(3, 4, 5)).astype(np.float32)
    affine = np.diag([0.25, 0.25, 0.5, 1.0])
    affine[:3, 3] = [1.5, -2.0, 3.0]
    write_image(path, data, affine)
    first = path.read_bytes()
    back, back_affine = read_image(path)
    np.testing.assert_array_equal(back, data)
    np.testing.assert_allclose(back_affine, affine, atol=1e-6)  # NIfTI stores single precision
    time.sleep(1.1)  # a time stamp in the gzip header would now differ
    write_image(path, data, affine)
    assert path.read_bytes() == first


def test_a_truncated_image_says_what_to_do(tmp_path):
    path = tmp_path / "a.nii.gz"
    write_image(path, np.random.default_rng(0).normal(size=(20, 20, 20)), np.eye(4))
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(InputError, match=r"a\.nii\.gz: not a readable NIfTI image"):
        read_image(path)


def test_an_image_of_two_dimensions_is_refused(tmp_path):
    write_image(tmp_path / "a.nii.gz", np.zeros((4, 5)), np.eye(4))
    with pytest.raises(InputError, match=r"shape \(4, 5\); give one three-dimensional volume"):
        read_image(tmp_path / "a.nii.gz")


def test_two_affines_that_differ_are_doubted(tmp_path):
    image = nibabel.Nifti1Image(np.zeros((9, 9, 9), np.int16), np.eye(4))
    for shift, doubted in ((0.0, False), (0.3, False), (5.0, True)):
        image.set_sform(np.eye(4), 1)
        moved = np.eye(4)
        moved[0, 3] = shift
        image.set_qform(moved, 1)
        nibabel.save(image, tmp_path / "a.nii.gz")
        told = header_doubts(tmp_path / "a.nii.gz")
        assert ("differ by up to 5 mm" in "".join(told)) is doubted is bool(told)


def test_coarse_voxels_and_cut_off_values_are_doubted():
    values = np.random.default_rng(0).uniform(0.0, 1000.0, (20, 20, 20)).astype(np.float32)
    fine, thick = np.diag([0.5, 0.5, 0.75, 1.0]), np.diag([0.3, 0.3, 1.0, 1.0])
    assert not list(image_doubts(values, fine, "a"))
    assert "a: voxels of up to 1 mm" in "".join(image_doubts(values, thick, "a"))
    cut = "".join(image_doubts(np.minimum(values, 800.0), fine, "a"))
    assert "have the highest value, 800, as if cut off there; export" in cut
    (mask,) = image_doubts(255.0 * (values > np.median(values)), fine, "a")
    assert "two values only, 0 and 255, as a mask; name it in column segmentation" in mask


def test_an_image_without_affine_is_refused(tmp_path):
    nibabel.save(nibabel.Nifti1Image(np.zeros((9, 9, 9), np.int16), None), tmp_path / "a.nii.gz")
    with pytest.raises(InputError, match=r"a\.nii\.gz: has no affine .* export the image with"):
        read_image(tmp_path / "a.nii.gz")


def test_signed_distance_comes_back_in_metres(tmp_path):
    write_image(tmp_path / "d.nii.gz", np.full((2, 2, 2), -1.5, np.float32), np.eye(4))
    write_json(tmp_path / "d.json", {"grid_origin_mm": [1, 2, 3], "grid_spacing_mm": 0.25})
    distance, origin, spacing = read_distance(tmp_path / "d.nii.gz", tmp_path / "d.json")
    assert distance[1, 1, 1] == pytest.approx(-1.5e-3)
    np.testing.assert_allclose(origin, [1e-3, 2e-3, 3e-3])
    assert spacing == pytest.approx(0.25e-3)


def test_meshes_are_in_mm_in_the_file_and_in_m_in_memory(tmp_path):
    path, mesh = tmp_path / "m.vtu", unit_hex()
    write_mesh(path, mesh, {"bottom": mesh.points[:, 2] == 0.0}, {"quality": [0.5]})
    back, point_data, cell_data = read_mesh_with_data(path)
    np.testing.assert_allclose(back.points, mesh.points, rtol=1e-15)
    np.testing.assert_array_equal(back.hexes, mesh.hexes)
    assert point_data["bottom"].dtype == np.uint8
    assert point_data["bottom"].tolist() == [1, 1, 1, 1, 0, 0, 0, 0]
    assert cell_data["quality"].tolist() == [0.5]
    import pyvista

    assert pyvista.read(path).volume == pytest.approx(1.0)  # mm3, read by somebody else


def test_mesh_data_of_a_wrong_length_is_refused(tmp_path):
    with pytest.raises(InputError, match="'bottom' has 3 values, not 8"):
        write_mesh(tmp_path / "m.vtu", unit_hex(), {"bottom": [1, 2, 3]})


def test_a_damaged_mesh_says_what_to_do(tmp_path, capfd):
    path = tmp_path / "m.vtu"
    write_mesh(path, unit_hex())
    path.write_bytes(path.read_bytes()[:300])
    with pytest.raises(InputError, match=r"m\.vtu: not a readable VTU mesh"):
        read_mesh(path)


def test_a_frame_is_written_without_its_index(tmp_path):
    write_table(tmp_path / "a.csv", pd.DataFrame({"a": [1]}, index=[7]))
    assert (tmp_path / "a.csv").read_text() == "a\n1\n"
