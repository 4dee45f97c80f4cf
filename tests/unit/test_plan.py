"""What is computed for which rows: every mix of shapes, modes and repeats."""

import pytest

from softsample.errors import InputError
from softsample.study.plan import Plan

CUBOID = {"shape": "cuboid", "length_mm": "20", "width_mm": "18", "height_mm": "12"}
CYLINDER = {"shape": "cylinder", "diameter_mm": "20", "height_mm": "12"}


def row(group, mode, **cells):
    return {"group": group, "mode": mode, "record": "r.csv", **cells}


def mixed():
    """A group with images, one with a surface, and one with dimensions and repeated tests."""
    return Plan(
        {
            "T1": row("TC1", "tension", image="t1.nii"),
            "C1": row("TC1", "compression", image="c1.nii"),
            "S": row("S", "shear", surface="s.stl"),
            "A1": row("A", "compression", **CYLINDER),
            "A2": row("A", "compression", **CYLINDER, loading_axis="+z"),
            "A3": row("A", "tension", **CYLINDER),
            "A4": row("A", "compression", **CYLINDER, ends="sliding"),
            "B1": row("B", "compression", **CYLINDER),
        }
    )


def test_only_a_group_whose_shapes_are_all_known_has_the_real_geometry():
    plan = mixed()
    assert plan.geometries("TC1") == plan.geometries("S") == ["real", "ideal"]
    assert plan.geometries("A") == plan.geometries("A2") == ["ideal"]
    assert (plan.best("C1"), plan.best("A1")) == ("real", "ideal")
    half = Plan({"a": row("G", "shear", image="a.nii"), "b": row("G", "tension", **CUBOID)})
    assert half.geometries("a") == ["ideal"]
    assert half.imaged == ["a"]
    assert half.banded == []


def test_equal_pieces_share_what_the_first_has():
    plan = mixed()
    assert plan.pieces == ["T1", "C1", "S", "A1", "A3", "A4", "B1"]  # +z is the default
    assert plan.piece_of["A2"] == "A1"
    assert plan.same_piece("A1") == ["A1", "A2"]
    assert plan.pieces_of("A") == ["A1", "A3", "A4"]  # other mode, other ends
    assert plan.piece_of["B1"] == "B1"  # another group is another material


@pytest.mark.parametrize(
    "cell", ["image", "shape", "height_mm", "segmentation", "bond_mask", "labels", "shear_axis"]
)
def test_another_cell_of_the_geometry_is_another_piece(cell):
    same = {"a": row("G", "shear", **CUBOID), "b": row("G", "shear", **CUBOID)}
    assert Plan(same).pieces == ["a"]
    same["b"][cell] = "+y"
    assert Plan(same).pieces == ["a", "b"]


def test_the_record_and_its_machine_make_no_piece():
    cells = {"record": "x.csv", "format": "other", "cycle": "last", "specimen": "x"}
    rows = {"a": row("G", "shear", **CUBOID), "b": {**row("G", "shear", **CUBOID), **cells}}
    assert Plan(rows).pieces == ["a"]


def test_one_term_is_calibrated_on_compression_alone():
    plan = mixed()
    assert plan.members("TC1", "ogden2") == ["T1", "C1"]
    assert plan.members("TC1", "ogden1") == ["C1"]
    assert plan.members("A", "ogden1") == ["A1", "A2", "A4"]
    assert plan.models("S") == ["ogden2"]
    assert plan.sample_models("A3") == ["ogden2"]
    other = Plan({"a": row("G", "confined_compression", **CUBOID)})
    assert other.models("G") == ["ogden2"]


def test_a_model_of_held_out_samples_alone_is_not_calibrated():
    rows = {name: {**row, "sample": name} for name, row in mixed().rows.items()}
    assert Plan(rows, [{"sample": "C1"}]).models("TC1") == ["ogden2"]
    held = Plan(rows, [{"sample": ["A1", "A2"]}, {"sample": "S", "strain_above": 0.1}])
    assert held.held_out == {"A1", "A2"}
    assert held.models("A") == ["ogden2", "ogden1"]  # A4 is left


def test_curves_are_those_of_pieces_on_their_geometries():
    plan = mixed()
    assert [run for run in plan.runs if run[0] in plan.groups["TC1"]] == [
        ("T1", "real"), ("T1", "ideal"), ("C1", "real"), ("C1", "ideal")
    ]  # fmt: skip
    of_a = [curve for curve in plan.curves if curve[0].startswith("A")]
    assert of_a == [
        ("A1", "ideal", "ogden2"), ("A1", "ideal", "ogden1"), ("A3", "ideal", "ogden2"),
        ("A4", "ideal", "ogden2"), ("A4", "ideal", "ogden1"),
    ]  # fmt: skip
    assert plan.banded == ["T1", "C1"]  # a surface has no standard deviation


def test_bonded_are_real_shapes_that_no_platen_presses_and_no_mask_marks():
    assert mixed().bonded == ["T1", "S"]
    masked = Plan({"S": row("S", "shear", image="s.nii", bond_mask="m.nii")})
    assert masked.bonded == []


def test_examples_are_pieces():
    plan = mixed()
    assert plan.examples({}) == {"shear": "S", "tension": "T1", "compression": "C1"}
    assert plan.examples({"compression": "A2"})["compression"] == "A1"
    assert plan.examples({"shear": "C1"})["shear"] == "S"  # C1 is no test in shear


def test_figure_2_shows_the_compression_example_or_what_has_an_image():
    plan = mixed()
    assert plan.shown(plan.examples({})) == "C1"
    one = Plan({"a": row("A", "compression", **CUBOID), "b": row("B", "shear", image="b.nii")})
    assert one.shown(one.examples({})) == "b"
    none = Plan({"a": row("A", "shear", **CUBOID), "b": row("B", "compression", **CUBOID)})
    assert none.shown(none.examples({})) == "b"


def test_names_that_are_not_there_are_refused_with_those_that_are():
    plan = mixed()
    for ask, message in (
        (plan.row, "no sample 'Z' in the table; there are T1, C1, S"),
        (plan.same_piece, "no sample 'Z'"),
        (plan.geometries, "no sample 'Z'"),
        (plan.samples_of, "no group 'Z' in the table; there are TC1, S, A, B"),
        (plan.diagnosed, "no group 'Z'"),
        (plan.is_told, "no group 'Z'"),
    ):
        with pytest.raises(InputError, match=message):
            ask("Z")


def animals(number, **cells):
    """Compression and tension of as many animals, and one of known shape."""
    rows = {f"I{end}": row("I", "tension", image=f"{end}.nii") for end in "12"}
    for k in range(number):
        for mode in ("compression", "tension"):
            rows[f"{mode[0]}{k}"] = row(f"G{k}", mode, **CUBOID, **cells)
    return {name: {**cells, "sample": name} for name, cells in rows.items()}


def test_a_verdict_takes_files_of_groups_that_are_left_out_or_whose_ends_are_open():
    rows = animals(2)
    assert Plan(rows).pooled == Plan(rows, leave_out="mode").pooled == []
    left_out = Plan(rows, leave_out="group")
    assert left_out.pooled == ["G0", "G1"]  # the shape of I is known better: another bias
    assert left_out.diagnosed("G0") == ["c0", "t0", "c1", "t1"]
    assert left_out.diagnosed("I") == ["I1", "I2"]
    opened = Plan(animals(2, ends="unknown"))
    assert opened.pooled == ["G0", "G1"]
    assert opened.open_others("G0") == ["G1"]
    assert opened.open_others("I") == []
    assert opened.opened(["c0", "I1"]) == ["c0", "I1"]
    assert opened.opened(["I1", "I2"]) == []


def test_others_tell_of_a_group_whose_records_are_held_out_if_they_are_enough():
    held = [{"strain_above": 0.15}]
    few, enough = (Plan(animals(n), held, "group") for n in (3, 4))
    assert not few.is_told("G0")
    assert few.pool("ideal") == []
    assert enough.is_told("G0")
    assert not enough.is_told("I")
    assert enough.in_turn("ideal") == {f"G{k}": [f"c{k}", f"t{k}"] for k in range(4)}
    assert enough.pool("ideal") == [f"{mode}{k}" for k in range(4) for mode in "ct"]
    assert enough.in_turn("real") == {}
    assert few.diagnosed("G0") == [f"{mode}{k}" for k in range(3) for mode in "ct"]
    assert enough.diagnosed("G0") == ["c0", "t0"]
    assert few.folds("G0") == {"leave_out_G0": ["c0", "t0"]}
    assert enough.folds("G0") == {}
    assert Plan(animals(1), leave_out="mode").folds("G0") == {
        "leave_out_compression": ["c0"], "leave_out_tension": ["t0"]
    }  # fmt: skip
    assert Plan(animals(1), leave_out="mode").folds("I") == Plan(animals(1)).folds("G0") == {}


def test_sliding_ideal_shapes_need_no_run_and_other_pieces_do():
    plan = mixed()
    assert plan.has_closed_form("A4", "ideal")
    assert not plan.has_closed_form("A1", "ideal")
    assert plan.has_closed_form("A1", "ideal", "sliding")
    assert not plan.has_closed_form("A4", "real")
    assert plan.simulated("A") == ["A1", "A3"]
    assert (plan.coarsening(2, "A4", "ideal"), plan.coarsening(2, "A1", "ideal")) == (2, 2)
    assert (plan.coarsening(1, "A4", "ideal"), plan.coarsening(1, "A1", "ideal")) == (2, 1)


def test_a_diagnosis_is_told_whose_top_is_bonded_by_a_rule():
    plan = mixed()
    samples = plan.diagnosed("TC1")
    assert plan.bonded_by_rule(samples) == [True, False]
    assert plan.only_bonded(samples) == plan.bonded_of("TC1") == ["T1"]
    assert not any(plan.bonded_by_rule(plan.diagnosed("A")))


def test_the_ideal_shape_in_words():
    assert mixed().ideal_shape == "cuboid or cylinder"
    assert Plan({"a": row("G", "shear", image="a.nii")}).ideal_shape == "cuboid"
    assert Plan({"a": row("G", "tension", **CYLINDER)}).ideal_shape == "cylinder"


def test_a_name_with_two_meanings_is_refused():
    rows = {"B": row("A", "shear", **CUBOID), "c": row("B", "shear", image="c.nii")}
    with pytest.raises(InputError, match="'B' is a sample of group 'A' and the name of a group"):
        Plan(rows)
    rows["B"]["group"] = "B"
    assert Plan(rows).geometries("B") == ["ideal"]


def test_experiments_on_shape_need_known_bonded_shapes_each_tested_once():
    whole = {"T1": row("TC1", "tension", image="t1.nii"), "S": row("S", "shear", surface="s.stl")}
    Plan(whole).check_alike()
    again = row("TC1", "tension", image="t1.nii")
    for other, what in (
        (row("A", "tension", **CYLINDER), "'X' has neither image nor surface"),
        (row("S", "compression", surface="s.stl", ends="sliding"), "ends that are not bonded"),
        (again, "'X' has the piece of 'T1'.*each tested once"),
    ):
        with pytest.raises(InputError, match=what):
            Plan({**whole, "X": other}).check_alike()
    with pytest.raises(InputError, match="whole records"):
        Plan(whole, [{"strain_above": 0.2}]).check_alike()
