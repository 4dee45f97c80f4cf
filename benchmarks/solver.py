"""Speed of the explicit solver on the study's nominal cuboid; writes results/bench/solver.json.

All times are CPU seconds, of one thread. Machines differ and are busy: compare ratios within a run.
"""

import argparse
import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any

import flops
import peers
from case import EDGES, MATERIAL, TRAVEL, boundary_of, cuboid, law_materials, rates
from machine import best_cpu_seconds, fma_peak_gflops, processor, stream_gb_s
from softsample.fem.explicit import ExplicitModel, Run, SolverSettings
from softsample.io import write_json
from softsample.response.unit import find_pace
from softsample.workflow import versions

SIZES = {5980: 1e-3, 47840: 0.5e-3, 382720: 0.25e-3}
"""Edge of the elements [m] by their number in the cuboid."""

WORKER = [sys.executable, str(Path(__file__).with_name("worker.py"))]


def machine() -> dict[str, Any]:
    """What the machine can do, measured."""
    stream = stream_gb_s()
    return {
        "processor": processor(),
        "system": f"{platform.system()} {platform.machine()}",
        "fma_peak_gflops_f32": fma_peak_gflops("float32"),
        "fma_peak_gflops_f64": fma_peak_gflops("float64"),
        "stream_gb_s": max(stream.values()),
        **{f"stream_{name}_gb_s": value for name, value in stream.items()},
    }


def throughput(found: dict[str, Any]) -> list[dict[str, Any]]:
    """Rates of the kernel and their part of the peak, by size, precision and exponents."""
    operations = flops.count()
    rows = []
    for elements, size in SIZES.items():
        for precision in ("float32", "float64"):
            peak = 1e9 * found[f"fma_peak_gflops_f{precision[-2:]}"]
            for exponents in ("even", "real"):
                rate = rates(size, precision, exponents == "real")
                per_element = operations[f"{precision} {exponents}"]
                rows.append({
                    "elements": elements,
                    "precision": f"f{precision[-2:]}",
                    "exponents": exponents,
                    **rate,
                    "flops_per_element_step": per_element,
                    "fraction_of_fma_peak": rate["element_steps_per_cpu_s"] * per_element / peak,
                    "fraction_of_fma_peak_forces":
                        rate["element_forces_per_cpu_s"] * per_element / peak,
                })  # fmt: skip
                print(
                    f"{elements:>7,} elements, f{precision[-2:]}, {exponents} exponents: "
                    f"{rate['element_steps_per_cpu_s'] / 1e6:5.1f} (forces alone "
                    f"{rate['element_forces_per_cpu_s'] / 1e6:5.1f}) million per CPU s, "
                    f"{100 * rows[-1]['fraction_of_fma_peak']:.0f} % of the peak"
                )
    return rows


def by_law() -> dict[str, dict[str, float]]:
    """Whole time steps of every elastic law on elements of 1 mm, and their cost over Ogden's.

    The cost is that over the case's Ogden solid by eigenvalues, as real exponents need them.
    """
    ogden = rates(1e-3, "float32", spectral=True)["element_steps_per_cpu_s"]
    found = {}
    for name, material in law_materials().items():
        rate = rates(1e-3, "float32", material=material)["element_steps_per_cpu_s"]
        found[name] = {"element_steps_per_cpu_s": rate, "cost_over_ogden": ogden / rate}
        print(
            f"{name}: {rate / 1e6:.1f} million elements per CPU s, "
            f"{ogden / rate:.2f} times the cost of Ogden's law of real exponents"
        )
    return found


def curve(size: float, mode: str) -> dict[str, float]:
    """CPU seconds of one curve in the shortest loading time that is good enough."""
    mesh = cuboid(size)
    built = best_cpu_seconds(lambda: ExplicitModel(mesh, SolverSettings()), 1)
    model, boundary = ExplicitModel(mesh, SolverSettings()), boundary_of(mesh, mode)
    runs: list[Run] = []

    def run(loading_time: float) -> Run:
        runs.append(model.run(MATERIAL, boundary, TRAVEL[mode], loading_time=loading_time))
        return runs[-1]

    paces = []
    search = best_cpu_seconds(lambda: paces.append(find_pace(run, shortest=0.04, wanted=0.5)), 1)
    cpu = best_cpu_seconds(lambda: run(paces[0].loading_time), 2)
    return {
        "cpu_s": cpu,
        "model_cpu_s": built,
        "pilots_cpu_s": search,
        "loading_time_s": paces[0].loading_time,
        "error_percent": paces[0].error_percent,
        "steps": runs[-1].steps,
        "energy_error_percent": 100.0 * runs[-1].energy["imbalance"],
    }


def against_peers() -> dict[str, dict[str, Any]]:
    """CPU seconds of the 1 mm compression curve here and elsewhere, side by side."""
    mesh, found = cuboid(1e-3), {}
    for name, other in (("calculix", peers.calculix), ("felupe", peers.felupe)):
        if name not in peers.versions_of_peers():
            print(f"{name} is not installed: left out")
            continue
        table, cpu = other(mesh, MATERIAL, "compression", TRAVEL["compression"])
        own = curve(1e-3, "compression")
        own_cpu = own["cpu_s"] + own["model_cpu_s"]
        found[name] = {
            "cpu_s": cpu,
            "own_cpu_s": own_cpu,
            "ratio": cpu / own_cpu,
            "own_with_pilots_cpu_s": own_cpu + own["pilots_cpu_s"],
            "ratio_with_pilots": cpu / (own_cpu + own["pilots_cpu_s"]),
            "increments": len(table) - 1,
            "end_force_n": table[-1, 1],
        }
        print(
            f"{name}: {cpu:.1f} CPU s, here {own_cpu:.3f}: {found[name]['ratio']:.0f} times "
            f"({found[name]['ratio_with_pilots']:.0f} with the search for the loading time)"
        )
    return found


def processes(task: str, number: int = 1) -> list[float]:
    """What `number` workers print that run at the same time."""
    environment = {**os.environ, "NUMBA_NUM_THREADS": "1"}
    running = [
        subprocess.Popen([*WORKER, task], stdout=subprocess.PIPE, env=environment)
        for _ in range(number)
    ]
    return [float(process.communicate()[0]) for process in running]


def main(target: str) -> None:
    """Run all benchmarks and write `target`."""
    found = machine()
    print(", ".join(f"{k} {v:.0f}" if isinstance(v, float) else f"{v}" for k, v in found.items()))
    rows = throughput(found)
    laws = by_law()
    curves = {mode: curve(0.5e-3, mode) for mode in TRAVEL}
    for mode, row in curves.items():
        print(
            f" 47,840 elements, {mode}: {row['cpu_s']:.2f} CPU s in a loading time of "
            f"{1e3 * row['loading_time_s']:.0f} ms, error {row['error_percent']:.2f} % of peak"
        )
    processes("start")  # fills the cache of kernels
    start, memory, alone = (min(processes(task)) for task in ("start", "memory", "rate"))
    speedup = sum(processes("rate", 2)) / alone
    print(f"start {start:.2f} CPU s, memory {memory:.0f} MB, two runs {speedup:.2f} times one")
    result = {
        "case": {"edges_m": EDGES, "travel_m": TRAVEL, "mu_pa": MATERIAL.mu,
                 "alpha": MATERIAL.alpha, "poisson_ratio": MATERIAL.poisson_ratio},
        "machine": found,
        "throughput": rows,
        "laws": laws,
        "curve_cpu_s": {mode: row["cpu_s"] for mode, row in curves.items()},
        "curves": curves,
        "start_s": start,
        "memory_mb": memory,
        "two_runs_speedup": speedup,
        "peers": against_peers(),
        "versions": {**versions(), **peers.versions_of_peers()},
    }  # fmt: skip
    write_json(target, result)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("target", nargs="?", default="results/bench/solver.json")
    main(parser.parse_args().target)
