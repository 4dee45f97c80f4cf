"""Speed of the explicit solver on the study's nominal cuboid; writes results/bench/solver.json.

Figures are CPU seconds of one thread. Machines differ and are busy: compare ratios within a run.
"""

import sys
import time
from collections.abc import Callable

import numpy as np

from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.boundary import ContactSettings, glued_boundary, platen_boundary
from softsample.fem.denormals import flushed_denormals
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.io import write_json
from softsample.meshing.cuboid import mesh_cuboid
from softsample.workflow import versions

EDGES = 23e-3, 20e-3, 13e-3
TRAVEL = {"tension": 3.25e-3, "compression": 3.9e-3, "shear": 3.9e-3}
MATERIAL = OgdenMaterial((1196.8, 113.1), (-8.0, 16.0), 0.49)


def cpu_seconds(work: Callable[[], object]) -> float:
    """CPU seconds of one call."""
    start = time.process_time()
    work()
    return time.process_time() - start


def throughput(size: float, precision: str, spectral: bool) -> dict[str, object]:
    """Element evaluations per CPU second of the internal force, warm."""
    mesh = mesh_cuboid(*EDGES, size)
    model = ExplicitModel(mesh, SolverSettings(precision=precision))
    field = 1e-5 * np.random.default_rng(0).standard_normal(mesh.points.shape)
    with flushed_denormals():
        model.internal_force(field, MATERIAL, spectral)
        repeats = 3 if spectral else 20
        seconds = min(
            cpu_seconds(lambda: model.internal_force(field, MATERIAL, spectral))
            for _ in range(repeats)
        )
    return {
        "elements": len(mesh.hexes),
        "precision": precision,
        "exponents": "real" if spectral else "even",
        "element_steps_per_cpu_s": len(mesh.hexes) / seconds,
    }


def curve_seconds(size: float) -> dict[str, float]:
    """CPU seconds of one whole loading in each mode, and of compression by platen contact."""
    mesh = mesh_cuboid(*EDGES, size)
    model = ExplicitModel(mesh, SolverSettings())
    boundaries = {mode: glued_boundary(mesh, mode, mesh.glued(0.0)) for mode in TRAVEL}
    boundaries["contact"] = platen_boundary(mesh, ContactSettings())
    return {
        name: cpu_seconds(
            lambda name=name: model.run(
                MATERIAL, boundaries[name], TRAVEL.get(name, TRAVEL["compression"])
            )
        )
        for name in boundaries
    }


def main(target: str) -> None:
    """Run all benchmarks and write `target`."""
    rates = [
        throughput(size, precision, spectral)
        for size in (1e-3, 0.5e-3)
        for precision in ("float32", "float64")
        for spectral in (False, True)
    ]
    for rate in rates:
        print(
            f"{rate['elements']:>6} elements, {rate['precision']}, {rate['exponents']} exponents: "
            f"{rate['element_steps_per_cpu_s'] / 1e6:.1f} million element-steps per CPU second"
        )
    seconds = curve_seconds(0.5e-3)
    print("47,840 elements, CPU seconds per curve:", {k: round(v, 1) for k, v in seconds.items()})
    write_json(target, {"throughput": rates, "curve_cpu_s": seconds, "versions": versions()})


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "results/bench/solver.json")
