"""Studies without an image: dimensions alone, a closed surface, records of several machines."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import pyvista

import exact
import laboratory
import machines
import pooled
from softsample.shapes import IdealShape

ROOT = Path(__file__).resolve().parents[2]
BUILT = (f"VENV={sys.prefix}", "stamp=LICENSE")
AREA = {"cuboid": 20.0 * 18.0, "cylinder": 0.25 * np.pi * 20.0**2}
CELLS = {
    "cuboid": ("SHAPE=cuboid", "LENGTH=20", "WIDTH=18", "HEIGHT=12"),
    "cylinder": ("SHAPE=cylinder", "DIAMETER=20", "HEIGHT=12"),
}


def run(*words, given=()):
    """Run a command in the checkout; what it prints comes with a failure."""
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "MAKEFLAGS")}
    done = subprocess.run(
        [*map(str, words), *given], cwd=ROOT, capture_output=True, text=True, check=False,
        env={**environment, "NO_COLOR": "1"},
    )  # fmt: skip
    assert done.returncode == 0, (done.stdout + done.stderr)[-4000:]
    return done.stdout


def study(folder, *targets, settings="config/quick.yaml"):
    """Run targets of a study folder."""
    own = folder / "study.yaml"
    files = [settings, *([own] if own.exists() else [])]
    return run(
        sys.executable, "-m", "snakemake", "--cores", "2", "--nolock", "--configfile", *files,
        "--config", f"samples={folder}/samples.tsv", f"results={folder}/results", "--", *targets,
    )  # fmt: skip


def modulus(folder, group, geometry="ideal"):
    """Calibrated shear modulus [Pa]."""
    fit = folder / f"results/calibration/{group}/{geometry}/ogden2.json"
    return json.loads(fit.read_text())["mu_pa"]


def write_table(folder, rows):
    table = pd.DataFrame(rows, dtype=object)
    table.to_csv(folder / "samples.tsv", sep="\t", index=False, na_rep="")


@pytest.mark.study
def test_records_of_three_machines_cycles_and_dimensions_alone(tmp_path):
    """Sliding ends in closed form: the modulus that made the records comes back within 1 %."""
    shutil.copytree(ROOT / ".test", tmp_path, dirs_exist_ok=True)
    (told,) = re.findall(r"\.venv/bin/(snakemake .*)", (tmp_path / "README.md").read_text())
    assert told in (ROOT / ".github/workflows/tests.yml").read_text()
    words = told.replace(".test", str(tmp_path), 1).split()
    run(sys.executable, "-m", *words, "--nolock", "--", "verdicts")
    assert modulus(tmp_path, "mixed") == pytest.approx(exact.MODULUS, rel=0.01)
    assert modulus(tmp_path, "cycled") == pytest.approx(exact.MODULUS, rel=0.01)
    cycles = pd.read_csv(tmp_path / "results/records/D.csv")
    assert cycles["cycle"].max() == 5
    assert set(cycles.loc[cycles["calibrated"] == 1, "cycle"]) == {5}
    curves = sorted(path.parts[-3] for path in tmp_path.glob("results/curves/*/ideal/ogden2.csv"))
    assert curves == ["A", "D"], "equal pieces of a group share one response"
    assert not list(tmp_path.glob("results/curves/*/real"))
    for group in ("mixed", "cycled"):
        verdict = json.loads((tmp_path / f"results/loop/{group}/verdict.json").read_text())
        assert verdict["verdict"] == "none"


@pytest.mark.study
def test_open_ends_of_three_groups_are_found_to_slide(tmp_path):
    """Records of sliding ends in closed form, in a study that does not state the ends."""
    size = {"shape": "cylinder", "diameter_mm": 20, "height_mm": 10, "ends": "unknown"}
    rows = []
    for seed, (mode, strain) in enumerate((("compression", -0.25), ("tension", 0.25)) * 3):
        name, group = f"P{seed}", "ABC"[seed // 2]
        record = exact.uniaxial_record(AREA["cylinder"], 10.0, strain, seed=seed)
        machines.write(tmp_path / f"{name}.csv", machines.univert(*record))
        rows.append({"sample": name, "group": group, "mode": mode, "record": f"{name}.csv", **size})
    write_table(tmp_path, rows)
    study(tmp_path, "verdicts", settings="config/test.yaml")
    for group in "ABC":
        verdict = json.loads((tmp_path / f"results/loop/{group}/verdict.json").read_text())
        assert verdict["verdict"] == "explained"
        assert verdict["effects"][0]["name"] == "ends"
        assert verdict["ends"] == ["sliding"]
        assert verdict["recommended"]["mu"]["value"] == pytest.approx(exact.MODULUS, rel=0.02)
        assert abs(modulus(tmp_path, group) / exact.MODULUS - 1.0) > 0.05, "of bonded ends"
        assert verdict["other_ends"]["ends"] == "bonded"
        assert verdict["other_ends"]["evidence_of_other_groups"] < 0.0


@pytest.mark.long
def test_four_groups_tell_each_other_of_the_loss_on_unloading_that_is_held_out(tmp_path):
    """Foams between plates that slide: of each group its loading to a strain of 25 % is known."""
    size = {"shape": "cylinder", "diameter_mm": 15, "height_mm": 10, "ends": "sliding"}
    plug = IdealShape("cylinder", 15e-3, 15e-3, 10e-3)
    rows, foams = (
        [],
        ((2000.0, 5.0, 0.2), (1200.0, 5.4, 0.22), (2600.0, 4.7, 0.19), (1700, 5.2, 0.21)),
    )
    for seed, (group, foam) in enumerate(zip("ABCD", foams, strict=True)):
        test = laboratory.foam_cycle(group, plug, *foam, 0.45, step=0.4, seed=seed)
        record = {
            "time_s": test.time, "displacement_mm": -1e3 * test.travel, "force_N": -test.force
        }  # fmt: skip
        pd.DataFrame(record).to_csv(tmp_path / f"{group}.csv", index=False)
        row = {"sample": f"{group}1", "group": group, "mode": "compression"}
        rows.append({**row, "record": f"{group}.csv", **size})
    write_table(tmp_path, rows)
    selections = "[{strain_above: 0.25}, {phase: unloading}]"
    (tmp_path / "study.yaml").write_text(f"leave_out: group\nhold_out: {selections}\n")
    study(tmp_path, "verdicts", settings="config/test.yaml")
    for group, (mu, *_) in zip("ABCD", foams, strict=True):
        verdict = json.loads((tmp_path / f"results/loop/{group}/verdict.json").read_text())
        assert verdict["verdict"] == "explained"
        named = {effect["name"] for effect in verdict["effects"]}
        assert named == {"compressible_foam", "unloading_loss"}
        assert verdict["pooled"]["groups"] == 3
        alone = json.loads((tmp_path / f"results/loop/{group}/alone/verdict.json").read_text())
        assert "unloading_loss" not in {effect["name"] for effect in alone["effects"]}
        assert verdict["recommended"]["mu"]["value"] == pytest.approx(mu, rel=0.03)


@pytest.mark.study
def test_torsion_indentation_and_compression_give_one_modulus(tmp_path):
    """Each alone and all together, on records of felupe and of Rivlin's integral."""
    size = {
        "shape": "cylinder",
        "diameter_mm": 2e3 * pooled.RADIUS,
        "height_mm": 1e3 * pooled.HEIGHT,
    }
    punch = {"indenter": "flat", "indenter_radius_mm": 1e3 * pooled.PUNCH}
    rows = []
    for mode in ("torsion", "indentation", "compression"):
        shutil.copy(pooled.TARGET / f"{mode}.csv", tmp_path)
        own = punch if mode == "indentation" else {}
        rows.append({"sample": mode, "mode": mode, "record": f"{mode}.csv", **size, **own})
    alone = [{**row, "group": f"{row['sample']}_alone"} for row in rows]
    together = [{**row, "group": "all"} for row in rows]  # of the same responses
    for table in (alone, together):
        write_table(tmp_path, table)
        groups = {row["group"] for row in table}
        asked = [f"{tmp_path}/results/calibration/{g}/ideal/ogden2.json" for g in groups]
        study(tmp_path, *asked)
        for group in groups:
            found = modulus(tmp_path, group)
            assert found == pytest.approx(sum(pooled.MATERIAL.mu), rel=0.05), group
    study(tmp_path, "export_torsion", "export_indentation")
    for mode, motion in (("torsion", "*RIGID BODY, NSET=BONDED"), ("indentation", "PLATEN, 3, 3,")):
        written = tmp_path / f"results/export/{mode}"
        assert motion in (written / "ideal_calculix.inp").read_text()
        assert {path.suffix for path in written.glob("ideal*")} >= {".inp", ".feb", ".pvd", ".vtu"}


@pytest.mark.study
def test_torque_and_axial_force_tell_the_law(tmp_path):
    """A Mooney-Rivlin cylinder, R. S. Rivlin (1949), doi:10.1098/rsta.1949.0009.

    Its torque is that of a neo-Hookean one, its axial force is not; the model's pair is neither.
    """
    radius, height, first, second = 10e-3, 10e-3, 300.0, 200.0
    time = np.arange(421) * 0.1
    turned = np.radians(25.0) * np.clip((time - 2.0) / 40.0, 0.0, None)
    twist = turned / height
    noise = np.random.default_rng(3).standard_normal((2, len(time)))
    torque = np.pi * radius**4 * twist * (first + second)
    axial = -0.5 * np.pi * radius**4 * twist**2 * (first + 2.0 * second)
    record = {
        "time_s": time,
        "angle_deg": np.degrees(turned),
        "torque_Nmm": 1e3 * torque + 2e-3 * noise[0],
        "force_normal_N": axial + 2e-4 * noise[1],
    }
    pd.DataFrame(record).to_csv(tmp_path / "turned.csv", index=False)
    size = {"shape": "cylinder", "diameter_mm": 2e3 * radius, "height_mm": 1e3 * height}
    write_table(
        tmp_path, [{"sample": "T", "group": "G", "mode": "torsion", "record": "turned.csv", **size}]
    )
    asked = [f"{tmp_path}/results/{name}" for name in ("loop/G/verdict.json", "tables/laws.csv")]
    study(tmp_path, *asked, settings="config/test.yaml")
    laws = pd.read_csv(tmp_path / "results/tables/laws.csv").set_index("law")
    assert laws.loc["neo_hooke", "mu_pa"] == pytest.approx(2.0 * (first + second), rel=0.01)
    assert "one loading curve of one mode" in laws.loc["neo_hooke", "remark"]
    verdict = json.loads((tmp_path / "results/loop/G/verdict.json").read_text())
    (law,) = verdict["effects"]
    assert law["name"] in ("elastic_law", "ogden_exponents")
    assert verdict["theta_after"]["mu"]["value"] == pytest.approx(2.0 * (first + second), rel=0.03)
    for test in ("torsion", "torsion_normal"):
        assert verdict["error_after"][test]["all"]["rms_percent"] < 1.5


@pytest.mark.study
def test_what_is_held_out_is_not_fitted_and_is_judged(tmp_path):
    """A wrong force beyond a strain, and in a whole sample, leaves the modulus as it is."""
    area, height = AREA["cuboid"], 12.0
    size = {"shape": "cuboid", "length_mm": 20, "width_mm": 18, "height_mm": height}
    rows, wrong = [], {}
    for seed, name in enumerate(("A", "B")):
        time, moved, force = exact.uniaxial_record(area, height, -0.25, seed=seed)
        force = np.where(moved < -0.15 * height, 2.0 * force, force) if name == "A" else 3.0 * force
        beyond = force[moved < -0.15 * height]
        wrong = {**wrong, name: 50.0 * np.sqrt(np.mean(beyond**2)) / np.abs(beyond).max()}
        table = pd.DataFrame({"time_s": time, "displacement_mm": moved, "force_N": force})
        table.to_csv(tmp_path / f"{name}.csv", index=False)
        rows.append({"sample": name, "group": "G", "mode": "compression", "ends": "sliding"})
    write_table(tmp_path, [{**row, **size, "record": f"{row['sample']}.csv"} for row in rows])
    (tmp_path / "study.yaml").write_text("hold_out:\n- strain_above: 0.15\n- sample: B\n")
    study(tmp_path, "verdicts", settings="config/test.yaml")
    fit = json.loads((tmp_path / "results/calibration/G/ideal/ogden2.json").read_text())
    assert fit["mu_pa"] == pytest.approx(exact.MODULUS, rel=0.01)
    assert (fit["samples"], fit["held_out"]) == (["A"], ["B"])
    verdict = json.loads((tmp_path / "results/loop/G/verdict.json").read_text())
    errors = verdict["held_out_before"]["held_out"]
    assert set(errors) == {"compression_A", "compression_B"}
    assert errors["compression_A"]["rms_percent"] == pytest.approx(wrong["A"], rel=0.05)
    assert verdict["error_before"]["compression"]["all"]["rms_percent"] < 1.0
    assert "strain above 0.15" in verdict["rule"]


@pytest.mark.long
@pytest.mark.parametrize("shape", ["cuboid", "cylinder"])
def test_from_callipers_and_a_csv_to_a_report_in_three_commands(shape, tmp_path):
    record = exact.uniaxial_record(AREA[shape], 12.0, -0.25)
    machines.write(tmp_path / "test.csv", machines.univert(*record))
    lab = tmp_path / "lab"
    here = f"DIR={lab}"
    run("make", "new-study", here, given=BUILT)
    cells = (*CELLS[shape], "MODE=compression", "ENDS=sliding", "SAMPLE=P1")
    run("make", "add-sample", here, f"RECORD={tmp_path / 'test.csv'}", *cells, given=BUILT)
    told = run("make", "study", here, "CONFIG=config/quick.yaml", given=BUILT)
    assert modulus(lab, "P1") == pytest.approx(exact.MODULUS, rel=0.01)
    assert "not known" in told
    assert (lab / "results/report.html").stat().st_size > 10_000
    checks = json.loads((lab / "results/checks/P1_ideal.json").read_text())["checks"]
    direct = next(c for c in checks if c["name"].startswith("direct run against"))
    assert direct["value"] < 0.2, "finite elements against the closed form [% of peak]"


@pytest.mark.long
def test_from_a_closed_surface_to_a_report(tmp_path):
    """A sharp cuboid on sliding ends as a surface; elements of 1 mm round its edges."""
    box = pyvista.Cube(bounds=(-10.0, 10.0, -9.0, 9.0, 0.0, 12.0)).triangulate().subdivide(4)
    box.save(tmp_path / "scan.stl")
    record = exact.uniaxial_record(AREA["cuboid"], 12.0, -0.2)
    machines.write(tmp_path / "test.csv", machines.univert(*record))
    lab = tmp_path / "lab"
    here = f"DIR={lab}"
    run("make", "new-study", here, given=BUILT)
    cells = (f"SURFACE={tmp_path / 'scan.stl'}", "MODE=compression", "ENDS=sliding", "SAMPLE=P1")
    run("make", "add-sample", here, f"RECORD={tmp_path / 'test.csv'}", *cells, given=BUILT)
    run("make", "study", here, "CONFIG=config/quick.yaml", given=BUILT)
    assert modulus(lab, "P1", "ideal") == pytest.approx(exact.MODULUS, rel=0.01)
    assert exact.MODULUS < modulus(lab, "P1", "real") < 1.12 * exact.MODULUS
    assert (lab / "results/report.html").exists()
