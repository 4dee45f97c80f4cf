"""Recovery of elastic laws from records that CalculiX made on real shapes of the cohort.

Six laws on two shapes, each in tension, compression and shear with the noise of the cohort. The
records become a study folder, the workflow's target `laws` fits and chooses, and its answer is
scored. Everything is kept below results/bench/laws, and what is there is not made again; with the
argument `page` only docs/law_recovery.md is written, from law_recovery.md.j2.
"""

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml
from scipy.interpolate import PchipInterpolator
from scipy.signal import lfilter

import templates
from peers import read_calculix_forces, versions_of_peers
from softsample.arrays import Array
from softsample.constitutive.material import Material, Term
from softsample.export.abaqus import write_abaqus
from softsample.fem.boundary import Boundary, ContactSettings, mode_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.io import read_mesh, write_json, write_text
from softsample.meshing.mesh import HexMesh
from templates import recovered

ROOT = Path(__file__).parents[1]
COHORT = ROOT / "resources" / "cohort"
BENCH = ROOT / "results" / "bench" / "laws"
SHAPES = ("C3", "S4")
"""Samples of the cohort whose images are used: an uneven and a flatter top."""

MODES = ("tension", "compression", "shear")
POISSON, ELEMENT_MM, BOND_MM, TRAVEL_MM, SPEED_MM_S, HZ = 0.49, 1.25, 1.0, 3.25, 0.3, 20.0

TRUE: dict[str, tuple[float, tuple[tuple[str, float, tuple[float, ...]], ...], dict[str, float]]]
TRUE = {
    "neo_hooke": (1400.0, (("neo_hooke", 1.0, ()),), {}),
    "mooney_rivlin": (1100.0, (("mooney_rivlin", 1.0, (0.6,)),), {"s": 0.6}),
    "yeoh": (900.0, (("yeoh", 1.0, (0.6, 2.0)),), {"c2": 0.6, "c3": 2.0}),
    "ogden": (1200.0, (("ogden", 1.0, (-14.0,)),), {"alpha": -14.0}),
    "foam": (1300.0, (("foam", 1.0, (4.0, 0.25)),), {"alpha": 4.0, "nu": 0.25}),
    "ogden(-8)+ogden(16)": (
        1310.0,
        (("ogden", 0.9, (-8.0,)), ("ogden", 0.1, (16.0,))),
        {"mu1_fraction": 0.9},
    ),
}
"""By name in tables: modulus [Pa], terms (law, share, shape parameters), parameters sought."""


def groups() -> list[tuple[str, str, str]]:
    """(group, shape, law) of all; the name of a group does not tell its law."""
    return [(f"{s}_{k}", s, law) for s in SHAPES for k, law in enumerate(TRUE, 1)]


def true_material(law: str) -> Material:
    """The material of a law."""
    modulus, terms, _ = TRUE[law]
    return Material(tuple(Term(n, share * modulus, shape) for n, share, shape in terms), POISSON)


def run_workflow(*arguments: str) -> None:
    """Run softsample as a user does."""
    command = [sys.executable, "-m", "softsample", "run", *arguments]
    subprocess.run(command, cwd=ROOT, check=True, stdin=subprocess.DEVNULL)


def test_of(shape: str, mode: str) -> tuple[HexMesh, Boundary]:
    """Mesh of a shape, and what holds it; the same for both programs."""
    mesh = read_mesh(BENCH / "shapes" / "mesh" / shape / "real.vtu")
    return mesh, mode_boundary(mesh, mode, mesh.glued(1e-3 * BOND_MM), ContactSettings())


def curve_of(group: str, shape: str, law: str, mode: str) -> tuple[Array, Array]:
    """Displacement [m] and force [N] of C3D8R in CalculiX.

    Raises
    ------
    RuntimeError
        If CalculiX stops before the end of the step; the next call runs it anew.
    """
    folder = BENCH / "calculix" / f"{group}_{mode}"
    if not (folder / "done").exists():
        folder.mkdir(parents=True, exist_ok=True)
        mesh, boundary = test_of(shape, mode)
        write_abaqus(
            folder / "test.inp", mesh, true_material(law), boundary, 1e-3 * TRAVEL_MM,
            program="calculix", increments=12,
        )  # fmt: skip
        subprocess.run(
            ["ccx", "test"], cwd=folder, check=False, stdout=subprocess.DEVNULL,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
        )  # fmt: skip
        (folder / "test.frd").unlink(missing_ok=True)
    time, force = read_calculix_forces(folder / "test.dat")
    if time[-1] < 1.0:
        raise RuntimeError(f"{folder}: CalculiX stopped at {time[-1]:.0%}; take more increments")
    (folder / "done").touch()
    axis = 0 if mode == "shear" else 2
    return 1e-3 * TRAVEL_MM * time, np.abs(force[:, axis])


def noisy_record(
    way: Array, force: Array, mode: str, seed: int, hz: float = HZ, rest_s: float = 0.0
) -> pd.DataFrame:
    """Record of a rest and a ramp with the noise of the cohort: sign by mode, mm, N, s."""
    sign = -1.0 if mode == "compression" else 1.0
    time = np.arange(0.0, rest_s + 1e3 * way[-1] / SPEED_MM_S, 1.0 / hz)
    travel = SPEED_MM_S * np.maximum(time - rest_s, 0.0)
    clean = PchipInterpolator(way, force)(1e-3 * travel)
    random = np.random.default_rng(seed)
    kept = np.exp(-1.0 / hz)
    steps = random.normal(0.0, 0.5e-3 * np.sqrt(1.0 - kept**2), len(time))
    slow = lfilter([1.0], [1.0, -kept], steps)
    white = random.normal(0.0, 1e-3, len(time))
    return pd.DataFrame({
        "time_s": time.round(4),
        "displacement_mm": (sign * (travel + random.normal(0.0, 1e-3, len(time)))).round(4),
        "force_N": (sign * (clean + slow + white)).round(4),
    })  # fmt: skip


def make_study(cores: int) -> Path:
    """The study folder, its records simulated."""
    study = BENCH / "study"
    settings = {
        "mesh": {"element_size_mm": ELEMENT_MM},
        "laws": {"pool": False, "element_size_mm": ELEMENT_MM},
    }
    (study / "records").mkdir(parents=True, exist_ok=True)
    write_text(study / "study.yaml", yaml.safe_dump(settings))
    shapes = [str(BENCH / "shapes" / "mesh" / shape / "real.vtu") for shape in SHAPES]
    targets = [word for shape in shapes for word in ("--target", shape)]
    run_workflow(
        str(COHORT), "--results", str(BENCH / "shapes"),
        "--settings", str(study / "study.yaml"), "--cores", str(cores), *targets,
    )  # fmt: skip
    cases = [(*group, mode) for group in groups() for mode in MODES]
    with ThreadPoolExecutor(cores) as pool:
        curves = list(pool.map(lambda case: curve_of(*case), cases))
    for shape in SHAPES:
        image = study / f"{shape}.nii.gz"
        image.unlink(missing_ok=True)
        image.symlink_to(COHORT / "images" / image.name)
    rows = []
    for seed, ((group, shape, _, mode), curve) in enumerate(zip(cases, curves, strict=True)):
        record = f"records/{group}_{mode}.csv"
        noisy_record(*curve, mode, seed).to_csv(study / record, index=False)
        rows.append({
            "sample": f"{group}_{mode}", "group": group, "specimen": group, "mode": mode,
            "image": f"{shape}.nii.gz", "record": record,
        })  # fmt: skip
    pd.DataFrame(rows).to_csv(study / "samples.tsv", sep="\t", index=False)
    return study


def stiffer(group: str, shape: str, law: str, mode: str) -> float:
    """Work of CalculiX over that of the solver with the true material on the same mesh, less 1."""
    way, force = curve_of(group, shape, law, mode)
    mesh, boundary = test_of(shape, mode)
    run = ExplicitModel(mesh, SolverSettings()).run(true_material(law), boundary, way[-1])
    own = np.interp(way, run.displacement, np.abs(run.force))
    return float(np.trapezoid(force, way) / np.trapezoid(own, way) - 1.0)


# --- scoring ------------------------------------------------------------------------------------


def scores(answers: Path) -> list[dict[str, Any]]:
    """One row a group: what was chosen, and how far the true law's parameters are off."""
    choice = json.loads((answers / "laws" / "choice.json").read_text())["groups"]
    table = pd.read_csv(answers / "tables" / "laws.csv").set_index(["group", "law"])
    rows = []
    for group, shape, law in groups():
        fitted = json.loads((answers / "laws" / f"{group}.json").read_text())["laws"][law]
        modulus, _, sought = TRUE[law]
        ends = table.loc[group, law]
        rows.append({
            "group": group,
            "shape": shape,
            "law": law,
            "recommended": choice[group]["recommended"],
            "equal": choice[group]["equal"],
            "held": law in choice[group]["equal"],
            "mu_error_percent": 100.0 * (fitted["mu_pa"] / modulus - 1.0),
            "mu_inside": bool(ends["mu_low_pa"] <= modulus <= ends["mu_high_pa"]),
            "mu_half_percent": 50.0 * (ends["mu_high_pa"] - ends["mu_low_pa"]) / ends["mu_pa"],
            "parameters": {
                name: {
                    "true": value,
                    "fitted": fitted["shape"][name],
                    **fitted["intervals"][name],
                    "inside": inside(fitted["intervals"][name], value),
                }
                for name, value in sought.items()
            },
            "stiffer_percent": {m: 100.0 * stiffer(group, shape, law, m) for m in MODES},
            "error_fitted_percent": fitted["error_fitted_percent"],
        })  # fmt: skip
    return rows


def inside(interval: dict[str, float | None], value: float) -> bool:
    """Whether an interval, open where it has no end, holds a value."""
    low, high = interval["low"], interval["high"]
    return (low is None or low <= value) and (high is None or value <= high)


def main() -> None:
    """Make the records, let the workflow answer, score, and write the page."""
    if sys.argv[1:] != ["page"]:
        cores = int(os.environ.get("CORES", "2"))
        study = make_study(cores)
        answers = BENCH / "results"
        run_workflow(
            str(study), "--results", str(answers), "--cores", str(cores), "--target", "laws"
        )
        rows = scores(answers)
        write_json(BENCH / "scores.json", {"peers": versions_of_peers(), "groups": rows})
    write_page(json.loads((BENCH / "scores.json").read_text()))


def write_page(found: dict[str, Any]) -> None:
    """docs/law_recovery.md."""
    groups = [{**g, "words": words(g["parameters"])} for g in found["groups"]]
    parameters = [p for g in groups for p in g["parameters"].values()]
    templates.write_page(
        "law_recovery",
        peers=found["peers"],
        groups=groups,
        shapes=SHAPES,
        modes=MODES,
        travel_mm=TRAVEL_MM,
        element_mm=ELEMENT_MM,
        recommended=sum(g["law"] == g["recommended"] for g in groups),
        close=sum(abs(g["mu_error_percent"]) <= 5.0 for g in groups),
        inside=sum(p["inside"] for p in parameters),
        parameters=len(parameters),
    )


def words(parameters: dict[str, dict[str, Any]]) -> str:
    """Shape parameters in words."""
    return "; ".join(
        f"{name}: {recovered(p['true'], p['fitted'], p['low'], p['high'])}"
        for name, p in parameters.items()
    )


if __name__ == "__main__":
    main()
