"""The solver against exact solutions, theory and other programs.

Writes results/verification/verification.json, figures into docs/figures/verification, and
docs/verification.md from verification.md.j2 with the numbers as they came out; with the argument
`page` figures and page alone, from numbers that are there.
"""

import json
import sys
import time
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import jinja2
import matplotlib as mpl
import numpy as np

import known
import mechanics
import modes
import peers
from case import EDGES, MATERIAL, TRAVEL, boundary_of, cuboid
from machine import processor
from softsample.arrays import Array
from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.boundary import ContactSettings, platen_boundary
from softsample.fem.explicit import ExplicitModel, Run, SolverSettings
from softsample.figures.style import PALETTE, STYLE, page_figure, save
from softsample.io import write_json, write_text
from softsample.meshing.mesh import HexMesh
from softsample.workflow import versions
from spectral import stress as ogden_stress

ROOT = Path(__file__).parents[1]
REFERENCE = ROOT / "tests" / "data" / "reference"
FIGURES = ROOT / "docs" / "figures" / "verification"
BENCH = ROOT / "results" / "bench" / "solver.json"
TARGET = ROOT / "results" / "verification" / "verification.json"
MODES = {"compression": "a", "tension": "b", "shear": "c"}
SLOW = 0.24
"""Loading time of the comparisons [s], four times the default; extrapolated with half of it."""


# --- exact solutions and orders -----------------------------------------------------------------


def patch() -> dict[str, float]:
    """Largest force on inner nodes of a distorted patch in a large homogeneous strain."""
    gradient = np.array([[0.12, 0.2, -0.05], [0.03, -0.15, 0.1], [-0.08, 0.06, 0.1]])
    block = cuboid(2e-3)
    inner = np.ones(len(block.points), bool)
    inner[block.boundary] = False
    shift = np.random.default_rng(0).uniform(-5e-4, 5e-4, block.points.shape) * inner[:, None]
    mesh = HexMesh(block.points + shift, block.hexes)
    stress = np.abs(ogden_stress(np.eye(3) + gradient, MATERIAL)).max()
    found = {}
    for precision in ("float64", "float32"):
        model = ExplicitModel(mesh, SolverSettings(precision=precision))
        force, _ = model.internal_force(mesh.points @ gradient.T, MATERIAL)
        found[precision] = float(np.abs(force[inner]).max() / (stress * mesh.edge_length**2))
    return found


def homogeneous() -> list[dict[str, Any]]:
    """Frictionless compression by 30 %: largest difference from the exact curve [% of peak]."""
    rows = []
    for mu, alpha in ((MATERIAL.mu, MATERIAL.alpha), ((1196.8, 113.1, 400.0), (-8.0, 16.0, 3.5))):
        for nu in (0.40, 0.49, 0.499):
            errors = []
            for loading_time in (0.1, 0.2):
                run, exact = known.smooth_platens(
                    OgdenMaterial(mu, alpha, nu), loading_time=loading_time
                )
                errors.append(100.0 * np.abs(run.force - exact).max() / exact.max())
            rows.append({"alpha": alpha, "poisson_ratio": nu, "error_percent": errors})
    return rows


def element_size() -> dict[str, Any]:
    """Errors on meshes finer by two each, and their orders: Lame's mode, virtual work."""
    cells = [8, 16, 32, 64]
    cases = {
        f"Lamé mode, ν = {nu}{', distorted' if distortion else ''}": [
            known.lame_frequency(n, 0.1, nu, distortion) for n in cells
        ]
        for nu in (0.3, 0.49)
        for distortion in (0.0, 0.2)
    }
    cases["virtual work, strains to 0.4"] = [known.virtual_work_error(n, MATERIAL) for n in cells]
    size = 1.0 / np.array(cells)
    return {
        "cells": cells,
        "errors": cases,
        "orders": {k: known.observed_orders(size, v) for k, v in cases.items()},
    }


def time_step() -> dict[str, Any]:
    """Orders in the time step: Lame's mode, and the curve of a tension test."""
    parts = [0.9, 0.45, 0.225, 0.1125]
    frequency = [known.lame_frequency(16, part) for part in parts]
    mesh = cuboid(2e-3)
    forces = []
    for part in parts:
        settings = SolverSettings(precision="float64", safety_factor=part)
        run = ExplicitModel(mesh, settings).run(
            MATERIAL, boundary_of(mesh, "tension"), TRAVEL["tension"], loading_time=0.03
        )
        forces.append(run.force)
    change = [np.abs(fine - coarse).max() / forces[-1].max() for coarse, fine in pairwise(forces)]
    return {
        "parts": parts,
        "lame": frequency,
        "lame_order": known.richardson(frequency[:3])[0],
        "curve_change": change,
        "curve_orders": known.observed_orders([4, 2, 1], change),
    }


def loading_time() -> dict[str, Any]:
    """Error of the curve over the loading time, for the 2 mm cuboid [% of peak]."""
    mesh, times = cuboid(2e-3), [0.06, 0.12, 0.24, 0.48, 0.96]
    model, rows = ExplicitModel(mesh, known.DOUBLE), {}
    for mode in TRAVEL:
        boundary = boundary_of(mesh, mode)
        forces = [model.run(MATERIAL, boundary, TRAVEL[mode], loading_time=t).force for t in times]
        limit = (4.0 * forces[-1] - forces[-2]) / 3.0
        errors = [100.0 * np.abs(f - limit).max() / limit.max() for f in forces[:-1]]
        rows[mode] = {
            "error_percent": errors,
            "orders": -known.observed_orders(times[:-1], errors),
        }
    return {"times_s": times[:-1], "modes": rows}


def hertz() -> list[dict[str, Any]]:
    """Platen on a paraboloid on meshes finer by two: curve, exact curve, largest difference."""
    rows = []
    for per_radius, cells in ((2, 9), (4, 12), (8, 15)):
        run, exact = known.hertz(per_radius, cells)
        rows.append({
            "per_radius": per_radius,
            "elements": 4 * cells**3,
            "error_percent": 100.0 * np.abs(run.force - exact).max() / exact.max(),
            "end_error_percent": 100.0 * (run.force[-1] / exact[-1] - 1.0),
            "depth_m": run.displacement,
            "force_n": run.force,
            "exact_n": exact,
        })  # fmt: skip
    return rows


def other_modes() -> dict[str, Any]:
    """Torsion, bonded discs and indentation against published solutions [%]."""
    torsion = []
    for along_radius in (10, 20):
        run = modes.turned(along_radius)
        torque, axial = modes.rivlin(run.displacement)
        radius = 0.5 * modes.TURNED.length
        torsion.append({
            "along_radius": along_radius,
            "torque_percent": 100.0 * (radius * run.force[-1] / torque[-1] - 1.0),
            "axial_percent": 100.0 * (run.force_vector[-1, 2] / axial[-1] - 1.0),
        })  # fmt: skip
    discs = [
        {"radius_over_height": case[0], "poisson_ratio": case[1], "ritz": ritz,
         "own": [modes.disc(*case, n) for n in (8, 12)]}
        for case, ritz in modes.RITZ.items()
    ]  # fmt: skip
    runs = {
        "ball, large cuboid (Hertz)": modes.smooth_ball(modes.large("cuboid")),
        "ball, large cylinder (Hertz)": modes.smooth_ball(modes.large("cylinder")),
        "punch, large cylinder (Boussinesq, Sneddon)": modes.smooth_punch(),
        **{
            f"ball, layer of {1e3 * layer[0]:g} mm (Dimitriadis)": modes.ball_on_layer(*layer)
            for layer in modes.LAYERS
        },
    }
    contact = {}
    for name, (run, exact) in runs.items():
        apart = 100.0 * modes.late(run, exact)
        contact[name] = {"largest": float(np.abs(apart).max()), "end": float(apart[-1])}
    orders = known.observed_orders([2, 1], [row["torque_percent"] for row in torsion])
    return {
        "torsion": torsion, "torque_order": float(orders[0]), "discs": discs, "contact": contact,
    }  # fmt: skip


# --- other programs -----------------------------------------------------------------------------


def curve_of(path: str, mode: str) -> Array:
    """Travel [m] and force [N] along it, (n, 2), of a file of the reference."""
    table = np.genfromtxt(REFERENCE / path, delimiter=",", names=True)
    axis, sign = ("x" if mode == "shear" else "z"), (-1.0 if mode == "compression" else 1.0)
    return sign * np.column_stack([1e-3 * table[f"u{axis}_mm"], table[f"F{axis}_N"]])


def at_rest(run: Callable[[float], Run]) -> tuple[Array, Run]:
    """Curve (n, 2) [m, N] extrapolated to an endless loading time, and the slower run."""
    fast, slow = run(0.5 * SLOW), run(SLOW)
    return np.column_stack([slow.displacement, (4.0 * slow.force - fast.force) / 3.0]), slow


@cache
def own(mode: str, size_mm: float) -> tuple[Array, Run]:
    """Curve of the cuboid in a mode of `case.TRAVEL`."""
    mesh = cuboid(1e-3 * size_mm)
    model, boundary = ExplicitModel(mesh, SolverSettings()), boundary_of(mesh, mode)
    return at_rest(lambda t: model.run(MATERIAL, boundary, TRAVEL[mode], loading_time=t))


def difference(curve: Array, reference: Array) -> float:
    """Largest difference from a reference over its peak [%], sign of the largest."""
    gap = np.interp(reference[:, 0], *curve.T) - reference[:, 1]
    return float(100.0 * gap[np.abs(gap).argmax()] / np.abs(reference[:, 1]).max())


def side_by_side() -> list[dict[str, Any]]:
    """The solver less CalculiX and felupe or FEBio on the same meshes [% of peak]."""
    rows = []
    for size in (2, 1, 0.5):
        for mode, code in MODES.items():
            curve, run = own(mode, size)
            row = {
                "size_mm": size,
                "mode": mode,
                "energy_error_percent": 100.0 * run.energy["imbalance"],
                "hourglass_percent": 100.0 * run.energy["hourglass_ratio"],
                "curve": curve,
            }
            three_field = "febio_3fQ" if size == 0.5 else "felupe_mdil"
            for name, file in (("c3d8r", "ccx_C3D8R"), ("three_field", three_field)):
                path = f"cuboid/{file}_h{size}_{code}.csv"
                reference = curve_of(path, mode) if (REFERENCE / path).exists() else []
                row[name] = difference(curve, reference) if len(reference) > 10 else None
            rows.append(row)
    return rows


def coarse_start() -> dict[str, float]:
    """Force at 0.39 mm of compression on the 0.5 mm mesh, as far as CalculiX got [N]."""
    reference = curve_of("cuboid/ccx_C3D8R_h0.5_a.csv", "compression")[-1]
    curve, _ = own("compression", 0.5)
    return {"calculix_n": reference[1], "own_n": float(np.interp(reference[0], *curve.T))}


def half_millimetre() -> list[dict[str, Any]]:
    """End force at 0.5 mm against C3D8R of 2 and 1 mm, extrapolated by our own change."""
    rows = []
    for mode, code in MODES.items():
        ours = [own(mode, size)[0][-1, 1] for size in (2, 1, 0.5)]
        theirs = [curve_of(f"cuboid/ccx_C3D8R_h{size}_{code}.csv", mode)[-1, 1] for size in (2, 1)]
        # ours over theirs tends to one with the size squared: same element, another hourglass rule
        ratio = [a / b for a, b in zip(ours, theirs, strict=False)]
        rows.append({
            "mode": mode,
            "own_n": ours,
            "calculix_n": theirs,
            "extrapolated_percent": 100.0 * (ratio[1] + (ratio[1] - ratio[0]) / 3.0 - 1.0),
        })  # fmt: skip
    return rows


def live() -> dict[str, dict[str, float]]:
    """The stored curves of 2 mm computed anew: largest difference [% of peak]."""
    found: dict[str, dict[str, float]] = {}
    files = {"calculix": "ccx_C3D8R", "felupe": "felupe_mdil"}
    for name in files:
        if name not in peers.versions_of_peers():
            continue
        for mode, code in MODES.items():
            table, _ = getattr(peers, name)(cuboid(2e-3), MATERIAL, mode, TRAVEL[mode])
            stored = curve_of(f"cuboid/{files[name]}_h2_{code}.csv", mode)
            shared = np.isclose(table[:, :1], stored[:, 0]).any(axis=1)  # increments may be cut
            found.setdefault(name, {})[mode] = abs(difference(stored, table[shared]))
    return found


def refinement() -> dict[str, Any]:
    """Compression of the cuboid on finer meshes: forces at 80 and 100 % of the displacement [N].

    With clamped ends and no contact the side walls pass the platens' planes. On the finest mesh
    one run in the default time has to do, corrected by what that time changes on the mesh before.
    """
    sizes, places = [2, 1, 0.5, 0.25], np.array([0.8, 1.0]) * TRAVEL["compression"]
    rows: dict[str, Any] = {"sizes_mm": sizes}
    for name, mode in (("clamped", "compression"), ("contact", "contact")):
        forces = [np.interp(places, *own(mode, size)[0].T) for size in sizes[:3]]
        fine, middle = default_run(mode, sizes[3]), default_run(mode, sizes[2])
        quick = [np.interp(places, run.displacement, run.force) for run in (fine, middle)]
        rows[name] = np.array([*forces, quick[0] + forces[-1] - quick[1]]).T
        z = cuboid(1e-3 * sizes[3]).points[:, 2] + fine.displacement_field[:, 2]
        rows[f"{name}_past_platen_mm"] = 1e3 * (z.max() - EDGES[2] + places[1])
        rows[f"{name}_kinetic_percent"] = 100.0 * fine.energy["kinetic"] / fine.energy["strain"]
    rows["three_field"] = np.array([
        np.interp(places, *curve_of(f"cuboid/febio_3fQ_h{size}_a.csv", "compression").T)
        for size in sizes[:3]
    ]).T  # fmt: skip
    gap = 100.0 * (rows["three_field"] / rows["clamped"][:, :3] - 1.0)
    rows["gap_percent"] = gap
    rows["gap_orders"] = [known.observed_orders(sizes[:3], row) for row in gap]
    return rows


def default_run(mode: str, size_mm: float) -> Run:
    """The cuboid in the default loading time."""
    mesh = cuboid(1e-3 * size_mm)
    return ExplicitModel(mesh, SolverSettings()).run(
        MATERIAL, boundary_of(mesh, mode), TRAVEL[mode]
    )


def real_shapes() -> dict[str, Any]:
    """Contact on real shapes: FEBio's mesh, and the same shape in finer elements, by shape."""
    contact = ContactSettings(release=False, side_walls=False, base_platen=False)
    rows = {}
    for name, splits in (("compression_h1", 2), ("compression_h07", 1)):
        data = np.load(REFERENCE / "mesh" / f"{name}.npz")
        mesh = HexMesh(1e-3 * data["nodes_mm"], data["hex8"].astype(np.int64))
        febio = curve_of(f"curves/{name}.csv", "compression")
        row: dict[str, Any] = {
            "edge_mm": 1e3 * mesh.edge_length, "elements": [], "own_n": [], "febio_n": febio[-1, 1],
            "febio": febio, "own": [], "energy_error_percent": [], "hourglass_percent": [],
        }  # fmt: skip
        for split in range(splits + 1):
            mesh = known.refined(mesh) if split else mesh
            model, boundary = ExplicitModel(mesh, SolverSettings()), platen_boundary(mesh, contact)
            run = model.run(MATERIAL, boundary, TRAVEL["contact"])
            row["elements"].append(len(mesh.hexes))
            row["own_n"].append(float(run.force[-1]))
            row["own"].append(np.interp(febio[:, 0], run.displacement, run.force))
            row["energy_error_percent"].append(100.0 * run.energy["imbalance"])
            row["hourglass_percent"].append(100.0 * run.energy["hourglass_ratio"])
        row["same_mesh_percent"] = difference(np.column_stack([febio[:, 0], row["own"][0]]), febio)
        row["spread_percent"] = 100.0 * np.ptp(row["own_n"]) / row["own_n"][-1]
        row["febio_gap_percent"] = 100.0 * (row["febio_n"] / row["own_n"][-1] - 1.0)
        rows[name] = row
    return {"meshes": rows, "febio_order": _order_of_gap(list(rows.values()))}


def _order_of_gap(rows: list[dict[str, Any]]) -> float:
    """Order in the element size of FEBio's difference from our finest mesh of each shape."""
    gaps = [row["febio_gap_percent"] for row in rows]
    return float(known.observed_orders([row["edge_mm"] for row in rows], gaps)[0])


# --- figures ------------------------------------------------------------------------------------


def _panels(count: int) -> tuple[Any, Any]:
    figure = page_figure(95.0)
    return figure, np.atleast_1d(figure.subplots(1, count))


def _save(figure: Any, name: str) -> None:
    FIGURES.mkdir(parents=True, exist_ok=True)
    figure.draw_without_rendering()  # or the layout is one step behind the legends
    save(figure, FIGURES / f"{name}.png", 160)


def _legend(axis: Any) -> None:
    """Below the panel, where it hides no line."""
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2))


def _slope(axis: Any, x: Array, y: float, order: float) -> None:
    """A grey line of a theory's slope through (x[0], y)."""
    x = np.asarray(x, float)
    axis.loglog(x, y * (x / x[0]) ** order, color="0.6", lw=4, zorder=0, label=f"slope {order:g}")


def _ticks(axis: Any, places: Array | list[float], labels: list[float] | None = None) -> None:
    axis.set_xticks(places, [f"{x:g}" for x in labels or places])
    axis.set_xticks([], minor=True)


def draw_orders(found: dict[str, Any]) -> None:
    """Errors over element size, time step and loading time."""
    figure, axes = _panels(3)
    sizes = 1.0 / np.array(found["element_size"]["cells"])
    for (name, errors), style in zip(
        found["element_size"]["errors"].items(), ("o-", "s--", "^-", "v--", "D-"), strict=True
    ):
        axes[0].loglog(sizes, np.abs(errors), style, ms=4, lw=1, label=name)
    _slope(axes[0], sizes, 0.012, 2)
    axes[0].set(xlabel="elements an edge", ylabel="relative error", title="element size")
    _ticks(axes[0], sizes, found["element_size"]["cells"])
    step = found["time_step"]
    lame = np.abs(np.diff(step["lame"]))
    axes[1].loglog(step["parts"][:3], lame, "o-", ms=4, lw=1, label="Lamé mode")
    axes[1].loglog(step["parts"][:3], step["curve_change"], "s-", ms=4, lw=1, label="tension curve")
    _slope(axes[1], step["parts"][:3], 2e-4, 2)
    axes[1].set(xlabel="step / critical step", ylabel="change when halved", title="time step")
    _ticks(axes[1], step["parts"][:3])
    pace = found["loading_time"]
    for mode, row in pace["modes"].items():
        axes[2].loglog(pace["times_s"], row["error_percent"], "o-", ms=4, lw=1, label=mode)
    _slope(axes[2], pace["times_s"], 0.4, -2)
    axes[2].set(xlabel="loading time [s]", ylabel="error [% of peak]", title="loading time")
    _ticks(axes[2], pace["times_s"])
    for axis in axes:
        _legend(axis)
    _save(figure, "orders")


def draw_hertz(rows: list[dict[str, Any]]) -> None:
    """Force on the paraboloid and its difference from theory."""
    figure, axes = _panels(2)
    depth, exact = 1e6 * np.array(rows[0]["depth_m"]), 1e3 * np.array(rows[0]["exact_n"])
    axes[0].plot(depth, exact, "k", lw=1, label="Hertz, layer")
    for row, style in zip(rows, ("o", "s", "."), strict=True):
        label = f"{row['per_radius']} elements a contact radius"
        force = 1e3 * np.array(row["force_n"])
        axes[0].plot(depth, force, style, ms=3, label=label)
        axes[1].plot(
            depth, 100.0 * (force / exact[-1] - exact / exact[-1]), style + "-", ms=3, lw=1
        )
    axes[0].set(xlabel="depth [µm]", ylabel="force [mN]")
    axes[1].set(xlabel="depth [µm]", ylabel="difference [% of peak]")
    axes[1].axhline(0.0, color="k", lw=0.8)
    _legend(axes[0])
    _save(figure, "hertz")


def draw_programs(rows: list[dict[str, Any]]) -> None:
    """Curves of the three programs on the 1 mm cuboid and their differences."""
    figure, axes = _panels(2)
    files = (("ccx_C3D8R", "x", "CalculiX C3D8R"), ("felupe_mdil", "+", "felupe three-field"))
    for (mode, code), colour in zip(
        MODES.items(), (PALETTE[0], PALETTE[1], PALETTE[2]), strict=True
    ):
        row = next(r for r in rows if (r["size_mm"], r["mode"]) == (1, mode))
        curve = np.array(row["curve"])
        axes[0].plot(1e3 * curve[:, 0], curve[:, 1], color=colour, lw=1, label=mode)
        for file, marker, name in files:
            other = curve_of(f"cuboid/{file}_h1_{code}.csv", mode)
            axes[0].plot(1e3 * other[:, 0], other[:, 1], marker, color=colour, ms=5)
            gap = np.interp(other[:, 0], *curve.T) - other[:, 1]
            axes[1].plot(1e3 * other[:, 0], 100.0 * gap / other[-1, 1], marker + "-", color=colour,
                         ms=5, lw=0.8, label=f"{mode}, {name}")  # fmt: skip
    axes[0].set(
        xlabel="displacement [mm]",
        ylabel="force [N]",
        title="1 mm cuboid: lines ours, x CalculiX, + felupe",
    )
    axes[1].set(xlabel="displacement [mm]", ylabel="ours less theirs [% of peak]")
    axes[1].axhline(0.0, color="k", lw=0.8)
    for axis in axes:
        _legend(axis)
    _save(figure, "programs")


def draw_refinement(cube: dict[str, Any], shapes: dict[str, Any]) -> None:
    """End force over element size, for one-point and three-field elements."""
    figure, axes = _panels(2)
    sizes = cube["sizes_mm"]
    for k, (part, fill) in enumerate(((80, "none"), (100, "full"))):
        for name, colour, label in (
            ("clamped", PALETTE[0], "ours, clamped"), ("contact", PALETTE[1], "ours, contact"),
            ("three_field", PALETTE[3], "FEBio, three-field, clamped"),
        ):  # fmt: skip
            forces = cube[name][k]
            axes[0].semilogx(sizes[: len(forces)], forces, "o-", color=colour, ms=4, lw=1,
                             fillstyle=fill, label=f"{label}, {part} %")  # fmt: skip
    axes[0].set(title="cuboid, at 80 and 100 % of the displacement", ylabel="force [N]")
    for (name, row), colour in zip(shapes["meshes"].items(), (PALETTE[0], PALETTE[2]), strict=True):
        size = row["edge_mm"] / 2.0 ** np.arange(len(row["own_n"]))
        axes[1].semilogx(size, row["own_n"], "o-", color=colour, ms=4, lw=1, label=f"ours, {name}")
        axes[1].semilogx(size[0], row["febio_n"], "s", color=colour, ms=5, label=f"FEBio, {name}")
    axes[1].set(title="real shape under a platen", ylabel="end force [N]")
    for axis in axes:
        axis.set_xlabel("element size [mm]")
        _ticks(axis, [2, 1, 0.5, 0.25])
        _legend(axis)
    _save(figure, "refinement")


# --- document -----------------------------------------------------------------------------------


def render(found: dict[str, Any]) -> None:
    """docs/verification.md from its template."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent), undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    bench = json.loads(BENCH.read_text(encoding="utf-8")) if BENCH.exists() else None
    text = environment.get_template("verification.md.j2").render(**found, bench=bench)
    write_text(ROOT / "docs" / "verification.md", text)


CASES = (
    patch, homogeneous, element_size, time_step, loading_time, hertz, other_modes, side_by_side,
    coarse_start, half_millimetre, live, refinement, real_shapes,
)  # fmt: skip


def compute() -> None:
    """Run every case and write the numbers."""
    found: dict[str, Any] = {
        "processor": processor(),
        "versions": {**versions(), **peers.versions_of_peers()},
    }
    for case in CASES:
        start = time.process_time()
        found[case.__name__] = case()
        print(f"{case.__name__}: {time.process_time() - start:.1f} CPU s", flush=True)
    write_json(TARGET, found)


def main(task: str) -> None:
    """Run every case (unless the task is `page`), then write figures and page."""
    mpl.rcParams.update({**STYLE, "axes.prop_cycle": mpl.cycler(color=PALETTE)})
    if task != "page":
        compute()
    found = json.loads(TARGET.read_text(encoding="utf-8"))
    draw_orders(found)
    draw_hertz(found["hertz"])
    draw_programs(found["side_by_side"])
    draw_refinement(found["refinement"], found["real_shapes"])
    mechanics.main(str(FIGURES / "mechanics.png"))
    render(found)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "all")
