"""The page of `check`: every sample, its pictures and what is wrong with it."""

import re

import nibabel
import numpy as np
import pytest

import exact
import machines
from softsample.__main__ import CHECK_PAGE, main
from softsample.figures.geometry import Scan
from softsample.figures.inspected import inspected_figure
from softsample.inspection import _first_slope, check_page, scan
from softsample.records import Record
from softsample.study.check import check_study

BLOCK = slice(8, 32), slice(10, 30), slice(6, 26)
"""Voxels of 0.4 mm that are bright: 9.6 x 8 x 8 mm."""


@pytest.fixture
def study(tmp_path):
    """A sample with an image, one of stated dimensions, and one whose record is missing."""
    values = np.random.default_rng(0).integers(0, 20, (40, 40, 30)).astype(np.int16)
    values[BLOCK] += 300
    affine = np.diag([0.4, 0.4, 0.4, 1.0])
    affine[:3, 3] = 11.0, -7.0, 5.0
    nibabel.save(nibabel.Nifti1Image(values, affine), tmp_path / "A.nii.gz")
    machines.write(tmp_path / "A.csv", machines.univert(*machines.compression()))
    time, moved, force = exact.uniaxial_record(360.0, 12.0, -0.25)
    lines = [f"{t:.3f},{d:.5f},{f:.7f}" for t, d, f in zip(time, moved, force, strict=True)]
    (tmp_path / "B.csv").write_text("\n".join(["time_s,displacement_mm,force_N", *lines, ""]))
    size = "cuboid\t20\t18\t12"
    rows = [
        "sample\tgroup\tmode\timage\trecord\tshape\tlength_mm\twidth_mm\theight_mm",
        "A\tA\tcompression\tA.nii.gz\tA.csv",
        f"B\tB\tcompression\t\tB.csv\t{size}",
        f"C\tC\tcompression\t\tnone.csv\t{size}",
    ]
    (tmp_path / "samples.tsv").write_text("\n".join(rows) + "\n")
    return tmp_path


def test_the_page_shows_every_sample_and_its_faults(study, capsys):
    assert main(["check", str(study)]) == 1
    assert f"To look at: {study / CHECK_PAGE}" in capsys.readouterr().out
    page = (study / CHECK_PAGE).read_text()
    sections = dict(
        re.findall(r'<section class="sample" id="(\w)">(.*?)</section>', page, re.DOTALL)
    )
    assert list(sections) == ["A", "B", "C"]
    assert [name for name, text in sections.items() if "data:image/webp" in text] == ["A", "B"]
    assert "no such record" in sections["C"]
    assert "Fault" not in sections["A"] + sections["B"]
    assert not re.search(r'(src|href)="(?!data:|#)', page), "nothing outside itself"


def test_an_image_that_is_refused_is_shown(study):
    """Someone sees there what is wrong with it: here the sample reaches out of the image."""
    image = nibabel.load(study / "A.nii.gz")
    nibabel.save(image.slicer[:, :, BLOCK[2].start + 4 :], study / "A.nii.gz")
    seen = check_study(study)
    assert any("touches the edge" in fault for fault in seen.faults)
    image = scan(seen.seen[0])
    assert type(image) is Scan
    figure = inspected_figure("shear", None, image=image)
    assert [len(ax.images) for ax in figure.axes] == [1, 1, 1, 0]
    assert "data:image/webp" in check_page(seen, "lab").split('id="B"')[0]


def test_the_rough_modulus_is_that_of_the_record(study):
    main(["check", str(study)])
    page = (study / CHECK_PAGE).read_text()
    (of_b,) = re.findall(r'id="B">.*?roughly</th><td>(\d+) Pa', page, re.DOTALL)
    assert float(of_b) == pytest.approx(exact.MODULUS, rel=0.5)


def test_a_slope_is_had_of_a_few_readings():
    way = np.array([0.0, 2e-3])
    record = Record(None, way, 3.0 * way, calibrated=np.ones(2, bool))
    assert _first_slope(record) == pytest.approx(3.0)


def test_a_page_that_cannot_be_written_hides_no_fault(study, capsys):
    (study / CHECK_PAGE).mkdir()
    assert main(["check", str(study)]) == 1
    told = capsys.readouterr()
    assert "no such record" in told.err
    assert CHECK_PAGE in told.err


def test_the_contour_lies_where_the_sample_is(study):
    """The map of a segmentation is in metres, that of a figure in millimetres."""
    image = scan(check_study(study).seen[0])
    edges = np.array([[0.0, 0.0, 0.0], image.data.shape]) - 1.0
    assert (image.distance_at(edges[:1]) > 1.0).all()
    middle = image.centre()
    scale = np.array([40, 40, 30]) / image.data.shape
    wanted = [0.5 * (part.start + part.stop - 1) for part in BLOCK]
    np.testing.assert_allclose(middle * scale, wanted, atol=2.0)
    assert (image.distance_at(middle[None]) < -3.0).all()


def test_what_is_calibrated_is_in_colour():
    way, force = np.linspace(0.0, 2.0, 11), np.linspace(0.0, 1.0, 11)
    figure = inspected_figure("tension", (way, force, way <= 1.0))
    (ax,) = figure.axes
    fitted = ax.lines[1].get_ydata()
    assert np.isfinite(fitted).sum() == 6
    assert ax.get_xlabel() == "Displacement of the platen [mm]"
