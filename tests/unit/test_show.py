import subprocess

import numpy as np
import pytest

from softsample.__main__ import main
from softsample.figures import offscreen
from softsample.io import write_json, write_mesh, write_segmentation, write_surface, write_table
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.surface import boundary_surface


def test_json_is_printed_line_by_line_without_provenance(tmp_path, capsys):
    path = tmp_path / "a.json"
    write_json(path, {"length_mm": 20.5, "runs": [{"steps": 7}], "provenance": {"rule": "x"}})
    assert main(["show", str(path)]) == 0
    assert capsys.readouterr().out == "length_mm: 20.5\nruns[0]:\n  steps: 7\n"
    assert main(["show", str(path), "--all"]) == 0
    assert "rule: x" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "shown"), [("[1, 2]", "[1, 2]"), ("3", "3"), ('[{"x": 3}]', "x: 3")]
)
def test_json_may_hold_no_keys(tmp_path, capsys, text, shown):
    (tmp_path / "a.json").write_text(text)
    assert main(["show", str(tmp_path / "a.json")]) == 0
    assert shown in capsys.readouterr().out


def test_long_lists_and_tables_are_abbreviated(tmp_path, capsys):
    write_json(tmp_path / "a.json", {"x": list(range(100))})
    main(["show", str(tmp_path / "a.json")])
    assert "... (100 values)" in capsys.readouterr().out
    write_table(tmp_path / "a.csv", {"x": np.arange(100)})
    main(["show", str(tmp_path / "a.csv")])
    assert len(capsys.readouterr().out.splitlines()) < 30


def test_without_rendering_a_mesh_is_drawn_all_the_same(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(offscreen, "rendering_works", lambda: False)
    path, picture = tmp_path / "a.vtu", tmp_path / "a.png"
    mesh = mesh_cuboid(2e-3, 2e-3, 1e-3, 1e-3)
    write_mesh(path, mesh, {}, {"scaled_jacobian": np.linspace(0.5, 1.0, len(mesh.hexes))})
    assert main(["show", str(path), "-o", str(picture)]) == 0
    shown = capsys.readouterr()
    assert "element data scaled_jacobian: 0.5 to 1" in shown.out
    assert "apt-get install libegl1 libgl1-mesa-dri" in shown.err
    assert picture.read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize("status", [0, 1, -11])
def test_a_probe_that_crashes_means_no_rendering(monkeypatch, status):
    offscreen.rendering_works.cache_clear()
    monkeypatch.setattr(
        subprocess, "run", lambda *given, **more: subprocess.CompletedProcess(given, status)
    )
    assert offscreen.rendering_works() is (status == 0)
    offscreen.rendering_works.cache_clear()


@pytest.mark.parametrize("name", ["a.docx", "none.json", "none.vtu", "none.stl", "none.nrrd"])
def test_what_cannot_be_shown_is_one_message(tmp_path, capsys, name):
    assert main(["show", str(tmp_path / name)]) == 1
    assert name in capsys.readouterr().err


def test_a_segmentation_of_slicer_is_drawn(tmp_path, capsys):
    path, picture = tmp_path / "T7.seg.nrrd", tmp_path / "a.png"
    mask = np.zeros((6, 5, 4))
    mask[2:4, 1:3, 1:3] = 1
    write_segmentation(path, mask, np.diag([0.4, 0.4, 0.5, 1.0]), "T7")
    assert main(["show", str(path), "--segment", "T7", "-o", str(picture)]) == 0
    assert "6 x 5 x 4 voxels\n0.4 x 0.4 x 0.5 mm each" in capsys.readouterr().out
    assert picture.read_bytes()[:4] == b"\x89PNG"


def test_a_surface_is_measured_and_drawn(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(offscreen, "rendering_works", lambda: False)
    path, picture = tmp_path / "a.stl", tmp_path / "a.png"
    write_surface(path, boundary_surface(mesh_cuboid(6e-3, 4e-3, 5e-3, 1e-3)))
    assert main(["show", str(path), "-o", str(picture)]) == 0
    shown = capsys.readouterr().out
    assert "296 triangles around 120 mm3" in shown
    assert "z: 0 to 5 mm" in shown
    assert picture.read_bytes()[:4] == b"\x89PNG"
