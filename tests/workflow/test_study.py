"""Whole studies of small samples, from images and records to the report."""

import json
import os
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import toy
import yaml
from browser import CHROMIUM, Browser
from jsonschema import Draft202012Validator

from softsample.loop.confirm import SIMULATED

pytestmark = pytest.mark.study

ROOT = Path(__file__).resolve().parents[2]


def workflow_on(table, results):
    """Runs the workflow in this checkout, so that compiled kernels are shared."""
    settings = [f"samples={table}", f"results={results}"]
    command = [sys.executable, "-m", "snakemake", "--cores", "2"]
    options = ["--configfile", "config/test.yaml", "--config", *settings]

    def run(*arguments):
        done = subprocess.run(
            [*command, *arguments, *options],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout[-5000:]
        return done.stdout

    return run


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Three animals: tension and compression of one, shear of two."""
    folder = tmp_path_factory.mktemp("toy study")  # with a space in its name
    run = workflow_on(toy.write_study(folder, toy.THREE_ANIMALS), folder / "results")
    (folder / "printed.txt").write_text(run())
    return folder / "results", run


def load(results, name):
    return json.loads((results / name).read_text())


def test_all_checks_passed(study):
    results, _ = study
    passed = load(results, "checks/passed.json")
    assert passed["passed"] is True
    assert passed["checks"] == 8 * 7 + 4 + 2 + 2


def test_the_cuboid_has_the_size_that_was_drawn(study):
    results, _ = study
    for sample in "ABDE":
        cuboid = load(results, f"cuboid/{sample}.json")
        # edges are rounded, so the mean widths are below the extent and above it less the radius
        assert toy.LENGTH - 1.0 < cuboid["length_mm"] < toy.LENGTH + 0.1
        assert toy.WIDTH - 1.0 < cuboid["width_mm"] < toy.WIDTH + 0.1
        # the top waves by half a millimetre about the height
        assert cuboid["height_mm"] == pytest.approx(toy.HEIGHT, abs=0.35)
        assert cuboid["highest_point_mm"] == pytest.approx(toy.HEIGHT + 0.5, abs=0.25)


def test_calibrated_curves_follow_the_records(study):
    results, _ = study
    for geometry in ("real", "ideal"):
        fit = load(results, f"calibration/AB/{geometry}/ogden2.json")
        assert fit["samples"] == ["A", "B"]
        assert fit["mu_pa"] == pytest.approx(fit["mu1_pa"] + fit["mu2_pa"])
        curve = pd.read_csv(results / f"calibration/AB/{geometry}/ogden2.csv")
        for sample, part in curve.groupby("sample"):
            area = np.trapezoid(abs(part.measured_N - part.model_N), abs(part.displacement_mm))
            under = np.trapezoid(abs(part.measured_N), abs(part.displacement_mm))
            # noisy displacements are sorted before the fit integrates, hence the loose match
            assert 100.0 * area / under == pytest.approx(
                fit["area_error_percent"][sample], rel=0.3, abs=0.5
            )
            assert area < 0.25 * under


def test_the_tables_hold_the_calibrated_moduli_and_no_value_of_the_paper(study):
    results, _ = study
    table = pd.read_csv(results / "tables/table1.csv").set_index("group")
    real, ideal = (
        load(results, f"calibration/AB/{geometry}/ogden2.json")["mu_pa"]
        for geometry in ("real", "ideal")
    )
    assert table.loc["AB", "mu_real_pa"] == pytest.approx(real)
    assert table.loc["AB", "difference_percent"] == pytest.approx(100.0 * (ideal / real - 1.0))
    assert table.filter(like="paper").isna().all(axis=None)
    assert pd.read_csv(results / "tables/table2.csv")["group"].tolist() == ["B"]


def test_every_animal_has_its_row_and_its_share_in_the_means(study):
    results, _ = study
    moduli = pd.read_csv(results / "tables/table1.csv")
    assert moduli["group"].tolist() == ["AB", "D", "E"]
    assert moduli["mode"].tolist() == ["tension+compression", "shear", "shear"]
    means = pd.read_csv(results / "tables/summary.csv").set_index(["quantity", "mode"])
    assert means.loc[("bottom_area_absolute", "all"), "count"] == 4
    shear, single = (
        means.loc[key]
        for key in (("modulus_two_term", "shear"), ("modulus_one_term", "compression"))
    )
    assert (shear["count"], single["count"]) == (2, 1)
    assert shear["low_percent"] < shear["mean_percent"] < shear["high_percent"]
    assert single[["sd_percent", "low_percent", "high_percent"]].isna().all()
    contact = pd.read_csv(results / "tables/contact.csv")
    assert (contact["real_percent"] < contact["ideal_percent"]).all()
    assert (contact["ideal_percent"] > 99.0).all()


@pytest.mark.long
def test_effects_of_the_geometry_are_found_on_demand(study):
    results, run = study
    run("geometry_effects")
    shares = pd.read_csv(results / "tables/bias_shares.csv")
    assert set(zip(shares["group"], shares["terms"], strict=True)) == {
        ("AB", 2), ("AB", 1), ("D", 2), ("E", 2),
    }  # fmt: skip
    parts = shares[["late_contact", "outline", "areas"]].sum(axis=1)
    np.testing.assert_allclose(parts, shares["bias_percent"], atol=1e-6)
    assert (shares.loc[shares["group"] == "AB", "late_contact"] < 0.0).all()
    assert pd.read_csv(results / "tables/cohort_needed.csv").empty  # the paper is not asked
    prescribed = pd.read_csv(results / "tables/prescribed.csv").set_index(["sample", "geometry"])
    assert prescribed["agrees_2_percent_strain"].loc[:, "ideal"].min() > 0.1
    assert prescribed["agrees_2_percent_strain"].loc[:, "real"].max() == 0.0


@pytest.mark.long
def test_effects_of_a_verdict_are_run_at_their_sizes_on_demand(study):
    results, run = study
    run("verdicts")
    target = results / "tables/confirmation.csv"
    run(str(target))
    table = pd.read_csv(target)
    ranked = load(results, "loop/AB/verdict.json")["path"][0]["candidates"]
    wanted = [c["name"] for c in ranked if c["name"] in SIMULATED and c["evidence"] > 0.0][:3]
    assert wanted
    assert table.loc[table["group"] == "AB", "effect"].tolist() == wanted
    assert (table["confirmed"] == (table["evidence_confirmed"] >= table["threshold"])).all()
    assert (table["difference_percent"] > 0.0).all()


@pytest.mark.long
def test_a_study_of_one_shear_sample_has_its_tables_and_no_others(study, tmp_path):
    """The sample's own results are taken over from the larger study, as if it had shrunk."""
    results, run_larger = study
    run_larger("geometry_effects")
    table = toy.write_study(tmp_path, toy.SHEAR_ALONE)
    of_sample = ("inputs", "segmentation", "cuboid", "mesh", "curves", "fields", "sensitivity")
    for folder in (*of_sample, "records", "band", "calibration", "loop", "geometry_effects"):
        for path in [*(results / folder).rglob("D*"), *(results / folder).rglob("D/**/*")]:
            if path.is_file():
                target = tmp_path / "results" / path.relative_to(results)
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(path, target)
    for path in [table, *tmp_path.glob("D.*")]:
        os.utime(path, (0, 0))  # older than the results
    run = workflow_on(table, tmp_path / "results")
    printed = run("all", "geometry_effects")
    assert "Segment the image" not in printed
    made = tmp_path / "results"
    moduli = pd.read_csv(made / "tables/table1.csv")
    assert moduli["group"].tolist() == ["D"]
    expected = pd.read_csv(results / "tables/table1.csv").set_index("group").loc["D"]
    assert moduli["mu_real_pa"][0] == expected["mu_real_pa"]
    lacking = {"table2", "contact", "prescribed", "figure6"}  # of compression alone
    on_demand = {"confirmation"}
    for pattern in ("tables/*.csv", "figures/*.png"):
        larger, own = ({path.stem for path in at.glob(pattern)} for at in (results, made))
        assert larger & lacking
        assert own == larger - lacking - on_demand
    assert set(pd.read_csv(made / "tables/summary.csv")["mode"]) == {"all", "shear"}
    assert load(made, "checks/passed.json")["passed"] is True
    page = (made / "report.html").read_text(encoding="utf-8")
    assert "no such sample in this study" in page
    assert "System Message" not in page


def test_the_numbers_of_the_study_follow_the_published_schema(study):
    results, _ = study
    document = load(results, "results.json")
    schema = yaml.safe_load((ROOT / "workflow/schemas/results.schema.yaml").read_text("utf-8"))
    Draft202012Validator(schema).validate(document)
    assert list(document["samples"]) == ["A", "B", "D", "E"]
    fit = document["groups"]["AB"]["calibration"]["real"]
    assert set(fit) == {"ogden1", "ogden2"}
    moduli = fit["ogden2"]["moduli"]
    assert moduli["mu"]["value_pa"] == pytest.approx(
        moduli["mu1"]["value_pa"] + moduli["mu2"]["value_pa"]
    )
    assert moduli["mu"]["low_pa"] < moduli["mu"]["value_pa"] < moduli["mu"]["high_pa"]
    table = pd.read_csv(results / "tables/table1.csv").set_index("group")
    bias = document["groups"]["AB"]["bias_percent"]["ogden2"]
    assert bias == pytest.approx(table.loc["AB", "difference_percent"])
    assert document["samples"]["B"]["record"]["travel_mm"] < 0.0


def test_every_json_result_says_where_it_comes_from(study):
    results, _ = study
    files = sorted(results.rglob("*.json"))
    assert len(files) > 50
    for path in files:
        record = load(results, path)["provenance"]
        assert record["versions"]["softsample"]
        assert len(record["code_sha256"]) == 64
        assert record["inputs"]


def test_every_log_is_written_and_no_file_is_half_written(study):
    results, _ = study
    assert all(path.stat().st_size >= 0 for path in (results / "logs").rglob("*.log"))
    assert not [path for path in results.rglob(".partial-*")]


def test_figures_are_drawn_in_both_formats(study):
    results, _ = study
    for name in (*(f"figure{number}" for number in range(2, 8)), "contact"):
        assert (results / f"figures/{name}.png").read_bytes()[:4] == b"\x89PNG"
        assert (results / f"figures/{name}.pdf").read_bytes()[:4] == b"%PDF"


def test_the_run_told_of_each_job_and_of_the_results(study):
    results, _ = study
    printed = (results.parent / "printed.txt").read_text()
    lines = re.findall(r"^\[([# ]{20})\] +\d+ %(, [\w ]+ left)?: (.*)$", printed, re.M)
    planned = int(re.search(r"^total +(\d+)$", printed, re.M)[1])
    assert len(lines) == planned
    assert "Response of the first term alone: B, real geometry" in [words for *_, words in lines]
    assert sum(bool(left) for _, left, _ in lines) > 0.9 * planned
    for group, fit in load(results, "results.json")["groups"].items():
        verdict, fitted = fit["verdict"], fit["calibration"]["real"]["ogden2"]["moduli"]["mu"]
        said = "".join(
            " +{} \\({} to {}\\)".format(
                *(f"{float(f'{mu[end]:.2e}'):.0f}" for end in ("value_pa", "low_pa", "high_pa"))
            )
            for mu in (verdict["modulus_to_quote"], fitted)
        )
        assert re.search(rf"^{group}{said} .* % +{verdict['verdict']}", printed, re.M)
    assert f"All tables and figures: {results}/report.html" in printed


def test_a_second_run_does_nothing(study):
    _, run = study
    assert "Nothing to be done" in run("-n")


def test_the_report_holds_methods_settings_hashes_and_verdicts(study):
    results, _ = study
    page = (results / "report.html").read_text(encoding="utf-8")
    for name in ("inputs/images/A.json", "inputs/A.json"):
        checked = load(results, name)["provenance"]
        for content in checked["inputs"].values():
            assert content in page
        assert checked["code_sha256"] in page
    assert f"Verdict: {load(results, 'loop/AB/verdict.json')['verdict']}" in page
    assert "hexahedra of 1 mm" in page
    assert "doi:10.1098/rspa.1972.0026" in page
    assert "System Message" not in page
    assert len(page) < 30e6


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_the_report_is_printed_on_pages_wide_tables_across(study, tmp_path):
    results, _ = study
    with Browser(tmp_path) as browser:
        browser.open(results / "report.html")
        pdf = browser.printed()
        assert browser.run("document.querySelectorAll('table.wide').length") > 0
        assert browser.run("[...document.querySelectorAll('details')].every(part => part.open)")
        browser.call("Emulation.setEmulatedMedia", media="print")
        for tables, paper_mm in (("table.wide", 297 - 2 * 12), ("table:not(.wide)", 210 - 2 * 16)):
            width = round(paper_mm / 25.4 * 96)
            size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": True}
            browser.call("Emulation.setDeviceMetricsOverride", **size)
            widths = f"[...document.querySelectorAll('{tables}')].map(t => t.offsetWidth)"
            assert max(browser.run(widths)) <= width
    boxes = re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", pdf)
    across = [float(width) > float(height) for width, height in boxes]
    assert any(across)
    assert 10 < len(boxes) < 100
    assert not all(across)


PIXELS = """(() => {
    const canvas = document.querySelector('.viewer[data-sample=B] canvas');
    return canvas.toDataURL();
})()"""
UNFOLDED = """new Promise(drawn => {
    const then = () => requestAnimationFrame(drawn);
    document.addEventListener("toggle", then, { once: true, capture: true });
    document.querySelector("#sample-B > summary").click();
})"""
SUM_OF_WHITE = """[...document.querySelectorAll('.viewer canvas')].map(canvas => {
    const seen = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
    return seen.filter(part => part < 200).length / seen.length;
})"""


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_the_report_opens_in_a_browser_with_all_it_shows_and_no_network(study, tmp_path):
    results, _ = study
    with Browser(tmp_path) as browser:
        browser.open(results / "report.html")
        lost = "[...document.images].filter(image => !image.naturalWidth).length"
        assert browser.run(lost) == 0
        assert browser.run("document.images.length") == 7 + 3 * 4 + 3  # numbered, samples, verdicts
        assert browser.run("document.querySelectorAll('figure td').length") > 100
        drawn = browser.run(SUM_OF_WHITE)
        assert len(drawn) == 4
        assert min(drawn) > 0.05  # a sample covers more than a twentieth of its canvas
        assert browser.outward == []
        assert browser.complaints == []


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_the_sample_in_the_report_turns_moves_and_becomes_the_cuboid(study, tmp_path):
    results, _ = study
    with Browser(tmp_path) as browser:
        browser.open(results / "report.html")
        browser.run(UNFOLDED)
        browser.run("document.getElementById('sample-B').scrollIntoView()")
        box = browser.run(
            "(r => [r.x + r.width / 2, r.y + r.height / 2])"
            "(document.querySelector('.viewer[data-sample=B] canvas').getBoundingClientRect())"
        )
        seen = [browser.run(PIXELS)]
        browser.drag(box, (box[0] + 120, box[1] + 40))
        seen.append(browser.run(PIXELS))
        for script in (
            "slider => { slider.value = 0; slider.dispatchEvent(new Event('input')); }",
            "(_, figure) => figure.querySelector('[value=ideal]').click()",
        ):
            figure = "document.querySelector('.viewer[data-sample=B]')"
            browser.run(f"({script})({figure}.querySelector('[type=range]'), {figure})")
            seen.append(browser.run(PIXELS))
        assert len(set(seen)) == 4
        browser.run("document.querySelector('.viewer[data-sample=B] button').click()")
        assert browser.complaints == []


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_the_browser_tells_of_errors_requests_and_missing_pictures(tmp_path):
    page = tmp_path / "page.html"
    page.write_text("<img src='https://example.invalid/x.png'><script>console.error('no')</script>")
    with Browser(tmp_path / "profile") as browser:
        browser.open(page)
        assert browser.wait_for("document.images[0].complete")
        assert not browser.run("document.images[0].naturalWidth > 0")
        assert browser.outward == ["https://example.invalid/x.png"]
        assert "['no']" in browser.complaints  # beside one of the lost picture, in either order


def test_a_test_at_the_optimum_is_exported_on_demand(study):
    results, run = study
    assert not (results / "export").exists()
    run("export_B")
    for geometry in ("real", "ideal"):
        fit = load(results, f"calibration/AB/{geometry}/ogden2.json")
        law = ET.parse(results / f"export/B/{geometry}.feb").find("Material/material")
        assert float(law.findtext("c1")) == pytest.approx(2e-6 * fit["mu1_pa"])  # MPa
        for ending in (".inp", "_calculix.inp"):
            text = (results / f"export/B/{geometry}{ending}").read_text()
            assert text.endswith("*END STEP\n")
            assert f"{1e-6 * fit['mu1_pa']:.10g}, -8" in text
        card = ET.parse(results / f"export/B/{geometry}_material_febio.xml").getroot()
        assert float(card.findtext("c2")) == pytest.approx(2e-6 * fit["mu2_pa"])
        whole = pd.read_csv(results / f"calibration/AB/{geometry}/ogden2.csv")
        curve = pd.read_csv(results / f"export/B/{geometry}_curve.csv")
        assert len(curve) == (whole["sample"] == "B").sum()
        assert list(curve) == ["displacement_mm", "measured_N", "model_N"]
        for ending in (".vtu", ".stl"):
            copy, mesh = (results / f"{at}/B/{geometry}{ending}" for at in ("export", "mesh"))
            assert copy.read_bytes() == mesh.read_bytes()


def test_verdicts_come_as_file_page_and_picture(study):
    results, run = study
    run("verdicts")
    for folder in ("loop/AB", "loop/AB/ideal"):
        verdict = load(results, f"{folder}/verdict.json")
        assert verdict["verdict"] in {"explained", "explained_class", "none", "unknown"}
        assert verdict["provenance"]["inputs"]
        for mode in ("tension", "compression"):
            after = verdict["error_after"][mode]["all"]
            assert 0.0 < after["rms_percent"] < 25.0
        assert {"leave_out_tension", "leave_out_compression"} <= set(verdict["held_out_after"])
        assert "after_ramp" not in verdict["held_out_after"]  # the toy's records are ramps
        page = (results / folder / "verdict.md").read_text(encoding="utf-8")
        assert page.startswith(f"# Verdict for AB: {verdict['verdict']}")
        for effect in verdict["effects"]:
            assert f"(`{effect['name']}`)" in page
        assert (results / folder / "verdict.png").read_bytes()[:4] == b"\x89PNG"
    changes = pd.read_csv(results / "loop/perturbations/B_real.csv")
    expected = {"poisson_0.02_less_mm2", "platen_slip_mm2", "platen_friction_0.15_loop_mm2"}
    assert expected | {"boundary_shift_mm2"} <= set(changes)
    assert np.isfinite(changes.to_numpy()).all()
    # softer in compression, where force and travel are negative
    assert changes["poisson_0.02_less_mm2"].iloc[-1] > 0.0
    assert "Nothing to be done" in run("-n", "verdicts")


@pytest.mark.parametrize(
    ("name", "picture", "shown"),
    [
        ("cuboid/A.json", False, "length_mm: "),
        ("tables/table1.csv", False, "mu_real_pa"),
        ("calibration/AB/real/ogden2.csv", True, "measured_N"),
        ("curves/A/real/ogden2.csv", True, "force_per_mu_mm2"),
        ("segmentation/A.nii.gz", True, "50 x 46 x 36 voxels"),
        ("mesh/A/real.vtu", True, "element data scaled_jacobian: 0."),
        ("fields/B/real.vtu", True, "max_principal_hencky_strain"),
    ],
)
def test_every_kind_of_result_can_be_shown(study, tmp_path, name, picture, shown):
    results, _ = study
    output = tmp_path / "picture.png"
    show = [sys.executable, "-m", "softsample", "show", str(results / name), "-o", str(output)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    done = subprocess.run(show, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    assert shown in done.stdout
    assert output.exists() == picture
    if picture:
        assert output.read_bytes()[:4] == b"\x89PNG"
