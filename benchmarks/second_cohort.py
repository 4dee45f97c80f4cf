"""The second virtual cohort: shapes, images, and records of CalculiX.

Nothing of the solver, the mesher or the segmentation takes part: the shapes are those of the
phantom laboratory, a mapped grid of hexahedra with incompatible modes fills them, and CalculiX runs
the tests. Sharp and round rims occur in each mode, exponents differ between animals, the relief is
about 0.6 of that of the first cohort, and a record ends at the limit of the load cell. Runs are
kept below results/bench/second-cohort, and what is there is not made again.
"""

import os
import subprocess
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal

import nibabel
import numpy as np
import pandas as pd

from laws import noisy_record
from peers import read_calculix_forces
from phantom.draw import random_scan
from phantom.scan import Scan
from phantom.sizes import measured
from softsample.arrays import Array, Ids, Mask
from softsample.blindlab.phantom import ImperfectCuboid, gradient, random_cuboid
from softsample.constitutive.material import Material, Term
from softsample.export.abaqus import material_lines
from softsample.io import write_json, write_text

ROOT = Path(__file__).parents[1]
COHORT = ROOT / "resources" / "second-cohort"
BENCH = ROOT / "results" / "bench" / "second-cohort"

FIRST_SEED = 940_000
"""Used for nothing else."""

POISSON = 0.49
BOND_MM = 1.0
CELL_N = 2.5
TRAVEL_MM = {"tension": 3.25, "compression": 3.9, "shear": 3.9}
REST_S, HZ, SPEED_MM_S = 0.5, 100.0, 0.3
LEAST = 0.6
"""Part of the travel that CalculiX has to come through; the record ends where it stops."""

EDGES_MM = (1.2, 1.6, 2.2, 3.0, 3.8)
"""Radii of the rims, one for each sample of a mode: from sharp to round."""

ELEMENT, ELEMENT_MM = "C3D8I", 1.0
"""Eight nodes and incompatible modes, and the edge."""

INCREMENTS = 25
PENALTY = 20.0
"""Stiffness of the contact over the bulk modulus [1/mm]."""

STICK = 0.1
"""Stiffness along the platen over that across it; with more, CalculiX finds no equilibrium."""


@dataclass(frozen=True)
class Sample:
    """One sample, and the material of its animal."""

    name: str
    group: str
    mode: Literal["tension", "compression", "shear"]
    shape: ImperfectCuboid
    scan: Scan
    moduli: tuple[float, float]
    exponents: tuple[float, float]
    seed: int

    @property
    def material(self) -> Material:
        """Two Ogden terms."""
        terms = zip(self.moduli, self.exponents, strict=True)
        return Material(tuple(Term("ogden", mu, (alpha,)) for mu, alpha in terms), POISSON)


def samples() -> list[Sample]:
    """All, drawn from their seeds; rims of each mode in another order."""
    found = []
    for order, mode in enumerate(("shear", "tension", "compression")):
        rims = np.random.default_rng([FIRST_SEED, order]).permutation(EDGES_MM)
        for number, rim in enumerate(rims, 1):
            group = f"{'S' if mode == 'shear' else 'TC'}{number}"
            seed = FIRST_SEED + 100 * order + number
            random = np.random.default_rng([seed, 5])
            shape = replace(
                random_cuboid(seed),
                length=random.uniform(21.0, 23.0),
                width=random.uniform(18.0, 20.0),
                height=random.uniform(11.8, 13.0),
                taper=random.uniform(0.0, 0.04),
                edge=float(rim),
            )
            tissue = np.random.default_rng([FIRST_SEED, 10 if mode == "shear" else 20, number])
            modulus, share = tissue.uniform(800.0, 1900.0), tissue.uniform(0.75, 0.95)
            scan = random_scan(
                seed, shape, "isotropic" if mode == "shear" else "fine",
                float(random.uniform(0.0, 0.03)),
            )  # fmt: skip
            found.append(Sample(
                f"{mode[0].upper()}{number}", group, mode, shape,  # type: ignore[arg-type]
                replace(scan, bubbles=()),  # the mesh has none
                (round(share * modulus, 1), round((1.0 - share) * modulus, 1)),
                (round(-tissue.uniform(5.0, 12.0), 2), round(tissue.uniform(10.0, 20.0), 2)),
                seed,
            ))  # fmt: skip
    return found


# --- mesh ---------------------------------------------------------------------------------------

CUBE = np.array(
    [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
)
"""Corners of an element in the grid, as CalculiX counts them."""

SMOOTHING = 60
"""Rounds that even out the grid and put its skin back onto the shape."""


@dataclass(frozen=True)
class Mesh:
    """Eight-node hexahedra.

    Attributes
    ----------
    points : (n, 3) float64
        Nodes [mm].
    elements : (m, 8) int64
        Nodes as CalculiX counts them.
    base, skin : int64
        Nodes in z = 0, and those of the free surface; they share the base's rim.
    """

    points: Array
    elements: Ids
    base: Ids
    skin: Ids


def mesh_of(shape: ImperfectCuboid) -> Mesh:
    """A grid of hexahedra between the base and the surface of a shape."""
    size = np.array([shape.length, shape.width, shape.height])
    count = np.rint(size / ELEMENT_MM).astype(int)
    grid = start(size, count)
    for _ in range(SMOOTHING):
        for axes in ((0, 1, 2), (0, 1), (0, 2), (1, 2), (0,), (1,), (2,)):
            grid = evened(grid, axes)
        grid = projected(shape, grid)
    name = np.arange(grid[..., 0].size).reshape(grid.shape[:3])
    cells = np.stack(np.meshgrid(*map(np.arange, count), indexing="ij"), -1).reshape(-1, 1, 3)
    level, wall = sides(name.shape)
    elements = name[tuple(np.moveaxis(cells + CUBE, -1, 0))]
    return Mesh(grid.reshape(-1, 3), elements, name[level], name[wall])


def start(size: Array, count: Ids) -> Array:
    """Corner nodes (i, j, k, 3) of a block whose sections are between a square and a disc."""
    u, v, w = np.meshgrid(*(np.linspace(-1.0, 1.0, n + 1) for n in count), indexing="ij")
    blend = 0.35
    x = u * np.sqrt(1.0 - blend * v**2 / 2.0)
    y = v * np.sqrt(1.0 - blend * u**2 / 2.0)
    return 0.5 * size * np.stack([x, y, w + 1.0], axis=-1)


def evened(grid: Array, axes: tuple[int, ...]) -> Array:
    """Means over neighbours along `axes` of the nodes that are inner ones along just these."""
    shape = grid.shape[:3]
    inner = [(np.arange(n) > 0) & (np.arange(n) < n - 1) for n in shape]
    where = np.ones(shape, dtype=bool)
    for axis in range(3):
        along = inner[axis].reshape([-1 if a == axis else 1 for a in range(3)])
        where &= along if axis in axes else ~along
    total = sum(np.roll(grid, step, axis) for axis in axes for step in (-1, 1))
    return np.where(where[..., None], total / (2 * len(axes)), grid)


def projected(shape: ImperfectCuboid, grid: Array) -> Array:
    """The grid with its base in z = 0 and the rest of its skin on the shape."""
    grid = grid.copy()
    grid[:, :, 0, 2] = 0.0
    level, wall = sides(grid.shape[:3])
    grid[wall] = onto(shape, grid[wall], level[wall])
    return grid


def sides(shape: tuple[int, ...]) -> tuple[Mask, Mask]:
    """Nodes of a grid in the base, and those on the free surface."""
    level, wall = np.zeros(shape, dtype=bool), np.zeros(shape, dtype=bool)
    level[:, :, 0] = True
    wall[[0, -1]] = wall[:, [0, -1]] = wall[:, :, -1] = True
    return level, wall


def onto(shape: ImperfectCuboid, points: Array, level: Mask) -> Array:
    """Points (n, 3) moved onto the surface along its normal, those of `level` in their plane."""
    for _ in range(4):
        slope = gradient(shape, points)
        slope[level, 2] = 0.0
        size = np.einsum("ij,ij->i", slope, slope)
        points = points - (shape.value(*points.T) / size)[:, None] * slope
    return points


# --- tests in CalculiX --------------------------------------------------------------------------


def curve_of(sample: Sample) -> tuple[Array, Array]:
    """Way of the platen [m] and size of its force [N].

    Raises
    ------
    RuntimeError
        If CalculiX stops before `LEAST` of the step.
    """
    folder = BENCH / "calculix" / sample.name
    if not (folder / "done").exists():
        folder.mkdir(parents=True, exist_ok=True)
        mesh, highest = mesh_of(sample.shape), measured(sample.shape, 0.2).highest
        lines = [*solid(mesh, sample.material), *test_of(sample, mesh, highest)]
        write_text(folder / "test.inp", "\n".join(lines) + "\n")
        with (folder / "log").open("w") as log:
            subprocess.run(
                ["ccx", "test"], cwd=folder, check=False, stdout=log,
                env={**os.environ, "OMP_NUM_THREADS": "1"},
            )  # fmt: skip
    time, force = read_calculix_forces(folder / "test.dat")
    size = np.abs(force[:, 0 if sample.mode == "shear" else 2])
    if time[-1] < LEAST:
        raise RuntimeError(f"{folder}: CalculiX stopped at {time[-1]:.0%}")
    (folder / "done").touch()
    return 1e-3 * TRAVEL_MM[sample.mode] * time, size


def solid(mesh: Mesh, material: Material) -> Iterator[str]:
    """Nodes, elements and material."""
    yield "*NODE, NSET=SAMPLE"
    for number, point in enumerate(mesh.points, 1):
        yield ", ".join([str(number), *(f"{x:.9g}" for x in point)])
    yield f"*ELEMENT, TYPE={ELEMENT}, ELSET=SAMPLE"
    for number, nodes in enumerate(mesh.elements + 1, 1):
        yield ", ".join(map(str, (number, *nodes)))
    yield from node_set("BASE", mesh.base)
    yield from material_lines(material, "calculix")
    yield "*SOLID SECTION, ELSET=SAMPLE, MATERIAL=TISSUE"


def node_set(name: str, nodes: Ids) -> Iterator[str]:
    """A set of nodes."""
    yield f"*NSET, NSET={name}"
    yield from (f"{node + 1}," for node in nodes)


def test_of(sample: Sample, mesh: Mesh, highest: float) -> Iterator[str]:
    """Ends and step: bonded nodes that move, or a platen that the free surface meets."""
    if sample.mode == "compression":
        yield from platen(mesh, sample.material, highest)
    else:
        yield from node_set("MOVED", bonded_nodes(mesh, highest))
    travel = TRAVEL_MM[sample.mode]
    way = {"tension": (0.0, 0.0, travel), "compression": (0.0, 0.0, -travel),
           "shear": (travel, 0.0, 0.0)}[sample.mode]  # fmt: skip
    yield "*BOUNDARY"
    yield "BASE, 1, 3"
    yield f"*STEP, NLGEOM=YES, INC={100 * INCREMENTS}"
    yield "*STATIC"
    yield f"{1.0 / INCREMENTS:.6g}, 1.0, 1e-7, {1.0 / INCREMENTS:.6g}"
    yield "*BOUNDARY"
    yield from (f"MOVED, {axis}, {axis}, {u:.9g}" for axis, u in enumerate(way, 1))
    yield "*NODE PRINT, NSET=MOVED, TOTALS=ONLY"
    yield "RF"
    yield "*END STEP"


def bonded_nodes(mesh: Mesh, highest: float) -> Ids:
    """Nodes that the platen glues."""
    return mesh.skin[mesh.points[mesh.skin, 2] >= highest - BOND_MM]


def platen(mesh: Mesh, material: Material, height: float) -> Iterator[str]:
    """A block of one element above the sample, and rough contact with its lower face."""
    first, number = len(mesh.points), len(mesh.elements) + 1
    reach = 1.5 * np.abs(mesh.points[:, :2]).max()
    yield "*NODE, NSET=MOVED"
    ring = ((-reach, -reach), (reach, -reach), (reach, reach), (-reach, reach))
    corners = [(x, y, z) for z in (height, height + 4.0) for x, y in ring]
    for k, (x, y, z) in enumerate(corners, first + 1):
        yield f"{k}, {x:.9g}, {y:.9g}, {z:.9g}"
    yield "*ELEMENT, TYPE=C3D8, ELSET=PLATEN"
    yield ", ".join(map(str, [number, *range(first + 1, first + 9)]))
    yield "*MATERIAL, NAME=PLATE"
    yield "*ELASTIC"
    yield "1.0, 0.3"
    yield "*SOLID SECTION, ELSET=PLATEN, MATERIAL=PLATE"
    yield "*SURFACE, NAME=LOWER, TYPE=ELEMENT"
    yield f"{number}, S1"
    yield from node_set("FREE", np.setdiff1d(mesh.skin, mesh.base))
    yield "*SURFACE, NAME=FREENODES, TYPE=NODE"
    yield "FREE"
    penalty = PENALTY * material.bulk_modulus / 1e6
    yield "*CONTACT PAIR, INTERACTION=ROUGH, TYPE=NODE TO SURFACE"
    yield "FREENODES, LOWER"
    yield "*SURFACE INTERACTION, NAME=ROUGH"
    yield "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"
    # elements that cover every gap from the start slip while open and stick once closed
    yield f"{penalty:.9g}, {1e-10 * penalty:.9g}, {4.0 * height / ELEMENT_MM:.9g}"
    yield "*FRICTION"
    yield f"100.0, {STICK * penalty:.9g}"


# --- the cohort ---------------------------------------------------------------------------------


def record_of(sample: Sample) -> pd.DataFrame:
    """The record with its noise, as far as the load cell goes."""
    way, force = curve_of(sample)
    record = noisy_record(way, force, sample.mode, sample.seed, HZ, REST_S)
    over = np.flatnonzero(record["force_N"].abs() >= CELL_N)
    return record.iloc[: over[0]] if len(over) else record


def truth_of(sample: Sample, record: pd.DataFrame) -> dict[str, Any]:
    """What the study is not told."""
    mesh, sizes = mesh_of(sample.shape), measured(sample.shape)
    bonded = np.zeros(len(mesh.points), dtype=bool)
    if sample.mode != "compression":
        bonded[bonded_nodes(mesh, sizes.highest)] = True
    return {
        "sample": sample.name,
        "group": sample.group,
        "mode": sample.mode,
        "shape": {
            **asdict(sample.shape),
            "statistics": {
                "L_mm": sizes.length,
                "W_mm": sizes.width,
                "H_mm": sizes.height,
                "bottom_area_mm2": sizes.bottom_area,
                "top_area_mm2": sizes.top_area,
                "volume_mm3": sizes.volume,
                "highest_point_mm": sizes.highest,
            },
        },
        "sample_to_world": sample.scan.sample_to_world.tolist(),
        "mesh": {
            "element": ELEMENT,
            "element_mm": ELEMENT_MM,
            "elements": len(mesh.elements),
            "nodes": len(mesh.points),
            "volume_mm3": volume(mesh),
            "highest_point_mm": sizes.highest,
            "glued_top_area_projected_mm2": projected_area(mesh, bonded),
        },
        "material": {
            "model": "Ogden N=2",
            "mu1_Pa": sample.moduli[0],
            "mu2_Pa": sample.moduli[1],
            "alpha": sample.exponents,
            "nu": POISSON,
        },
        "max_travel_mm": float(record["displacement_mm"].abs().max()),
        "effects": [],
    }


def volume(mesh: Mesh) -> float:
    """Volume [mm3]: five tetrahedra an element, both ways of cutting it averaged."""
    cuts = [(0, 1, 2, 5), (0, 2, 3, 7), (0, 5, 7, 4), (2, 7, 5, 6), (0, 2, 7, 5)]
    corners = mesh.points[mesh.elements]
    total = 0.0
    for turn in ((0, 1, 2, 3, 4, 5, 6, 7), (1, 2, 3, 0, 5, 6, 7, 4)):
        for a, b, c, d in np.array(turn)[np.array(cuts)]:
            sides = corners[:, [b, c, d]] - corners[:, [a]]
            total += np.linalg.det(sides).sum() / 6.0
    return float(0.5 * total)


def projected_area(mesh: Mesh, bonded: Mask) -> float:
    """Area, seen from above, of the faces on the skin whose four nodes are all bonded [mm2]."""
    skin = np.zeros(len(mesh.points), dtype=bool)
    skin[mesh.skin] = True
    total = 0.0
    for face in ((4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)):
        nodes = mesh.elements[:, face]
        x = mesh.points[nodes[(skin & bonded)[nodes].all(axis=1)]]
        total += 0.5 * np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])[:, 2].sum()
    return float(total)


def write_sample(sample: Sample) -> None:
    """Image, record and truth of one sample."""
    record = record_of(sample)
    image, affine = sample.scan.image(sample.shape)
    written = nibabel.Nifti1Image(image, affine)
    written.header.set_xyzt_units("mm")
    nibabel.save(written, COHORT / "images" / f"{sample.name}.nii.gz")
    record.to_csv(COHORT / "records" / f"{sample.name}.csv", index=False)
    write_json(COHORT / "truth" / f"{sample.name}.json", truth_of(sample, record))


def main() -> None:
    """Make the cohort."""
    for folder in ("images", "records", "truth"):
        (COHORT / folder).mkdir(parents=True, exist_ok=True)
    found = samples()
    with ThreadPoolExecutor(int(os.environ.get("CORES", "2"))) as pool:
        list(pool.map(write_sample, found))
    rows = [
        {
            "sample": s.name, "group": s.group, "mode": s.mode,
            "image": f"images/{s.name}.nii.gz", "record": f"records/{s.name}.csv",
        }
        for s in found
    ]  # fmt: skip
    pd.DataFrame(rows).to_csv(COHORT / "samples.tsv", sep="\t", index=False)


if __name__ == "__main__":
    main()
