"""Tables and caption numbers against rows computed by hand, and the paper's values."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from softsample.errors import InputError
from softsample.report.captions import CaptionedStudy, caption_numbers, substitutions
from softsample.report.contact import contact_share, contact_table
from softsample.report.html import caption
from softsample.report.stress import mean_curve, nominal_curve, stress_strain_table
from softsample.report.tables import (
    direct_table,
    geometry_table,
    moduli_table,
    summary_table,
    table_shown,
)

ROOT = Path(__file__).resolve().parents[2]
PAPER = ROOT / "resources/paper"

TABLE_1 = [
    "group", "mode", "mu1_real_pa", "mu2_real_pa", "mu_real_pa",
    "mu1_ideal_pa", "mu2_ideal_pa", "mu_ideal_pa", "difference_percent",
    "paper_mu1_real_pa", "paper_mu2_real_pa", "paper_mu_real_pa",
    "paper_mu1_ideal_pa", "paper_mu2_ideal_pa", "paper_mu_ideal_pa", "paper_difference_percent",
    "mu_real_against_paper_percent", "mu_ideal_against_paper_percent",
    "difference_against_paper_points", "note",
]  # fmt: skip
SEEN = ("modelled", "geometries", "lines", "bars", "strain", "misfit_two_term")
"""What captions say of the geometries."""

TABLE_2 = [name for name in TABLE_1 if "mu1" not in name and "mu2" not in name]


@pytest.fixture
def paper():
    return pd.read_csv(PAPER / "moduli.csv", comment="#")


def fit(group, geometry, mu1, mu2, samples=("S1",), modes=("shear",), model="ogden2", **more):
    return {
        "group": group, "geometry": geometry, "model": model, "samples": list(samples),
        "modes": list(modes), "mu1_pa": mu1, "mu2_pa": mu2, "mu_pa": mu1 + mu2, "success": True,
        "verdict": "converged", "area_error_percent": dict.fromkeys(samples, 2.0), **more,
    }  # fmt: skip


def axial(group, geometry, mu1, mu2, model="ogden2"):
    return fit(group, geometry, mu1, mu2, ("T1", "C1"), ("tension", "compression"), model)


def test_a_round_sample_idealised_as_a_cuboid_is_noted(paper):
    fits = [fit("S1", "real", 700.0, 300.0), fit("S1", "ideal", 500.0, 250.0)]
    seen = {"shape": "cuboid", "proposed_shape": "cylinder", "circularity": 0.98}
    table, notes = moduli_table(fits, "ogden2", paper, {"S1": seen})
    said = "S1 looks round (circularity 0.98): if it is, write cylinder into column shape"
    assert table.loc[0, "note"] == said
    assert notes == [f"S1, {said}"]
    for other in ({**seen, "shape": "cylinder"}, {**seen, "proposed_shape": "cuboid"}):
        assert moduli_table(fits, "ogden2", paper, {"S1": other})[1] == []


def test_row_of_table_1_by_hand(paper):
    fits = [fit("S1", "real", 700.0, 300.0), fit("S1", "ideal", 500.0, 250.0)]
    table, notes = moduli_table(fits, "ogden2", paper)
    assert list(table.columns) == TABLE_1
    assert notes == []
    expected = ["S1", "shear", 700.0, 300.0, 1000.0, 500.0, 250.0, 750.0, -25.0]
    assert list(table.iloc[0])[:9] == expected
    assert list(table.iloc[0])[9:16] == [691.0, 440.4, 1131.4, 606.6, 461.6, 1068.2, -5.6]
    assert list(table.iloc[0])[16:] == [
        pytest.approx(100.0 * (1000.0 / 1131.4 - 1.0)),
        pytest.approx(100.0 * (750.0 / 1068.2 - 1.0)),
        pytest.approx(-19.4),
        "",
    ]


def test_row_of_table_2_has_the_name_of_the_compression_sample(paper):
    one = dict(samples=("C3",), modes=("compression",), model="ogden1")
    fits = [fit("TC3", "real", 1600.0, 0.0, **one), fit("TC3", "ideal", 800.0, 0.0, **one)]
    table, _ = moduli_table(fits, "ogden1", paper)
    assert list(table.columns) == TABLE_2
    assert list(table.iloc[0])[:8] == [
        "C3", "compression", 1600.0, 800.0, -50.0, 1543.9, 1013.5, -34.4
    ]  # fmt: skip


def test_a_group_that_lacks_the_ideal_geometry_is_left_out_with_a_note(paper):
    fits = [
        fit("S1", "real", 1.0, 1.0), fit("S1", "ideal", 1.0, 1.0), fit("S2", "real", 1.0, 1.0)
    ]  # fmt: skip
    table, notes = moduli_table(fits, "ogden2", paper)
    assert list(table["group"]) == ["S1"]
    assert notes == ["S2 is left out: no calibration on the ideal geometry"]


def test_a_group_whose_true_shape_is_not_known_has_no_bias(paper):
    fits = [fit("D", "ideal", 3.0, 1.0), fit("S1", "ideal", 1.0, 1.0), fit("S1", "real", 2.0, 1.0)]
    table, notes = moduli_table(fits, "ogden2", paper)
    assert list(table.columns) == TABLE_1
    row = table.set_index("group").loc["D"]
    assert row["mu_ideal_pa"] == 4.0
    assert row[["mu1_real_pa", "mu_real_pa", "difference_percent"]].isna().all()
    assert (
        row["note"]
        == "not all samples have an image or a surface: moduli of the ideal shape, bias not known"
    )
    assert notes == []
    summary = summary_table({"ogden2": table}, two_samples()).set_index("quantity")
    assert summary.loc["modulus_two_term", "count"] == 1  # S1 alone
    assert summary.loc["modulus_two_term", "mean_percent"] == pytest.approx(-100.0 / 3.0)


def test_a_finding_stands_in_the_note_in_place_of_mistrust(paper):
    second = "these data do not support a second term (mu1/mu = 1)"
    bad = {"success": False, "verdict": "not trusted; mu1_fraction at its maximum"}
    fits = [fit("S1", "ideal", 1.0, 1.0), fit("S1", "real", 1.0, 0.0, **bad, finding=second)]
    table, notes = moduli_table(fits, "ogden2", paper)
    assert table["note"].tolist() == [f"real geometry: {second}"]
    assert notes == [f"S1, real geometry: {second}"]


def test_many_samples_of_a_one_term_fit_have_the_name_of_their_group():
    for count, label in ((3, "C0+C1+C2"), (4, "G")):
        names = [f"C{k}" for k in range(count)]
        one = fit("G", "ideal", 1.0, 0.0, names, ["compression"] * count, "ogden1")
        assert moduli_table([one], "ogden1")[0]["group"].tolist() == [label]


def test_no_group_at_all_gives_an_empty_table_with_all_columns(paper):
    table, _ = moduli_table([], "ogden2", paper)
    assert list(table.columns) == TABLE_1
    assert table.empty


def test_a_fit_that_is_not_trusted_is_noted(paper):
    bad = {"success": False, "verdict": "not trusted; mu at its maximum"}
    fits = [fit("S1", "real", 1.0, 1.0, **bad), fit("S1", "ideal", 1.0, 1.0)]
    table, notes = moduli_table(fits, "ogden2", paper)
    assert notes == ["S1, real geometry: not trusted; mu at its maximum"]
    assert table["note"].tolist() == ["real geometry: not trusted; mu at its maximum"]


def test_the_same_result_twice_is_refused(paper):
    with pytest.raises(InputError, match="two calibrations on the real geometry"):
        moduli_table([fit("S1", "real", 1.0, 1.0)] * 2, "ogden2", paper)


@pytest.mark.parametrize("known", [True, False], ids=["unknown group", "own study"])
def test_a_group_that_the_paper_lacks_has_empty_columns(paper, known):
    fits = [fit("liver7", "real", 1.0, 1.0), fit("liver7", "ideal", 1.0, 1.0)]
    table, _ = moduli_table(fits, "ogden2", paper if known else None)
    assert list(table.columns) == TABLE_1
    assert table.filter(like="paper_").isna().all(axis=None)


def cuboid(bottom, top):
    return {
        "length_mm": 20.0, "width_mm": 10.0, "height_mm": 12.0, "volume_real_mm3": 2300.0,
        "bottom_area_mm2": bottom, "top_area_mm2": top, "ideal_area_mm2": 200.0,
    }  # fmt: skip


CYLINDER = {
    "shape": "cylinder", "diameter_mm": 20.0, "length_mm": 20.0, "width_mm": 20.0,
    "height_mm": 10.0, "ideal_area_mm2": 100.0 * np.pi,
}  # fmt: skip


def test_row_of_geometry_by_hand():
    table = geometry_table({"C1": cuboid(210.0, 150.0)}, {"C1": "compression"})
    assert dict(table.iloc[0]) == {
        "sample": "C1", "mode": "compression", "length_mm": 20.0, "width_mm": 10.0,
        "height_mm": 12.0, "volume_real_mm3": 2300.0,
        "bottom_area_real_mm2": 210.0, "bottom_area_ideal_mm2": 200.0,
        "bottom_difference_percent": pytest.approx(5.0),
        "top_area_real_mm2": 150.0, "top_area_ideal_mm2": 200.0,
        "top_difference_percent": pytest.approx(-25.0),
    }  # fmt: skip


def test_a_cylinder_of_stated_size_has_a_diameter_and_no_areas():
    shapes = {"C1": cuboid(210.0, 150.0), "D1": CYLINDER}
    table = geometry_table(shapes, dict.fromkeys(shapes, "compression"))
    assert list(table["diameter_mm"].fillna(0.0)) == [0.0, 20.0]
    row = table.iloc[1]
    unknown = ["length_mm", "width_mm", "volume_real_mm3", "top_area_real_mm2"]
    assert row[[*unknown, "bottom_difference_percent"]].isna().all()
    assert row["bottom_area_ideal_mm2"] == pytest.approx(314.159, abs=1e-3)
    summary = summary_table({}, table)
    assert list(summary["count"]) == [1, 1, 1]  # of C1 alone
    assert summary_table({}, table.iloc[1:]).empty


def two_samples():
    cuboids = {"S1": cuboid(210.0, 150.0), "S2": cuboid(180.0, 170.0)}
    return geometry_table(cuboids, {"S1": "shear", "S2": "shear"})


def test_means_and_deviations_by_hand(paper):
    fits = [
        fit("S1", "real", 500.0, 500.0), fit("S1", "ideal", 500.0, 400.0),
        fit("S2", "real", 500.0, 500.0), fit("S2", "ideal", 500.0, 200.0),
    ]  # fmt: skip
    moduli, _ = moduli_table(fits, "ogden2", paper)
    table = summary_table(
        {"ogden2": moduli}, two_samples(), pd.read_csv(PAPER / "summary.csv", comment="#")
    ).set_index(["quantity", "mode"])
    bias = table.loc[("modulus_two_term", "shear")]  # -10 and -30 percent
    assert bias["count"] == 2
    assert bias["mean_percent"] == pytest.approx(-20.0)
    assert bias["sd_percent"] == pytest.approx(np.sqrt(200.0))  # n - 1
    half = 6.313752 * 10.0  # Student's t at 95 % with one degree of freedom, times sd / sqrt(2)
    assert (bias["low_percent"], bias["high_percent"]) == pytest.approx((-20 - half, -20 + half))
    assert (bias["paper_mean_percent"], bias["paper_sd_percent"]) == (-10.0, 6.0)
    assert bias["against_paper_points"] == pytest.approx(-10.0)
    bottom = table.loc[("bottom_area_absolute", "all")]  # +5 and -10 percent
    assert bottom["mean_percent"] == pytest.approx(7.5)
    assert bottom["paper_mean_percent"] == 6.5
    assert table.loc[("bottom_area", "shear"), "mean_percent"] == pytest.approx(-2.5)
    assert table.loc[("top_area", "shear"), "mean_percent"] == pytest.approx(-20.0)


def test_printed_moduli_of_the_paper_agree_with_each_other(paper):
    """Typing errors show: mu = mu1 + mu2 and the difference follow within the last digit."""
    assert len(paper) == 15
    for side in ("real", "ideal"):
        two = paper[paper["table"] == 1]
        total = two[f"mu1_{side}_pa"] + two[f"mu2_{side}_pa"]
        np.testing.assert_allclose(total, two[f"mu_{side}_pa"], atol=0.1001)
    computed = 100.0 * (paper["mu_ideal_pa"] / paper["mu_real_pa"] - 1.0)
    np.testing.assert_allclose(computed, paper["difference_percent"], atol=0.0501)


def test_printed_means_of_the_paper_follow_from_its_tables(paper):
    """The text rounds to a whole or half percent."""
    summary = pd.read_csv(PAPER / "summary.csv", comment="#").set_index(["quantity", "mode"])
    shear = paper["group"].str.startswith("S")
    parts = {
        ("modulus_two_term", "shear"): paper[shear],
        ("modulus_two_term", "tension+compression"): paper[paper["group"].str.startswith("TC")],
        ("modulus_one_term", "compression"): paper[paper["table"] == 2],
    }
    for key, rows in parts.items():
        difference = rows["difference_percent"]
        assert len(difference) == 5
        assert summary.loc[key, "mean_percent"] == pytest.approx(difference.mean(), abs=0.1)
        assert summary.loc[key, "sd_percent"] == pytest.approx(difference.std(), abs=0.2)


def test_both_ways_to_calibrate_by_hand():
    start = {"starts": [{"evaluations": 10}, {"evaluations": 30}]}
    family = {**axial("TC1", "real", 800.0, 200.0), **start, "simulations": 0}
    direct = {**axial("TC1", "real", 803.0, 199.0), "starts": [{"evaluations": 45}]}
    direct |= {"simulations": 92, "simulations_cpu_s": 150.0}
    curves = [{"runs": [{}] * 6, "cpu_s": 20.0}, {"runs": [{}] * 6, "cpu_s": 30.5}]
    table = direct_table([(direct, family)], curves).set_index("method")
    assert table.loc["direct", "difference_percent"] == pytest.approx(0.2)
    assert table.loc["family", "difference_percent"] == 0.0
    assert list(table["evaluations"]) == [45, 40]
    assert list(table["simulations"]) == [92, 12]
    assert list(table["simulations_cpu_s"]) == [150.0, 50.5]


def test_nominal_curve_by_hand():
    shape = {"ideal_area_mm2": 200.0, "height_mm": 10.0}
    strain, stress = nominal_curve(np.array([2e-3, 0.0]), np.array([0.8, 0.0]), shape)
    np.testing.assert_allclose(strain, [0.0, 0.2])
    np.testing.assert_allclose(stress, [0.0, 4000.0])


def test_mean_curve_ends_with_the_shortest_and_has_the_deviation():
    steep = (np.array([0.0, 0.2]), np.array([0.0, 40.0]))
    flat = (np.array([0.0, 0.1]), np.array([0.0, 10.0]))
    table = mean_curve([steep, flat], points=3)
    np.testing.assert_allclose(table["strain"], [0.0, 0.05, 0.1])
    np.testing.assert_allclose(table["mean_stress_pa"], [0.0, 7.5, 15.0])
    np.testing.assert_allclose(table["sd_stress_pa"], np.array([0.0, 5.0, 10.0]) / np.sqrt(2.0))
    assert mean_curve([flat], points=3)["sd_stress_pa"].isna().all()


def contact_run(*areas_mm2):
    moved = -1.2 * np.arange(1, len(areas_mm2) + 1)  # a strain of 0.1 each, in compression
    return pd.DataFrame({"displacement_mm": moved, "contact_area_m2": np.multiply(1e-6, areas_mm2)})


def test_contact_area_by_hand():
    share = contact_share(contact_run(50.0, 150.0), cuboid(0.0, 0.0))
    np.testing.assert_allclose(share["strain"], [0.1, 0.2])
    np.testing.assert_allclose(share["share_percent"], [25.0, 75.0])
    shorter = contact_share(contact_run(30.0, 130.0), cuboid(0.0, 0.0)).iloc[:2]
    table = contact_table({("C1", "real"): share, ("C2", "real"): shorter, ("C1", "ideal"): share})
    np.testing.assert_allclose(table["strain"], [0.1, 0.125, 0.15, 0.175, 0.2])
    np.testing.assert_allclose(table["real_percent"].iloc[[0, -1]], [20.0, 70.0])
    np.testing.assert_allclose(table["real_sd_percent"], np.sqrt(50.0))
    np.testing.assert_allclose(table["ideal_percent"].iloc[2], 50.0)
    assert table["ideal_sd_percent"].isna().all()


def captioned(tables, fits, cohort="study a", shipped=False, **changes):
    how = {"geometries": ("real", "ideal"), "samples": 2, "imaged": 2, "surfaces": 0,
           "ideal": "cuboid"} | changes  # fmt: skip
    meshes = [{"elements": 40633}, {"elements": 36244}][-len(how["geometries"]) :]
    study = CaptionedStudy(cohort=cohort, shipped=shipped, shown="S1", **how)
    return caption_numbers(study, *tables, fits, meshes)


def study_numbers(shipped=True, **changes):
    fits = [fit("S1", "real", 500.0, 500.0, **changes), fit("S1", "ideal", 500.0, 400.0)]
    moduli, _ = moduli_table(fits, "ogden2")
    stress = stress_strain_table([("shear", np.array([0.0, 0.3]), np.array([0.0, 500.0]))])
    summary = summary_table({"ogden2": moduli}, two_samples())
    return captioned((summary, stress), fits, "virtual cohort", shipped)


def test_caption_numbers():
    numbers = study_numbers()
    assert numbers["bias_two_term"] == "−10.0 % in shear (n = 1)"
    assert numbers["bias_one_term"] == "no such sample in this study"
    assert numbers["stress_at_end"] == "0.50 kPa at strain 0.30 in shear"
    assert "recovered" in numbers["materials"]
    assert "recovered" not in study_numbers(shipped=False)["materials"]


def dimensions_only(*more, **how):
    fits = [fit("D", "ideal", 3.0, 1.0, ("D1",), ("pure_shear",)), *more]
    moduli, _ = moduli_table(fits, "ogden2")
    stress = stress_strain_table([("pure_shear", np.array([0.0, 0.3]), np.array([0.0, 500.0]))])
    summary = summary_table({"ogden2": moduli}, geometry_table({"D1": CYLINDER}, {"D1": "shear"}))
    return captioned((summary, stress), fits, **how)


def test_captions_say_that_the_bias_is_not_known_without_a_true_shape():
    numbers = dimensions_only(imaged=0, geometries=("ideal",), ideal="cylinder")
    assert numbers.keys() == study_numbers().keys()
    unknown = "not known without an image or a surface of all samples of a group"
    assert numbers["bias_two_term"] == unknown
    assert numbers["top_area"] == numbers["bias_two_term"]
    assert numbers["modelled"].startswith("meshed as a cylinder of the stated dimensions")
    assert numbers["elements_ideal"] == "36244"
    assert numbers["stress_at_end"].endswith("in pure shear")
    assert "real" not in " ".join(numbers[name] for name in SEEN)
    assert numbers["geometries"] == "on the idealised cylinder"


def test_captions_of_a_mixed_study_say_what_is_known_of_which():
    whole = study_numbers()
    assert whole["modelled"] == "segmented in their images, meshed as they are and as a cuboid"
    assert whole["geometries"] == "on the real geometry and on the idealised cuboid"
    real = [fit("S1", geometry, 3.0, 1.0) for geometry in ("real", "ideal")]
    numbers = dimensions_only(*real, samples=7, imaged=3, surfaces=1)
    mixed, part = numbers["modelled"], "where the shapes of all samples of a group are known,"
    assert mixed == (
        f"meshed as they are (3 with an image and 1 with a surface), {part} and as a cuboid (3 by "
        "the stated dimensions alone)"
    )
    assert part in numbers["geometries"]
    assert f"{part[:-1]}; last" in numbers["strain"]
    surfaces = dimensions_only(*real[:1], samples=2, imaged=0, surfaces=2)["modelled"]
    assert surfaces.startswith("meshed as they are (2 with a surface), where")
    assert surfaces.endswith("are known, and as a cuboid")


def test_a_group_with_one_shape_that_is_not_known_has_no_real_geometry_in_the_captions():
    numbers = dimensions_only(samples=2, imaged=1, surfaces=0)
    assert "no group has an image or a surface of all its samples" in numbers["modelled"]
    assert numbers["bias_two_term"].startswith("not known without")
    assert not [name for name in SEEN if "real" in numbers[name]]


def test_a_doubtful_fit_is_named_in_the_captions():
    bad = {"success": False, "verdict": "not trusted; mu at its maximum"}
    assert "converged" in study_numbers()["trust"]
    assert "S1 (ogden2, real geometry: not trusted" in study_numbers(**bad)["trust"]


@pytest.mark.parametrize(
    "path", sorted((ROOT / "workflow/report").glob("*.rst")), ids=lambda p: p.stem
)
def test_captions_quote_only_numbers_and_settings_that_exist(path, tmp_path):
    (tmp_path / "tables").mkdir()
    (tmp_path / "tables/numbers.rst").write_text(substitutions(study_numbers()), encoding="utf-8")
    config = yaml.safe_load((ROOT / "config/config.yaml").read_text(encoding="utf-8"))
    html = caption(path, {**config, "results": str(tmp_path)}, sample="C3")
    assert "virtual cohort" in html
    assert "|" not in html


def intervals_of(*groups):
    rows = [
        {"group": group, "geometry": geometry, "model": "ogden1", "modulus": "mu",
         "low_pa": 0.9 * value, "high_pa": 1.1 * value}
        for group, geometry, value in groups
    ]  # fmt: skip
    return pd.DataFrame(rows)


def test_the_report_shows_seven_columns_of_the_moduli():
    saved = pd.DataFrame(
        {
            "group": ["C1", "C2"],
            "mode": "compression",
            "mu_real_pa": [1234.0, np.nan],
            "mu_ideal_pa": [617.0, 500.0],
            "difference_percent": [-50.0, np.nan],
            "paper_mu_real_pa": [1314.0, 1675.0],
            "paper_difference_percent": [-54.4, -54.8],
            "note": ["", "bias not known"],
        }
    )
    intervals = intervals_of(
        ("TC1", "real", 1234.0), ("TC1", "ideal", 1.0), ("TC2", "ideal", 500.0)
    )
    groups = {"C1": "TC1", "C2": "TC2"}
    shown = table_shown("table2", saved, intervals, groups, 0.9)
    assert list(shown) == [
        "group", "mu_with_90_%_interval_pa", "trusted", "mode", "mu_ideal_pa",
        "difference_percent", "paper_difference_percent",
    ]  # fmt: skip
    assert shown["mu_with_90_%_interval_pa"].tolist() == ["1230 (1110 to 1360)", "500 (450 to 550)"]
    assert shown["trusted"].tolist() == ["yes", "bias not known"]
    ideal = table_shown("table2", saved.assign(mu_real_pa=np.nan), intervals, groups, 0.9)
    assert list(ideal) == list(shown)[:4]
    assert "mu_with_95_%_interval_pa" in table_shown("table2", saved, intervals, groups, 0.95)
    assert table_shown("geometry", saved, intervals, groups, 0.9) is saved


def test_the_report_shows_mu_with_its_two_largest_terms():
    terms = {f"{name}_percent": 0.0 for name in ("statistics", "geometry", "time", "hourglass")}
    terms |= {"contact_zero_percent": np.nan, "mesh_percent": 1.745, "bond_percent": 6.796}
    rows = [
        {"group": "S1", "geometry": "real", "model": "ogden2", "modulus": name, "value_pa": 1124.2,
         "low_pa": 994.1, "high_pa": 1254.35, **terms, "element_percent": 0.39}
        for name in ("mu", "mu1", "mu2")
    ]  # fmt: skip
    (shown,) = table_shown("intervals", pd.DataFrame(rows), None, {}, 0.9).to_dict("records")
    assert shown == {
        "group": "S1", "geometry": "real", "model": "ogden2",
        "mu_with_90_%_interval_pa": "1120 (994 to 1250)",
        "largest_terms": "bond 6.8 %, mesh 1.75 %",
    }  # fmt: skip


def test_what_is_below_rounding_or_noise_is_told_in_words():
    changes = pd.DataFrame(
        {"change": ["a"], "modulus_percent": [-3.28e-5], "end_percent": [-1.234]}
    )
    (shown,) = table_shown("sensitivity", changes, None, {}, 0.9).to_dict("records")
    assert shown == {"change": "a", "modulus_percent": "< 0.01", "end_percent": "−1.23"}
    errors = {"mu_pa": [0.0], "error_after_percent": [0.0], "held_out_after_percent": [2.1153]}
    (shown,) = table_shown("loop", pd.DataFrame(errors), None, {}, 0.9).to_dict("records")
    assert shown == {
        "mu_pa": 0.0, "error_after_percent": "< noise", "held_out_after_percent": "2.12",
    }  # fmt: skip
