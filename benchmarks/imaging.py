"""Accuracy of segmentation and mesh on phantoms; writes results/bench/imaging.json.

40 phantoms, both protocols, half of them with a film of up to 0.1 mm, and ten stress shapes with
doubled bumps. The seeds were used for nothing else. Prints which bars hold. Sweeps over noise,
voxel size and film, on seeds of development, are drawn by imaging_page.py.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.ndimage import map_coordinates

from phantom.draw import random_cylinder, random_scan
from phantom.scan import Scan
from phantom.shapes import ImperfectCylinder, Turned
from phantom.sizes import Sizes, measured, surface_points
from softsample.arrays import Array
from softsample.blindlab.phantom import Shape, random_cuboid
from softsample.errors import SoftsampleError
from softsample.imaging.measure import measure
from softsample.imaging.segment import Segmentation, segment
from softsample.io import write_json
from softsample.meshing.sample import mesh_real
from softsample.units import MM
from softsample.workflow import versions

Record = dict[str, Any]
Bar = tuple[str, float]

ELEMENT = 0.5 * MM
PRELOAD = 1.0 * MM
FIRST_SEED = 920_000
"""Used for nothing but this judgement; others are for development."""

SWEPT_SEEDS = (71, 72)
SWEPT_FILMS = (0.0, 0.05)
SWEEPS: dict[str, tuple[tuple[float, ...], tuple[float, ...], dict[str, float]]] = {
    "snr": ((10.0, 12.0, 16.0, 24.0, 40.0), SWEPT_FILMS, {"voxel": 0.4}),
    "voxel": ((0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0), SWEPT_FILMS, {"snr": 20.0}),
    "film": ((0.0, 0.02, 0.03, 0.04, 0.06, 0.08, 0.1), (0.0,), {"snr": 20.0, "voxel": 0.4}),
}
"""Values of what is varied, films [mm] they are combined with, and what is fixed (edges [mm])."""

MESH = ("min_scaled_jacobian", "p1_scaled_jacobian", "min_edge_over_h", "fb_length_over_h")

BARS: dict[str, dict[str, Bar]] = {
    "without film": {
        "dice": (">", 0.99),
        "volume_error_percent": ("<", 1.0),
        "mean_distance_mm": ("<", 0.06),
        "p95_distance_mm": ("<", 0.15),
        "edge_error_mm": ("<", 0.10),
        "tilt_error_deg": ("<", 0.4),
    },
    "with film": {
        "volume_error_percent": ("<", 2.0),
        "mean_distance_mm": ("<", 0.10),
        "edge_error_mm": ("<", 0.20),
        "tilt_error_deg": ("<", 0.4),
    },
    "meshes": {
        "min_scaled_jacobian": (">", 0.40),
        "p1_scaled_jacobian": (">", 0.65),
        "min_edge_over_h": (">", 0.5),
        "fb_length_over_h": (">", 0.62),
        "mesh_volume_percent": ("<", 0.2),
        "mesh_distance_mm": ("<", 0.01),
        "mesh_cpu_s": ("<", 15.0),
    },
}
"""Each holds for 38 of 40 phantoms, and half of it for the median where less is better.

Surfaces with and without film are counted together, each as a share of its own limit.
"""

COVERAGE = (0.60, 0.76)
"""Share of the true surface within the stated one-sigma band, pooled."""


def phantom(seed: int, film: bool, bumps: float = 1.0) -> tuple[Shape, Scan]:
    """Shape and scan of a seed; every fourth is a cylinder, protocols take turns."""
    shape = (random_cylinder if seed % 8 >= 6 else random_cuboid)(seed, bumps)
    thickness = float(np.random.default_rng([seed, 4]).uniform(0.02, 0.1)) if film else 0.0
    return shape, random_scan(seed, shape, "isotropic" if seed % 2 else "fine", thickness)


def judged(shape: Shape, scan: Scan, mesh: bool = True) -> Record:
    """All numbers of one phantom; `status` says what failed."""
    edges = set(scan.voxel)
    record: Record = {
        "protocol": "isotropic" if len(edges) == 1 else "fine",
        "voxel_mm": float(np.prod(scan.voxel) ** (1.0 / 3.0)),
        "film_mm": scan.film,
        "snr": scan.snr,
    }
    image, affine = scan.image(shape)
    try:
        start = time.process_time()
        found = segment(image, affine)
        record |= {"segment_cpu_s": time.process_time() - start, "film_found_mm": found.film / MM}
        record |= accuracy(found, shape, scan)
        if mesh:
            record |= mesh_quality(found)
    except SoftsampleError as error:
        return {**record, "status": str(error)}
    return {**record, "status": "ok"}


def sweeps() -> dict[str, list[Record]]:
    """Records of small cuboids whose scans differ in one thing."""
    return {
        name: [
            {"seed": seed, **swept(seed, **{"film": film, **fixed, name: value})}
            for value in values
            for film in films
            for seed in SWEPT_SEEDS
        ]
        for name, (values, films, fixed) in SWEEPS.items()
    }


def swept(seed: int, snr: float, voxel: float, film: float) -> Record:
    """Numbers of a cuboid of about 14 x 12 x 9 mm without drops, bubbles and neighbours."""
    whole = random_cuboid(seed)
    shape = replace(
        whole, length=0.6 * whole.length, width=0.6 * whole.width, height=0.75 * whole.height
    )
    scan = replace(
        random_scan(seed, shape, "isotropic", film),
        voxel=(voxel,) * 3,
        snr=snr,
        drops=(),
        bubbles=(),
        neighbours=(),
    )
    return judged(shape, scan, mesh=False)


def accuracy(found: Segmentation, shape: Shape, scan: Scan) -> Record:
    """Segmentation against the known shape."""
    x = scan.rotation.T @ found.sample_to_world[:3, 0]
    round_one = isinstance(shape, ImperfectCylinder)  # its axes are free, a cuboid's are its walls'
    true = measured(Turned(shape, float(np.arctan2(x[1], x[0]))) if round_one else shape)
    mask = scan.tissue_mask(shape)
    points, vectors = surface_points(shape, step=0.4)
    area = np.linalg.norm(vectors, axis=1)
    gap, sigma = at_true_surface(found, scan, points)
    order = np.argsort(np.abs(gap))
    share = np.cumsum(area[order]) / area.sum()
    normal = scan.rotation[:, 2] @ found.sample_to_world[:3, 2]
    return {
        "dice": 2.0 * float(np.sum(mask & found.mask) / (np.sum(mask) + np.sum(found.mask))),
        "volume_error_percent": 100.0 * (found.volume / MM**3 / true.volume - 1.0),
        "mean_distance_mm": float(np.abs(gap) @ area / area.sum()),
        "mean_signed_distance_mm": float(gap @ area / area.sum()),
        "p95_distance_mm": float(np.abs(gap)[order][np.searchsorted(share, 0.95)]),
        "edge_error_mm": edge_error(found, true),
        "tilt_error_deg": float(np.degrees(np.arccos(np.clip(normal, -1.0, 1.0)))),
        "band_coverage": float((np.abs(gap) <= sigma) @ area / area.sum()),
        "sigma_mm": float(sigma @ area / area.sum()),
        "surface_mm2": float(area.sum()),
    }


def at_true_surface(found: Segmentation, scan: Scan, points: Array) -> tuple[Array, Array]:
    """Way (n,) outward from true surface points to the one found, and its one-sigma [mm]."""
    to_found = np.linalg.inv(found.sample_to_world)
    world = MM * (points @ scan.rotation.T + scan.place)
    place = world @ to_found[:3, :3].T + to_found[:3, 3]
    index = ((place - found.origin) / found.spacing).T
    gap = -map_coordinates(found.distance, index, order=3, mode="nearest")
    return gap / MM, map_coordinates(found.sigma, index, order=1, mode="nearest") / MM


def edge_error(found: Segmentation, true: Sizes) -> float:
    """Largest error of length, width and height of the cuboid [mm]."""
    cuboid = measure(found.distance, found.origin, found.spacing)
    names = ("length", "width", "height")
    return max(abs(cuboid[f"{name}_mm"] - getattr(true, name)) for name in names)


def mesh_quality(found: Segmentation) -> Record:
    """Mesh at 0.5 mm of the surface found."""
    report = mesh_real(found.distance, found.origin, found.spacing, ELEMENT, PRELOAD).report
    return {
        **{name: report[name] for name in MESH},
        "inverted": report["inverted"],
        "mesh_volume_percent": report["volume_difference_percent"],
        "mesh_distance_mm": report["mean_distance_mm"],
        "mesh_cpu_s": report["cpu_s"],
    }


@dataclass(frozen=True)
class Verdict:
    """Of one bar over records: how many keep it, and the median and the worst value.

    Median and worst are over the limits where these differ, otherwise values.
    """

    name: str
    relation: str
    limits: tuple[float, ...]
    kept: int
    count: int
    median: float
    worst: float

    @property
    def holds(self) -> bool:
        """38 of 40 keep the bar; where less is better, the median keeps its half."""
        half = 0.5 if self.relation == "<" else 1.0
        limit = 1.0 if len(self.limits) > 1 else self.limits[0]
        middle = self.median < half * limit if self.relation == "<" else self.median > limit
        return bool(middle and self.kept >= np.ceil(38 / 40 * self.count))

    def __str__(self) -> str:
        limits = " or ".join(f"{limit:g}" for limit in self.limits)
        unit = " of the limit" if len(self.limits) > 1 else ""
        return (
            f"{'holds' if self.holds else 'FAILS'}  {self.name} {self.relation} {limits}:"
            f" {self.kept} of {self.count}, median {self.median:.3g}, worst {self.worst:.3g}{unit}"
        )


def verdicts(records: list[Record], bars: Callable[[Record], dict[str, Bar]]) -> list[Verdict]:
    """Verdicts over `records`, each held to its own `bars`. A missing value keeps none."""
    found = []
    for name in dict.fromkeys(name for record in records for name in bars(record)):
        held = [(abs(r.get(name, np.nan)), *bars(r)[name]) for r in records if name in bars(r)]
        relation, limits = held[0][1], sorted({limit for _, _, limit in held})
        value, limit = np.array([(v, bar) for v, _, bar in held]).T
        kept = value < limit if relation == "<" else value > limit
        shown = value / limit if len(limits) > 1 else value
        worst = float((np.nanmax if relation == "<" else np.nanmin)(shown))
        found.append(
            Verdict(
                name, relation, tuple(limits), int(kept.sum()), len(held),
                float(np.nanmedian(shown)), worst,
            )
        )  # fmt: skip
    return found


def surface_bars(record: Record) -> dict[str, Bar]:
    """Bars of a phantom's surface."""
    return BARS["with film" if record["film_mm"] > 0.0 else "without film"]


def mesh_bars(_: Record) -> dict[str, Bar]:
    """Bars of a mesh."""
    return BARS["meshes"]


def coverage(records: list[Record]) -> float:
    """Share of the true surface of all `records` that finished within the stated band."""
    good = [r for r in records if r["status"] == "ok"]
    area = np.array([r["surface_mm2"] for r in good])
    return float(np.array([r["band_coverage"] for r in good]) @ area / area.sum())


def halves(phantoms: list[Record]) -> dict[str, list[Record]]:
    """Records without film and with one."""
    return {
        "without film": [r for r in phantoms if r["film_mm"] == 0.0],
        "with film": [r for r in phantoms if r["film_mm"] > 0.0],
    }


def summary(phantoms: list[Record], stress: list[Record]) -> list[str]:
    """What is printed: the bars, then each half for information."""
    share = coverage(phantoms)
    holds = "holds" if COVERAGE[0] <= share <= COVERAGE[1] else "FAILS"
    lines = ["surfaces:", *map(str, verdicts(phantoms, surface_bars))]
    lines.append(f"{holds}  band_coverage, pooled: {share:.3f}")
    if any("mesh_cpu_s" in r for r in phantoms):
        lines += ["meshes:", *map(str, verdicts(phantoms, mesh_bars))]
        lines += ["stress meshes:", *map(str, verdicts(stress, mesh_bars))]
    for name, records in halves(phantoms).items():
        lines.append(f"{name}, for information: coverage {coverage(records):.3f}")
        lines += [str(verdict).partition("  ")[2] for verdict in verdicts(records, surface_bars)]
    return lines + [f"{r['seed']}: {r['status']}" for r in phantoms + stress if r["status"] != "ok"]


def main() -> None:
    """Judge all phantoms and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("target", nargs="?", default="results/bench/imaging.json")
    parser.add_argument("--first-seed", type=int, default=FIRST_SEED)
    parser.add_argument("--phantoms", type=int, default=40)
    parser.add_argument("--stress", type=int, default=10)
    parser.add_argument("--no-mesh", action="store_true", help="segmentation alone")
    given = parser.parse_args()
    first, mesh = given.first_seed, not given.no_mesh
    phantoms = [
        told(first + n, judged(*phantom(first + n, film=(n // 2) % 2 == 1), mesh))
        for n in range(given.phantoms)
    ]
    stress = [
        told(first + 500 + n, judged(*phantom(first + 500 + n, film=False, bumps=2.0)))
        for n in range(given.stress)
    ]
    print("\n".join(summary(phantoms, stress)))
    table = {"phantoms": phantoms, "stress_meshes": stress, "sweeps": sweeps()}
    write_json(given.target, {**table, "versions": versions()})


def told(seed: int, record: Record) -> Record:
    """The record with its seed, printed."""
    numbers = " ".join(f"{k}={v:.4g}" for k, v in record.items() if isinstance(v, float))
    print(seed, record["protocol"], numbers, record["status"], flush=True)
    return {"seed": seed, **record}


if __name__ == "__main__":
    main()
