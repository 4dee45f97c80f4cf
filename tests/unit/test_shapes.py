"""Idealised shapes: areas and volumes by hand, table and report, refusals, size of elements."""

import numpy as np
import pytest

from softsample.errors import InputError
from softsample.io import read_yaml
from softsample.meshing.quality import element_volumes
from softsample.meshing.sample import mesh_ideal
from softsample.shapes import KINDS, STATED, IdealShape, element_size

MM = 1e-3
CUBOID = IdealShape("cuboid", 20 * MM, 15 * MM, 12 * MM)
CYLINDER = IdealShape("cylinder", 20 * MM, 20 * MM, 12 * MM)


def test_areas_and_volumes():
    assert CUBOID.area == pytest.approx(300e-6)
    assert CUBOID.volume == pytest.approx(3600e-9)
    assert CYLINDER.area == pytest.approx(np.pi * 100e-6)
    assert CYLINDER.volume == pytest.approx(np.pi * 1200e-9)
    assert CUBOID.smallest == CYLINDER.smallest == 12 * MM
    assert IdealShape("cylinder", 5 * MM, 5 * MM, 9 * MM).smallest == 5 * MM


def test_free_faces_move_and_the_base_stays():
    grown = CUBOID.grown(0.5 * MM)
    assert (grown.length, grown.width, grown.height) == pytest.approx((21e-3, 16e-3, 12.5e-3))
    assert CYLINDER.grown(-MM) == IdealShape("cylinder", 18 * MM, 18 * MM, 11 * MM)
    with pytest.raises(InputError, match="length of the cylinder is -2 mm; give a positive"):
        CYLINDER.grown(-11 * MM)


def test_from_the_cells_of_a_row():
    row = {"sample": "A", "shape": "cuboid", "length_mm": "20", "width_mm": "15", "height_mm": "12"}
    assert IdealShape.of_row(row) == CUBOID
    row = {"shape": "cylinder", "diameter_mm": "20.0", "height_mm": "12", "length_mm": ""}
    assert IdealShape.of_row(row) == CYLINDER


@pytest.mark.parametrize("shape", [CUBOID, CYLINDER])
def test_a_report_is_read_back(shape):
    report = shape.report()
    back = IdealShape.of_report({**report, "provenance": {}})
    assert back.kind == shape.kind
    assert (back.length, back.width, back.height) == pytest.approx(
        (shape.length, shape.width, shape.height), rel=1e-15
    )
    assert ("diameter_mm" in report) == (shape.kind == "cylinder")
    assert report["ideal_area_mm2"] * report["height_mm"] == pytest.approx(
        report["volume_ideal_mm3"]
    )


ROWS = {
    "no kind": ({}, "shape: '' is not one of cuboid, cylinder"),
    "other kind": ({"shape": "cone"}, "shape: 'cone' is not one of"),
    "missing": (
        {"shape": "cylinder", "height_mm": "9"},
        "diameter_mm: is missing; a cylinder needs diameter_mm, height_mm",
    ),
    "too many": (
        {"shape": "cylinder", "diameter_mm": "9", "height_mm": "9", "width_mm": "9"},
        "width_mm: a cylinder has none; leave the cell empty",
    ),
    "words": (
        {"shape": "cylinder", "diameter_mm": "9 mm", "height_mm": "9"},
        "diameter_mm: '9 mm' is no length; give a positive number of mm",
    ),
    "zero": ({"shape": "cylinder", "diameter_mm": "9", "height_mm": "0"}, "height_mm: '0' is no"),
    "nan": ({"shape": "cylinder", "diameter_mm": "nan", "height_mm": "9"}, "'nan' is no length"),
}


@pytest.mark.parametrize("fault", ROWS)
def test_a_wrong_row_is_refused_with_its_cure(fault):
    row, message = ROWS[fault]
    with pytest.raises(InputError, match=message):
        IdealShape.of_row(row)


def test_senseless_shapes_are_refused():
    with pytest.raises(InputError, match="'ball' is unknown; give one of cuboid, cylinder"):
        IdealShape("ball", 1.0, 1.0, 1.0)
    with pytest.raises(InputError, match="width of the cuboid is inf mm"):
        IdealShape("cuboid", 1.0, np.inf, 1.0)
    with pytest.raises(InputError, match="one diameter, not 20 and 19 mm"):
        IdealShape("cylinder", 20 * MM, 19 * MM, 9 * MM)


def test_columns_of_every_shape_are_columns_of_the_table():
    schema = read_yaml("workflow/schemas/samples.schema.yaml")
    assert {name for names in STATED.values() for name in names} <= set(schema["properties"])
    assert set(STATED) == set(KINDS)


def test_elements_are_as_wanted_in_samples_of_the_usual_size():
    """The cohort's shortest edges are 12 to 13 mm, at 0.5 and at 1 mm."""
    across = read_yaml("config/config.yaml")["mesh"]["elements_across"]
    for wanted in (0.5 * MM, 1.0 * MM):
        for height in (12.06 * MM, 12.83 * MM, 20 * MM):
            assert element_size(IdealShape("cuboid", 23 * MM, 20 * MM, height), wanted, across) == (
                wanted
            )


@pytest.mark.parametrize(("smallest", "expected"), [(2.0, 0.25), (4.0, 0.5), (60.0, 1.5)])
def test_elements_give_way_in_small_and_large_samples(smallest, expected):
    shape = IdealShape("cylinder", 2 * smallest * MM, 2 * smallest * MM, smallest * MM)
    size = element_size(shape, 0.5 * MM, (8, 40))
    assert size == pytest.approx(expected * MM)
    mesh = mesh_ideal(shape, 2.0 * size).mesh  # the coarse one
    assert len(np.unique(mesh.points[:, 2])) - 1 in (4, 20)
    assert element_volumes(mesh).sum() == pytest.approx(shape.volume, rel=1e-12)


def test_bounds_of_elements_have_to_ascend():
    with pytest.raises(InputError, match=r"40 to 8 across: give a positive size and ascending"):
        element_size(CUBOID, MM, (40, 8))
    with pytest.raises(InputError, match=r"elements of 0 mm"):
        element_size(CUBOID, 0.0, (8, 40))
