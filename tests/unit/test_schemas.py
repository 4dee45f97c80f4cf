"""Closed, bounded schemas: each refusal has its message."""

import copy
from dataclasses import fields
from pathlib import Path

import pandas as pd
import pytest
from jsonschema import Draft202012Validator

from softsample.calibration.slsqp import CalibrationSettings
from softsample.calibration.uncertainty import UncertaintySettings
from softsample.errors import InputError
from softsample.fem.boundary import ContactSettings
from softsample.fem.explicit import SolverSettings
from softsample.geometry_effects.variants import EffectSettings
from softsample.imaging.measure import MeasurementSettings
from softsample.imaging.settings import SegmentationSettings
from softsample.io import read_samples, read_yaml
from softsample.laws.group import LawSettings
from softsample.loop.effects import library
from softsample.plausibility import Limits
from softsample.protocol import MODES
from softsample.records import RecordSettings
from softsample.response.bond import BondSettings
from softsample.response.floor import FloorSettings
from softsample.response.unit import ResponseSettings
from softsample.shapes import Indenter
from softsample.validation import (
    check_config,
    check_samples,
    modelled_ends,
    overlaid,
    record_settings,
    resolved,
)

ROOT = Path(__file__).resolve().parents[2]
SCHEMAS = {
    name: read_yaml(ROOT / f"workflow/schemas/{name}.schema.yaml")
    for name in ("config", "samples", "record")
}
OVERLAYS = sorted((ROOT / "config").glob("[!cm]*.yaml"))
STUDIES = read_yaml(ROOT / "config/measured.yaml")["studies"]
CONFIG = read_yaml(ROOT / "config/config.yaml")


def objects(schema):
    """Every part of a schema that describes an object, and every property, with its place."""
    if schema.get("type") == "object":
        yield "object", schema
        for name, part in schema.get("properties", {}).items():
            yield name, part
            yield from objects(part)


@pytest.mark.parametrize("name", SCHEMAS)
def test_schemas_are_valid_closed_and_described(name):
    Draft202012Validator.check_schema(SCHEMAS[name])
    for key, part in objects(SCHEMAS[name]):
        if part.get("type") == "object":
            values = part["additionalProperties"]
            assert values is False or values["description"], key
        else:
            assert part.get("description"), key
        if part.get("type") in ("number", "integer"):
            assert {"minimum", "exclusiveMinimum"} & set(part), key
            assert {"maximum", "exclusiveMaximum"} & set(part), key


def test_config_is_accepted():
    check_config(CONFIG, SCHEMAS["config"], "config.yaml")


@pytest.mark.parametrize("path", OVERLAYS, ids=lambda path: path.name)
def test_every_other_config_changes_the_study_and_is_accepted(path):
    changed = overlaid(CONFIG, read_yaml(path))
    check_config(changed, SCHEMAS["config"], path.name)
    own_section = set(changed) > set(CONFIG)
    assert changed["results"] != CONFIG["results"] or own_section


@pytest.mark.parametrize("name", STUDIES)
def test_settings_of_a_measured_study_are_accepted(name):
    check_config(overlaid(CONFIG, STUDIES[name]["settings"]), SCHEMAS["config"], name)


@pytest.mark.parametrize(
    ("section", "settings", "beside"),
    [
        ("records", RecordSettings, {"-block"}),
        ("plausibility", Limits, set()),
        ("segmentation", SegmentationSettings, set()),
        ("measurement", MeasurementSettings, {"-preload_mm"}),
        ("bond", BondSettings, set()),
        ("contact", ContactSettings, set()),
        ("solver", SolverSettings, set()),
        ("family", ResponseSettings, set()),
        ("calibration", CalibrationSettings, set()),
        ("laws", LawSettings, set()),
        ("uncertainty", UncertaintySettings, set()),
        ("floor", FloorSettings, set()),
        ("geometry_effects", EffectSettings, {"element_size_mm", "prescribed_strain"}),
    ],
)
def test_settings_of_the_library_are_the_keys_of_the_config(section, settings, beside):
    """`beside` are keys that are no setting, and settings (-) that stand in another section."""
    elsewhere = {name[1:] for name in beside if name.startswith("-")}
    assert {field.name for field in fields(settings)} - elsewhere == set(CONFIG[section]) - beside
    assert elsewhere <= {*CONFIG["protocol"], "block"}
    assert set(SCHEMAS["config"]["properties"][section]["properties"]) == set(CONFIG[section])


def test_pairs_of_the_blind_laboratory_need_their_size():
    """Its curves take an hour: what cannot be planted is refused before."""
    config = overlaid(CONFIG, read_yaml(ROOT / "config/blind.yaml"))
    config["blind"]["extents"]["blind"]["sizes"] = [0.5, 2.0]
    with pytest.raises(InputError, match="extents.blind.sizes: .*1, the size of pairs, is one"):
        check_config(config, SCHEMAS["config"], "blind.yaml")


BAD_CONFIGS = {
    "misspelt key": (
        ("mesh", "elment_size_mm", 0.5),
        "mesh.elment_size_mm: unknown name; did you mean 'element_size_mm'",
    ),
    "key of a section": (
        ("preload_mm", None, 1.0),
        "unknown name; did you mean 'protocol: preload_mm'",
    ),
    "unknown section": (("viscosity", None, {}), "viscosity: unknown name; known are samples"),
    "missing key": (
        ("mesh", "boundary_shift_mm", None),
        "mesh.boundary_shift_mm: is missing; give the real surface",
    ),
    "number read as text": (
        ("calibration", "mu_pa_min", "1e2"),
        "mu_pa_min: '1e2' is read as text; write a number with a decimal point",
    ),
    "modulus in kPa": (
        ("calibration", "mu_pa_max", 20.0),
        "mu_pa_max: 20.0 is less than the minimum of 1000.* expected: a shear modulus in Pa",
    ),
    "element of nothing": (
        ("mesh", "element_size_mm", 0.0),
        "mesh.element_size_mm: 0.0 is less than the minimum of 0.1; expected: edge length",
    ),
    "one exponent": (("material", "alpha", [-8.0]), "material.alpha: .* is too short"),
    "a base that no wall can touch": (
        ("contact", "side_walls", False),
        "contact.base_platen: true without side_walls",
    ),
    "one term twice": (("material", "alpha", [2.0, 2.0]), "material.alpha: .*is one term twice"),
    "free exponents without room": (
        ("exponents", "alpha1", [-8.0, -8.0]),
        "exponents.alpha1: -8.0 is not below the upper end, -8.0",
    ),
    "exponent zero": (("material", "alpha", [-8.0, 0]), "material.alpha.1: .*an exponent"),
    "shift in micrometres": (
        ("mesh", "boundary_shift_mm", 50),
        "boundary_shift_mm: 50 is greater than the maximum of 1; expected: the real surface",
    ),
    "soft to nothing": (
        ("material", "region_stiffness", {1: 0.0}),
        "material.region_stiffness.1: 0.0 is less than the minimum.*relative to the sample's",
    ),
    "region by name": (
        ("material", "region_stiffness", {"fat": 0.5}),
        "material.region_stiffness: 'fat' is .*expected: labels of regions, whole numbers",
    ),
    "incompressible": (("material", "poisson_ratio", 0.5), "0.5 is greater than the maximum"),
    "precision": (("solver", "precision", "half"), "'half' is not one of float32, float64"),
    "switch as text": (
        ("contact", "release", "yes"),
        "contact.release: 'yes' is not true or false",
    ),
    "table without a name": (("samples", None, ""), "samples: '' should be non-empty"),
    "more percents than sizes": (
        ("floor", "element_size_mm", [0.5, 1.0]),
        "floor.element_percent.tension: has 3 values for 2 of element_size_mm",
    ),
    "sizes out of order": (("floor", "element_size_mm", [2.0, 1.0, 0.5]), "does not ascend"),
    "a key that is a constant": (
        ("mesh", "core_depth", 1.0),
        "mesh.core_depth: unknown name; known are element_size_mm",
    ),
    "bounds exchanged": (("calibration", "mu_pa_min", 5e4), "mu_pa_min: 50000.0 is"),
    "an error that no run may have": (
        ("solver", "curve_error_percent", 1.0),
        "solver.curve_error_percent: 1.0 is above checks.error_bound_percent_max, 0.5",
    ),
    "braces in the folder": (("results", None, "a{b}"), "results: 'a{b}' has another form"),
}


@pytest.mark.parametrize("name", BAD_CONFIGS)
def test_a_bad_config_is_refused_with_place_and_cure(name):
    (section, key, value), message = BAD_CONFIGS[name]
    config = copy.deepcopy(CONFIG)
    if key is None:
        config[section] = value
    elif value is None:
        del config[section][key]
    else:
        config[section][key] = value
    with pytest.raises(
        InputError, match=r"(?s)configuration \(mine\.yaml\) is refused:.*" + message
    ):
        check_config(config, SCHEMAS["config"], "mine.yaml")


def test_all_faults_of_a_config_are_named_at_once():
    config = copy.deepcopy(CONFIG)
    config["mesh"]["element_size_mm"] = -1
    config["solver"]["curve_points"] = 2.5
    with pytest.raises(
        InputError, match=r"(?s)element_size_mm.*curve_points: 2\.5 is not a whole number"
    ):
        check_config(config, SCHEMAS["config"], "mine.yaml")


ROW = {"sample": "A1", "group": "G", "mode": "shear", "image": "a.nii.gz", "record": "a.csv"}


def table(*changes, row=ROW):
    lines = range(2, len(changes) + 2)
    return pd.DataFrame([{**row, **change} for change in changes], lines, dtype=str).fillna("")


def test_the_shipped_table_is_accepted():
    path = ROOT / "resources/cohort/samples.tsv"
    rows = check_samples(read_samples(path), SCHEMAS["samples"], str(path))
    assert len(rows) == 15
    assert rows[0]["sample"] == "S1"


def test_marked_images_are_accepted():
    marks = {"bond_mask": "b.seg.nrrd", "labels": "l.nii"}
    assert check_samples(table(marks), SCHEMAS["samples"], "t") == [{**ROW, **marks}]


@pytest.mark.parametrize(
    "name",
    ["T7.nrrd", "T7.nhdr", "T7.nii", "T7.NII.GZ", "dicom/T7", "dicom", "mri/T7/", "1.2.840.7/"],
)
def test_every_kind_of_image_is_accepted(name):
    check_samples(table({"image": name, "labels": name}), SCHEMAS["samples"], "t")


@pytest.mark.parametrize("label", [2, "2"])
def test_stiffness_of_regions_is_accepted(label):
    config = copy.deepcopy(CONFIG)
    config["material"]["region_stiffness"] = {0: 1.0, label: 2.5}
    check_config(config, SCHEMAS["config"], "mine.yaml")


def test_empty_optional_cells_and_axes_are_accepted():
    rows = check_samples(
        table({"loading_axis": "-y", "shear_axis": "", "labels": ""}), SCHEMAS["samples"], "t"
    )
    assert rows == [{**ROW, "loading_axis": "-y"}]


@pytest.mark.parametrize("ending", ["csv", "tra", "lvm", "asc", "raw", "TXT", "xlsm"])
def test_records_have_the_endings_that_machines_give(ending):
    rows = check_samples(table({"record": f"a.{ending}"}), SCHEMAS["samples"], "t")
    assert rows[0]["record"] == f"a.{ending}"


BAD_TABLES = {
    "mode": ([{"mode": "bending"}], "row 2 .A1., column 'mode': 'bending' is not one of tension"),
    "id": ([{"sample": "A/1"}], "column 'sample': 'A/1' has another form; expected: up to 64"),
    "group": ([{"group": "a b"}], "column 'group': 'a b' has another form"),
    "image": (
        [{"image": "a.png"}],
        "column 'image': 'a.png' has a wrong extension; expected: path of",
    ),
    "record": ([{"record": "a.doc"}], "column 'record': 'a.doc' has a wrong extension"),
    "empty cell": ([{"record": ""}], "column 'record': is missing; give path of the test record"),
    "twice": ([{}, {}], "row 3 .A1., column 'sample': 'A1' stands in row 2 already"),
    "twice but for case": (
        [{}, {"sample": "a1"}],
        "row 3 .a1., column 'sample': 'a1' stands in row 2",
    ),
    "unknown column": ([{"imgae": "a.nii"}], "column 'imgae': unknown name; did you mean 'image'"),
    "length in words": ([{"length_mm": "20 mm"}], "column 'length_mm': '20 mm' has another form"),
    "parallel axes": (
        [{"loading_axis": "-x"}],
        "row 2 .A1., column 'shear_axis': '.x' is parallel to the loading axis '-x'",
    ),
    "bond in compression": (
        [{"mode": "compression", "bond_mask": "b.nii"}],
        "row 2 .A1., column 'bond_mask': the top is not bonded in compression; leave the cell",
    ),
    "image for a segmentation": ([{"image": "a.Seg.nrrd"}], "'a.Seg.nrrd' has a wrong extension"),
    "folder with a dot": ([{"image": "1.2.840"}], "'1.2.840' has a wrong extension.*end it with /"),
    "mask": ([{"bond_mask": "b.stl"}], "column 'bond_mask': 'b.stl' has a wrong extension"),
    "path to elsewhere": (
        [{"record": "../../other/a.csv"}],
        "column 'record': '../../other/a.csv' lies outside the study folder; copy the file",
    ),
    "path from the root": ([{"image": "/mri/a.nii"}], "'/mri/a.nii' lies outside the study"),
    "wildcard of Snakemake": (
        [{"record": "it's {7}.csv"}],
        r"column 'record': \"it's \{7\}.csv\" has a brace, \{; rename the file without it",
    ),
    "axis": ([{"loading_axis": "z"}], "column 'loading_axis': 'z' is not one of .x, -x"),
}


@pytest.mark.parametrize("name", BAD_TABLES)
def test_a_bad_table_is_refused_with_row_column_and_cure(name):
    changes, message = BAD_TABLES[name]
    with pytest.raises(InputError, match=r"(?s)table of samples t\.tsv is refused:.*" + message):
        check_samples(table(*changes), SCHEMAS["samples"], "t.tsv")


TURNED = {
    "mode": "torsion",
    "image": "",
    "shape": "cylinder",
    "diameter_mm": "20",
    "height_mm": "8",
}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"shape": "cuboid", "diameter_mm": "", "length_mm": "20", "width_mm": "20"},
         "'shape': what is turned about its axis is a cylinder"),
        ({"ends": "sliding"}, "'ends': 'sliding' in torsion, where only bonded ends turn a sample"),
        ({"image": "a.nii.gz", "diameter_mm": "", "height_mm": ""}, "torsion"),
    ],
)  # fmt: skip
def test_torsion_is_for_bonded_cylinders_of_known_size(changes, message):
    check_samples(table(TURNED), SCHEMAS["samples"], "t.tsv")
    with pytest.raises(InputError, match=message):
        check_samples(table(TURNED | changes), SCHEMAS["samples"], "t.tsv")


CUBOID = {"shape": "cuboid", "length_mm": "20", "width_mm": "21.5", "height_mm": "10"}
CYLINDER = {"shape": "cylinder", "diameter_mm": "8", "height_mm": "4.0"}


def stated(*changes):
    """Table of samples whose geometry is no image."""
    return table(*changes, row={name: cell for name, cell in ROW.items() if name != "image"})


GEOMETRIES = [
    {"image": "a.nii"},
    {"image": "a.nii", "shape": "cylinder"},
    {"image": "a.nii", "mode": "compression", "ends": "0.3"},
    {"image": "a.nii", "mode": "compression", "ends": "sliding"},
    {"surface": "a.stl"},
    {"surface": "a.PLY", "shape": "cylinder", "labels": ""},
    {"surface": "a.vtp", "mode": "compression", "ends": "unknown"},
    CUBOID,
    {**CUBOID, "ends": "sliding"},
    {**CUBOID, "mode": "pure_shear", "ends": "sliding"},
    {**CYLINDER, "mode": "compression", "ends": "0"},
    {**CYLINDER, "mode": "confined_compression"},
    {**CYLINDER, "mode": "tension", "ends": "unknown", "specimen": "P1", "cycle": "3"},
]


@pytest.mark.parametrize("cells", GEOMETRIES, ids=str)
def test_a_geometry_of_any_source_is_accepted(cells):
    (row,) = check_samples(stated(cells), SCHEMAS["samples"], "t")
    assert row.items() >= {name: cell for name, cell in cells.items() if cell}.items()


BAD_GEOMETRIES = {
    "none": ({}, "column 'image': no geometry; give an image, a surface, or a shape"),
    "two": ({"image": "a.nii", "surface": "a.stl"}, "column 'surface': the row has an image as"),
    "measured twice": (
        {"image": "a.nii", "height_mm": "10"},
        "column 'height_mm': is measured in the image; leave the cell empty",
    ),
    "measured on a surface": (
        {"surface": "a.stl", **CUBOID},
        "column 'length_mm': is measured in the surface",
    ),
    "no such shape": ({**CUBOID, "shape": "cone"}, "'cone' is not one of cuboid, cylinder"),
    "no shape": ({"height_mm": "10"}, "column 'shape': is missing beside the dimensions"),
    "no height": (
        {**CYLINDER, "height_mm": ""},
        "column 'height_mm': is missing; a cylinder needs diameter_mm, height_mm",
    ),
    "cuboid with a diameter": (
        {**CUBOID, "diameter_mm": "3"},
        "column 'diameter_mm': a cuboid has none .it needs length_mm, width_mm, height_mm.; leave",
    ),
    "no length": ({**CUBOID, "length_mm": "0"}, "column 'length_mm': 0 mm is no size of a sample"),
    "in micrometres": ({**CUBOID, "height_mm": "10000"}, "'height_mm': 10000 mm is no size"),
    "axis of no image": ({**CUBOID, "loading_axis": "+y"}, "'loading_axis': concerns an image"),
    "labels of no image": ({**CUBOID, "labels": "l.nii"}, "'labels': concerns an image"),
    "bond of a surface": (
        {"surface": "a.stl", "bond_mask": "b.nii"},
        "column 'bond_mask': concerns an image, and the row has none",
    ),
    "surface of another kind": (
        {"surface": "a.obj"},
        "column 'surface': 'a.obj' has a wrong extension",
    ),
    "surface elsewhere": ({"surface": "../a.stl"}, "'../a.stl' lies outside the study folder"),
    "planar tension of an image": (
        {"image": "a.nii", "mode": "pure_shear"},
        "column 'mode': pure_shear is simulated on ideal shapes only; give shape and dimensions",
    ),
    "confined image": (
        {"surface": "a.stl", "mode": "confined_compression"},
        "confined_compression is simulated on ideal shapes only; .*in place of the surface",
    ),
    "round strip": ({**CYLINDER, "mode": "pure_shear"}, "column 'shape': a strip in pure shear"),
    "friction in tension": (
        {**CUBOID, "mode": "tension", "ends": "0.3"},
        "column 'ends': 0.3: Coulomb friction holds only what is pressed, and not in tension",
    ),
    "friction in shear": ({**CUBOID, "ends": "0.3"}, "and not in shear; give bonded or sliding"),
    "sliding image in shear": (
        {"image": "a.nii", "ends": "sliding"},
        "column 'ends': 'sliding' in shear needs a shape with dimensions; .*the bond decides",
    ),
    "sliding image in tension": (
        {"surface": "a.stl", "mode": "tension", "ends": "sliding"},
        "column 'ends': 'sliding' in tension needs a shape with dimensions",
    ),
    "negative friction": ({**CUBOID, "ends": "-0.1"}, "column 'ends': '-0.1' has another form"),
    "ends": ({**CUBOID, "ends": "glued"}, "column 'ends': 'glued' has another form; expected: how"),
    "direction": (
        {**CUBOID, "material_z": "f", "material_x": "2"},
        "column 'material_z': 'f' has another form; expected: 1, 2 or 3, a - before it",
    ),
    "direction along the load alone": (
        {**CUBOID, "mode": "shear", "material_z": "1"},
        "column 'material_x': is missing beside material_z",
    ),
    "direction along the shear alone": (
        {**CUBOID, "material_x": "1"},
        "column 'material_z': is missing beside material_x",
    ),
    "one direction twice": (
        {**CUBOID, "material_z": "-1", "material_x": "1"},
        "column 'material_x': '1' is parallel to material_z '-1'",
    ),
    "cycle": ({**CUBOID, "cycle": "0"}, "column 'cycle': '0' has another form; expected: loading"),
    "format": (
        {**CUBOID, "format": "bose"},
        "column 'format': 'bose' is no block of `formats` .*there are instron, univert",
    ),
}


@pytest.mark.parametrize("name", BAD_GEOMETRIES)
def test_a_bad_geometry_is_refused_with_its_cure(name):
    cells, message = BAD_GEOMETRIES[name]
    with pytest.raises(InputError, match=r"row 2 \(A1\), .*" + message):
        check_samples(stated(cells), SCHEMAS["samples"], "t.tsv", ("instron", "univert"))


def test_friction_of_a_row_without_a_mode_is_not_what_is_wrong():
    with pytest.raises(InputError, match="column 'mode'") as refused:
        check_samples(stated({**CUBOID, "mode": "", "ends": "0.3"}), SCHEMAS["samples"], "t.tsv")
    assert "Coulomb" not in str(refused.value)


def test_a_piece_belongs_to_one_group():
    rows = {"specimen": "P", **CUBOID}, {"sample": "A2", "group": "H", "specimen": "P", **CUBOID}
    with pytest.raises(InputError, match="'P' is of group 'H' in row 3; .*\n.*of group 'G' in row"):
        check_samples(stated(*rows), SCHEMAS["samples"], "t.tsv")
    check_samples(stated(rows[0], {**rows[1], "group": "G"}), SCHEMAS["samples"], "t.tsv")


def test_empty_cells_have_a_meaning_in_one_place():
    (row,) = check_samples(stated({**CYLINDER, "mode": "tension"}), SCHEMAS["samples"], "t.tsv")
    assert resolved(row) == {**row, "specimen": "A1", "ends": "bonded", "cycle": "largest"}
    assert resolved(ROW)["shape"] == "cuboid"
    given = {**row, "specimen": "P", "ends": "0.2", "cycle": "last"}
    assert resolved(resolved(given)) == given


def test_the_modes_of_the_schemas_are_those_of_the_protocol():
    selection = SCHEMAS["config"]["properties"]["hold_out"]["items"]["properties"]["mode"]
    assert tuple(SCHEMAS["samples"]["properties"]["mode"]["enum"]) == MODES
    assert tuple(selection["anyOf"][0]["enum"]) == MODES


SELECTIONS = [
    {"mode": "shear"},
    {"mode": ["tension", "compression"], "group": "G"},
    {"sample": ["A", "B"], "channel": "force_normal"},
    {"specimen": "P", "phase": ["hold", "unloading"], "cycle": [1, 2], "strain_above": 0.2},
    {"sample": "*_B[2-5]", "direction": "negative"},
]


def test_formats_and_what_is_held_out_are_accepted():
    formats = {"bose": {"positive": {"force": "compression"}, "sheet": "Data"}, "own": {}}
    changes = {"formats": formats, "hold_out": SELECTIONS, "leave_out": "specimen"}
    check_config(overlaid(CONFIG, changes), SCHEMAS["config"], "mine.yaml")


def test_a_format_stands_over_the_records_of_the_study():
    records = {"columns": {"force": "Fz"}, "positive": {"displacement": "loading"}}
    formats = {"bose": {"positive": {"force": "compression"}, "units": {"force": "mN"}}}
    config = overlaid(CONFIG, {"records": records, "formats": formats})
    assert record_settings(config, ROW) == config["records"]
    read = record_settings(config, {**ROW, "format": "bose"})
    assert read["positive"] == {"displacement": "loading", "force": "compression"}
    assert (read["columns"], read["units"]) == ({"force": "Fz"}, {"force": "mN"})
    with pytest.raises(InputError, match="'boss' is no block of `formats` .*there are bose"):
        record_settings(config, {**ROW, "format": "boss"})


BAD_PARTS = {
    "no such key": ([{"modes": "shear"}], "hold_out.0.modes: unknown name; did you mean 'mode'"),
    "no mode": ([{"mode": "bending"}], "hold_out.0.mode: 'bending' .*expected: tension, compr"),
    "way back": ([{}, {"phase": "back"}], "hold_out.1.phase: 'back' .*loading, hold or unloading"),
    "nothing": ([{}], "hold_out.0: "),
    "cycle zero": ([{"cycle": 0}], "hold_out.0.cycle: 0 .*from 1 on"),
    "no selection": ({"mode": "shear"}, "hold_out: .* is not a list, in brackets"),
}


@pytest.mark.parametrize("name", BAD_PARTS)
def test_a_bad_selection_is_refused(name):
    selections, message = BAD_PARTS[name]
    with pytest.raises(InputError, match=message):
        check_config({**CONFIG, "hold_out": selections}, SCHEMAS["config"], "mine.yaml")


def test_a_bad_format_is_refused():
    formats = {"bose": {"unit": {}}, "a b": {}}
    with pytest.raises(InputError, match=r"(?s)letters, digits.*formats.bose.unit: unknown name"):
        check_config({**CONFIG, "formats": formats}, SCHEMAS["config"], "mine.yaml")


def test_all_faults_of_a_table_are_named_at_once():
    wrong = table({"mode": "pull"}, {"record": "a.doc"}).drop(columns="group")
    message = r"(?s)column 'group' is missing.*row 2 .A1., column 'mode'.*row 3 .A1., column 'rec"
    with pytest.raises(InputError, match=message):
        check_samples(wrong, SCHEMAS["samples"], "t.tsv")


def test_each_missing_cell_is_named_once_and_spaces_in_place_of_tabs_as_such():
    with pytest.raises(InputError) as refused:
        check_samples(table({"group": "", "mode": "", "record": ""}), SCHEMAS["samples"], "t.tsv")
    told = str(refused.value)
    assert [told.count(f"{name!r}: is missing") for name in ("group", "mode", "record")] == [1] * 3
    spaced = dict.fromkeys(ROW, "") | {"sample": " ".join(ROW.values())}
    with pytest.raises(InputError, match="one cell; separate cells by tabs, .*spaces$") as refused:
        check_samples(table(spaced), SCHEMAS["samples"], "t.tsv")
    assert str(refused.value).count("row 2") == 1


def test_rows_are_lines_of_the_file(tmp_path):
    path = tmp_path / "samples.tsv"
    path.write_text("# a comment\n" + "\t".join(ROW) + "\n\n" + "\t".join(ROW.values()) + "x\n")
    with pytest.raises(
        InputError, match="row 4 .A1., column 'record': 'a.csvx' has a wrong extension"
    ):
        check_samples(read_samples(path), SCHEMAS["samples"], "t.tsv")


def test_a_table_without_a_required_column_or_row_is_refused():
    with pytest.raises(
        InputError, match="column 'mode' is missing .there are sample, group, image"
    ):
        check_samples(table({}).drop(columns="mode"), SCHEMAS["samples"], "t.tsv")
    with pytest.raises(InputError, match=r"t\.tsv has no rows; add one line"):
        check_samples(table({}).iloc[:0], SCHEMAS["samples"], "t.tsv")


INDENTED = {**CYLINDER, "mode": "indentation", "indenter": "sphere", "indenter_radius_mm": "2"}


@pytest.mark.parametrize("ends", ["", "bonded", "sliding", "0.2"])
def test_an_indented_sample_has_its_indenter_for_ends(ends):
    (row,) = check_samples(stated({**INDENTED, "ends": ends}), SCHEMAS["samples"], "t.tsv")
    held = {"": "bonded", "0.2": 0.2}.get(ends, ends)
    assert modelled_ends(row) == Indenter("sphere", 2e-3, held)


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        ({"indenter": ""}, "column 'indenter': is missing; give the kind"),
        ({"indenter": "cone"}, "column 'indenter': 'cone' is not one of sphere, flat"),
        ({"indenter_radius_mm": ""}, "column 'indenter_radius_mm': is missing"),
        ({"indenter_radius_mm": "2000"}, "2000 mm is no radius on this sample"),
        ({"mode": "compression"}, "belongs to mode indentation"),
        ({"ends": "unknown"}, "column 'ends': unknown on an indenter"),
    ],
)
def test_a_wrong_indenter_is_refused_with_its_cure(cells, message):
    with pytest.raises(InputError, match=message):
        check_samples(stated({**INDENTED, **cells}), SCHEMAS["samples"], "t.tsv")


def test_effects_that_may_be_absent_are_those_that_may_be_named():
    """But for what is stated otherwise: shapes, specimens and ends."""
    allowed = SCHEMAS["config"]["properties"]["loop"]["properties"]["absent"]["items"]["enum"]
    named = {name for name, effect in library().items() if effect.identifiable}
    assert set(allowed) == named - {"real_geometry", "specimen_stiffness"}
    config = copy.deepcopy(CONFIG)
    config["loop"]["absent"] = ["compressible_foam"]
    check_config(config, SCHEMAS["config"], "study.yaml")
    config["loop"]["absent"] = ["foam"]
    with pytest.raises(InputError, match=r"loop\.absent\.0.*foam"):
        check_config(config, SCHEMAS["config"], "study.yaml")
