"""Parts of the report page: what people read, and what the browser is given."""

import base64
import json
from pathlib import Path

import jinja2
import numpy as np
import pandas as pd
import pytest
import pyvista
import yaml
from docutils.utils import SystemMessage
from PIL import Image

from softsample.report.facts import findings_of, record_fact, sample_facts, verdict_sentence
from softsample.report.html import (
    as_json,
    caption,
    download,
    heading,
    markdown,
    parameters,
    picture,
    render_report,
    table,
    written,
)
from softsample.report.results import (
    in_brief,
    study_results,
    words_of_failure,
    words_of_success,
)
from softsample.report.scene import MOST_FACES, scene
from softsample.validation import refusals

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    ("column", "shown"),
    [
        ("mu_real_pa", "mu real [Pa]"),
        ("volume_real_mm3", "volume real [mm³]"),
        ("difference_percent", "difference [%]"),
        ("group", "group"),
        ("n", "n"),
    ],
)
def test_headings_carry_the_unit(column, shown):
    assert heading(column) == shown


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (-5.94211, "−5.94"),
        (123456.7, "123000"),
        (0.00123456, "0.00123"),
        (float("nan"), "–"),
        (None, "–"),
        (3, "3"),
        (True, "True"),
        ([-8.0, 16.0], "−8, 16"),
        ({"shear": "S1"}, "shear: S1"),
        ({}, "–"),
    ],
)
def test_values_as_people_write_them(value, shown):
    assert written(value) == shown


def test_a_table_leaves_out_empty_columns_and_obeys_no_tag():
    frame = pd.DataFrame({"group": ["<b>S1"], "mu_pa": [-1.5], "paper_mu_pa": [np.nan]})
    shown = table(frame)
    assert "mu [Pa]" in shown
    assert "paper" not in shown
    assert "&lt;b&gt;S1" in shown
    assert '<td class="number">−1.5</td>' in shown


def test_a_table_without_rows_says_so():
    assert "No rows" in table(pd.DataFrame(columns=["quantity", "mode"]))


def test_only_a_table_of_many_columns_is_wide():
    columns = {f"c{n}": [1.0] for n in range(11)}
    assert '<table class="wide">' in table(pd.DataFrame(columns))
    assert "wide" not in table(pd.DataFrame(columns).assign(c10=np.nan))  # left out


def test_markdown_goes_below_the_sections_and_takes_its_pictures_in(tmp_path):
    Image.new("RGB", (4, 3), "red").save(tmp_path / "a.png")
    text = "# Verdict\n\n| a |\n| --- |\n| <i>x</i> |\n\n![how](a.png)\n"
    html = markdown(text, {"a.png": tmp_path / "a.png"})
    assert "<h4>Verdict</h4>" in html
    assert "<table>" in html
    assert "<i>" not in html
    assert 'src="data:image/webp;base64,' in html
    assert 'width="4" height="3" alt="how"' in html


def test_a_picture_stays_what_it_is(tmp_path):
    Image.new("RGB", (40, 30), (200, 30, 60)).save(tmp_path / "a.png")
    (tmp_path / "a.webp").write_bytes(
        base64.b64decode(str(picture(tmp_path / "a.png", "")).split(",")[1].split('"')[0])
    )
    with Image.open(tmp_path / "a.webp") as image:
        assert image.size == (40, 30)
        np.testing.assert_allclose(np.asarray(image).mean(axis=(0, 1)), (200, 30, 60), atol=4)


def test_a_table_can_be_saved_out_of_the_page(tmp_path):
    (tmp_path / "t.csv").write_text("a\n1\n")
    link = download(tmp_path / "t.csv")
    assert 'download="t.csv"' in link
    assert base64.b64decode(link.split("base64,")[1].split('"')[0]) == b"a\n1\n"


def test_a_caption_that_quotes_an_unknown_number_is_refused(tmp_path):
    (tmp_path / "c.rst").write_text("**Figure.** Of |cohort|, {{ snakemake.wildcards.sample }}.")
    with pytest.raises(SystemMessage, match="cohort"):
        caption(tmp_path / "c.rst", {}, sample="C3")
    (tmp_path / "c.rst").write_text("**Figure.** {{ snakemake.wildcards.sample }}.")
    assert "<strong>Figure.</strong> C3." in caption(tmp_path / "c.rst", {}, sample="C3")


def test_data_cannot_end_its_script():
    text = as_json({"a": "</script><script>"})
    assert "<" not in text
    assert json.loads(text) == {"a": "</script><script>"}


def test_every_setting_is_listed_with_its_meaning():
    config = yaml.safe_load((ROOT / "config/config.yaml").read_text(encoding="utf-8"))
    schema = yaml.safe_load((ROOT / "workflow/schemas/config.schema.yaml").read_text("utf-8"))
    listed = {place: (value, meaning) for place, value, meaning in parameters(config, schema)}
    assert listed["mesh: element_size_mm"][0] == "0.5"
    assert "loop: noise: contact_zero_mm" in listed
    assert all(meaning for place, (_, meaning) in listed.items()), listed


def methods(real):
    """References, and the methods of a study with or without real geometries."""
    references = yaml.safe_load((ROOT / "workflow/report/references.yaml").read_text("utf-8"))
    config = yaml.safe_load((ROOT / "config/config.yaml").read_text(encoding="utf-8"))
    constants = ("bias_order", "smoothing_mm", "fluid_ratio", "starts_per_parameter")
    return references, render_report(
        ROOT / "workflow/report/methods.html.j2",
        config=config,
        references=references,
        imaged=real,
        real=real,
        ideal="cuboid",
        constants=dict.fromkeys(constants, 1),
    )


def test_the_methods_cite_every_reference_and_no_other():
    references, html = methods(real=True)
    for number, name in enumerate(references, start=1):
        assert f'<a href="#ref-{name}">[{number}]</a>' in html
        assert f'<li id="ref-{name}">' in html
    assert "hexahedra of 0.5 mm" in html
    assert "the bonded area" in html
    assert "evidence is at least 12 and" in html


def test_the_methods_tell_of_a_real_geometry_only_where_there_is_one():
    for words in ("real geometry", "Both geometries", "bonded area", "bond mask"):
        assert words in " ".join(methods(real=True)[1].split())
        assert words not in " ".join(methods(real=False)[1].split())


def test_the_bias_on_a_card_follows_from_the_moduli_beside_it():
    """It is against the calibrated modulus of the real shape, not against the one to quote."""
    loader = jinja2.FileSystemLoader(ROOT / "workflow/report")
    text = loader.get_source(jinja2.Environment(loader=loader), "report.html.j2")[0]
    card = text[text.index("{% for card in cards %}") : text.index("<h2>")]
    modulus = dict.fromkeys(("group", "verdict"), "G") | {"modulus to quote [Pa]": "1300 (1 to 2)"}
    for found, said in (
        (("1000 (900 to 1100)", "750", "-25.0 %"),
         "on the real shape: 1000 Pa; on the ideal one: 750 Pa, bias -25.0 %<"),
        (("750 (700 to 800)", "750", "not known"), "on the ideal shape: 750 Pa; bias not known<"),
    ):  # fmt: skip
        one = dict(zip(("calibrated [Pa]", "ideal shape [Pa]", "bias"), found, strict=True))
        html = jinja2.Template(card).render(cards=[modulus | one])
        assert f"Calibrated {said}" in " ".join(html.split())


def test_a_verdict_in_one_sentence():
    error = {"tension": {"all": {"rms_percent_structured": 2.0}},
             "compression": {"all": {"rms_percent_structured": 3.0}}}  # fmt: skip
    effects = [{"class": ["late_contact", "platen_tilt"]}]
    verdict = {
        "overloaded_N": {},
        "extrapolated_mm": {},
        "effects": effects,
        "error_before": error,
        "error_after": error,
    }
    assert verdict_sentence(verdict).startswith("Effects: late contact or platen tilt. Error")
    assert "3 % of peak before" in verdict_sentence(verdict)
    assert verdict_sentence({**verdict, "effects": []}).startswith("Error")
    noise = {"tension": {"all": {"rms_percent_structured": 0.0}}}
    assert verdict_sentence({**verdict, "error_after": noise}).endswith(
        "less than the noise after."
    )
    slides = verdict_sentence({**verdict, "effects": [{"class": ["ends"]}]})
    assert slides.startswith("Effects: sliding ends. Error")
    cut = verdict_sentence({**verdict, "overloaded_N": {"C1": -2.5}})
    assert cut.startswith("Load cell overloaded: C1 stays at -2.5 N. What lies beyond was not")
    assert "that is no test of this model. Effects: late contact" in cut


RECORD = {
    "samples": 120, "travel_mm": 4.0, "peak_force_N": 0.5, "force_noise_N": None,
    "phases": [{"kind": "ramp"}], "warnings": [],
}  # fmt: skip


def test_a_record_without_time_has_neither_rate_nor_speed():
    assert record_fact(RECORD) == "120 points; displacement 4 mm, peak 0.5 N, noise – N; ramp"
    timed = record_fact({**RECORD, "sampling_rate_hz": 50.0, "ramp_speed_mm_s": 0.5})
    assert timed.startswith("120 points at 50 Hz; displacement 4 mm, ramp 0.5 mm/s, peak")


def test_facts_of_a_sample_of_stated_dimensions():
    cylinder = {"shape": "cylinder", "diameter_mm": 20.0, "height_mm": 10.0}
    mesh = {"ideal": {"elements": 800, "min_scaled_jacobian": 0.5}}
    run = {"ideal": {"travel_mm": 4.0, "against_calibrated_curve_percent": 0.1}}
    facts = dict(sample_facts(RECORD, None, None, cylinder, mesh, run))
    assert list(facts) == ["Record", "Cylinder", "Meshes", "Run at the optimum"]
    assert facts["Cylinder"].startswith("diameter 20 mm, height 10 mm, as stated")
    assert "the bias, is not known" in facts["Cylinder"]
    assert facts["Run at the optimum"].startswith("ideal: nominal strain 0.4")


def test_facts_of_a_surface_have_no_film_and_no_sigma():
    cuboid = {"length_mm": 20.0, "width_mm": 10.0, "height_mm": 10.0}
    cuboid |= {"bottom_difference_percent": 1.0, "top_difference_percent": -20.0}
    segmented = {"volume_mm3": 1900.0, "boundary_sigma_mm": 0.1, "film_mm": 0.0, "tilt_deg": 2.0}
    facts = dict(sample_facts(RECORD, None, segmented, cuboid, {}, {}))
    assert facts["Surface"] == "1900 mm³, as given"
    image = {"shape": [40, 40, 20], "voxel_mm": [0.5, 0.5, 1.0]}
    facts = dict(sample_facts(RECORD, image, segmented, cuboid, {}, {}))
    assert facts["Surface"].endswith("film of 0 mm corrected for, tilt of 2° too")
    assert next(iter(facts)) == "Image"
    assert facts["Cuboid"] == (
        "20 × 10 × 10 mm; faces of the sample against it: bottom 1 %, top −20 %"
    )


def test_findings_of_a_group_name_geometry_and_model():
    sound = {"geometry": "real", "model": "ogden2", "success": True, "verdict": "converged"}
    fits = [sound, {**sound, "geometry": "ideal", "finding": "no second term"}]
    assert findings_of(fits) == ["ideal geometry, ogden2: no second term"]


def test_numbers_of_a_study_without_a_true_shape_follow_the_schema():
    """Bias null, real geometry absent; and what the schema requires is required."""
    fit = {
        "group": "D", "geometry": "ideal", "model": "ogden2", "samples": ["D1"],
        "alpha": [-8.0, 16.0], "poisson_ratio": 0.49, "area_error_percent": {"D1": 2.0},
        "success": True, "verdict": "converged",
    }  # fmt: skip
    rows = [{"modulus": name, "value_pa": 900.0, "low_pa": np.nan, "high_pa": np.nan}
            for name in ("mu", "mu1", "mu2")]  # fmt: skip
    intervals = pd.DataFrame(rows).assign(group="D", geometry="ideal", model="ogden2")
    verdict = {
        "verdict": "none", "overloaded_N": {}, "extrapolated_mm": {}, "effects": [],
        "error_before": {}, "error_after": {},
        "recommended": {"mu": {"value": 902.0, "low": 810.0, "high": 1200.0, "unit": "Pa"}},
    }  # fmt: skip
    cylinder = {"shape": "cylinder", "diameter_mm": 20.0, "length_mm": 20.0, "width_mm": 20.0}
    document = study_results(
        {"D1": {"group": "D", "mode": "pure_shear"}}, [{"record": RECORD}],
        [{**cylinder, "height_mm": 10.0, "ideal_area_mm2": 314.0}], [fit], intervals,
        {"D": verdict},
    )  # fmt: skip
    keys = ("rule", "versions", "settings", "settings_sha256", "inputs", "code_sha256")
    document["provenance"] = {key: {} for key in keys}
    schema = yaml.safe_load((ROOT / "workflow/schemas/results.schema.yaml").read_text("utf-8"))
    assert list(refusals(document, schema)) == []
    assert document["groups"]["D"]["bias_percent"] == {"ogden2": None}
    assert document["samples"]["D1"]["geometry"]["diameter_mm"] == 20.0
    assert document["samples"]["D1"]["record"]["ramp_speed_mm_s"] is None
    assert in_brief(document).splitlines()[1].split() == [
        "D", "902", "(810", "to", "1200)", "900", "900", "not", "known", "none"
    ]  # fmt: skip
    del document["groups"]["D"]["calibration"]["ideal"]
    assert [place for place, _ in refusals(document, schema)] == ["groups.D.calibration.ideal"]


def test_the_end_of_a_run_has_a_line_for_each_group_and_each_finding():
    def fit(value, low, high, finding=None):
        mu = {"value_pa": value, "low_pa": low, "high_pa": high}
        return {"ogden2": {"moduli": {"mu": mu}, "finding": finding}}

    groups = {
        "S1": {
            "calibration": {"real": fit(1128.2, 1098.0, 1157.4), "ideal": fit(1060.7, None, None)},
            "bias_percent": {"ogden2": -5.98},
            "verdict": {
                "verdict": "none", "overloaded_N": {"C1": -2.5, "C2": -2.5},
                "extrapolated_mm": {"C1": {"simulated": 4.0, "fitted": 8.0}}, "effects": [],
                "modulus_to_quote": {"value_pa": 1130.0, "low_pa": 1001.0, "high_pa": 1300.0},
            },
        },
        "TC1": {
            "calibration": {"real": fit(900.0, None, None), "ideal": fit(450.0, None, None, "no")},
            "bias_percent": {"ogden2": -50.0},
            "verdict": {
                "verdict": "explained", "overloaded_N": {}, "extrapolated_mm": {},
                "effects": [{"class": ["gain", "backlash"]}],
                "modulus_to_quote": {"value_pa": 870.0, "low_pa": 860.0, "high_pa": 880.0},
            },
        },
    }  # fmt: skip
    assert in_brief({"groups": groups}).splitlines() == [
        "group  modulus to quote [Pa]  calibrated [Pa]      ideal shape [Pa]  bias     verdict",
        "S1     1130 (1000 to 1300)    1130 (1100 to 1160)  1060              -6.0 %   none",
        "TC1    870 (860 to 880)       900                  450               -50.0 %  "
        "explained: gain|backlash",
        "S1: load cell overloaded, C1 stays at -2.5 N, C2 stays at -2.5 N",
        "S1: not simulated to the end, C1 to 4 of 8 mm",
        "TC1, ideal geometry, ogden2: no",
    ]


def unpacked(text, kind):
    return np.frombuffer(base64.b64decode(text), kind)


def block(cells):
    """Quads of a cube of 10 mm, with an unused point, that is pressed by a fifth."""
    surface = pyvista.Box((0, 10, 0, 10, 0, 10), level=cells, quads=True).clean()
    before = np.vstack([surface.points.astype(float), [[50.0, 50.0, 50.0]]])
    after = before * [1.0, 1.0, 0.8]
    return before, after, surface.faces.reshape(-1, 5)[:, 1:].astype(np.int64), before[:, 2]


def test_a_surface_comes_back_from_its_packed_form():
    before, after, faces, values = block(3)
    packed = scene({"real": (before, after, faces, values)})
    assert packed["limits"] == pytest.approx([0.0, np.percentile(values, 99.0)])
    shape = packed["surfaces"]["real"]
    assert shape["corners"] == 4
    points = shape["unit"] * unpacked(shape["before"], "<i2").reshape(-1, 3)
    moved = shape["unit"] * unpacked(shape["after"], "<i2").reshape(-1, 3)
    found = unpacked(shape["faces"], "<u2").reshape(-1, 4)
    assert len(points) == len(before) - 1  # without the unused one
    np.testing.assert_allclose(points[found], before[faces], atol=1e-3)
    np.testing.assert_allclose(moved[found], after[faces], atol=1e-3)


def test_a_fine_surface_is_decimated_and_keeps_its_shape():
    packed = scene({"real": block(60)})["surfaces"]["real"]
    faces = unpacked(packed["faces"], "<u2").reshape(-1, 3)
    assert len(faces) <= 1.02 * MOST_FACES
    moved = packed["unit"] * unpacked(packed["after"], "<i2").reshape(-1, 3)
    corners = moved[faces]
    volume = np.linalg.det(corners).sum() / 6.0
    assert volume == pytest.approx(800.0, rel=0.01)


def test_a_run_says_last_what_was_found_what_was_left_out_and_what_failed(tmp_path):
    failures = [("mesh/A", "too thin")]
    said = words_of_success("out", None, [], [])
    assert said == "Done. Results are below out/ (tables, figures, checks)."
    document = {"groups": {}}  # of verdicts alone there is no report
    assert words_of_success(str(tmp_path), document, [], []).endswith(f"Results: {tmp_path}")
    page = tmp_path / "report.html"
    page.touch()
    lines = words_of_success(str(tmp_path), document, ["A", "B"], failures).splitlines()
    assert lines[0].startswith("group  modulus to quote [Pa]")
    assert lines[1:] == [
        f"All tables and figures: {page}", "Left out: A, B", "  mesh/A: too thin"
    ]  # fmt: skip
    assert words_of_failure(failures).splitlines()[1:] == ["  mesh/A: too thin"]
    assert "run the same command again" in words_of_failure([])
