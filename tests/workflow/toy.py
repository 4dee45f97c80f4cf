"""Made-up studies of a few small samples, as cheap as real ones can be (no code under test)."""

from pathlib import Path

import nibabel
import numpy as np

LENGTH, WIDTH, HEIGHT = 13.0, 11.0, 8.0  # mm
VOXEL = 0.4  # mm
MU, ALPHA = (800.0, 200.0), (-8.0, 16.0)  # Pa, 1

ONE_ANIMAL = (("A", "AB", "tension"), ("B", "AB", "compression"))
THREE_ANIMALS = (*ONE_ANIMAL, ("D", "D", "shear"), ("E", "E", "shear"))
SHEAR_ALONE = (("D", "D", "shear"),)
"""Sample, group and mode of each row of a study."""

SEEDS = {"A": 0, "B": 1, "D": 2, "E": 3}
TRAVEL = {"tension": 1.6, "compression": -2.0, "shear": 1.6}  # mm


def image(seed):
    """Tissue (300) with rounded edges and an uneven top on a dark platen; noise 12."""
    shape = np.array([50, 46, 36])
    affine = np.diag([VOXEL, VOXEL, VOXEL, 1.0])
    affine[:3, 3] = -0.5 * VOXEL * (shape - 1) * [1, 1, 0] + [0.0, 0.0, -3.0]
    x, y, z = (VOXEL * i + affine[k, 3] for k, i in enumerate(np.indices(shape).astype(float)))
    top = HEIGHT + 0.5 * np.cos(2.0 * np.pi * x / 15.0 + seed) * np.cos(2.0 * np.pi * y / 13.0)
    outside = [
        np.abs(x) - 0.5 * LENGTH + 1.0,
        np.abs(y) - 0.5 * WIDTH + 1.0,
        z - top + 1.0,
    ]
    wall = np.linalg.norm(np.clip(outside, 0.0, None), axis=0) - 1.0
    wall = np.where(np.max(outside, axis=0) > 0.0, wall, np.max(outside, axis=0) - 1.0)
    tissue = np.clip(0.5 - np.maximum(wall, -z) / VOXEL, 0.0, 1.0)
    noise = np.random.default_rng(seed).normal(0.0, 12.0, (2, *shape))
    return np.hypot(300.0 * tissue + noise[0], noise[1]).astype(np.int16), affine


def force(stretch, share):
    """Axial force [N] of a stretched incompressible cuboid of which `share` carries load."""
    stress = sum(
        2.0 * mu / alpha * (stretch ** (alpha - 1.0) - stretch ** (-alpha / 2.0 - 1.0))
        for mu, alpha in zip(MU, ALPHA, strict=True)
    )
    return share * 1e-6 * LENGTH * WIDTH * stress


def shear_force(shear, share):
    """Force [N] of simple shear of an incompressible cuboid of which `share` carries load."""
    stretch = 0.5 * shear + np.sqrt(0.25 * shear**2 + 1.0)
    stress = sum(
        2.0 * mu / alpha * (stretch**alpha - stretch**-alpha) / (stretch + 1.0 / stretch)
        for mu, alpha in zip(MU, ALPHA, strict=True)
    )
    return share * 1e-6 * LENGTH * WIDTH * stress


def record(mode, seed):
    """Time [s], travel [mm], force [N] of 0.5 s of rest and a ramp at 0.3 mm/s."""
    time = np.round(np.arange(0.0, 0.5 + abs(TRAVEL[mode]) / 0.3, 0.02), 2)
    moved = 0.3 * np.clip(time - 0.5, 0.0, None) * np.sign(TRAVEL[mode])
    noise = np.random.default_rng(100 + seed).normal(size=(2, len(time)))
    if mode == "shear":
        push = shear_force(moved / HEIGHT, 0.75)
    else:
        late = 0.54 * np.clip(-moved, 0.0, 1.0) ** 0.5
        push = force(1.0 + moved / HEIGHT, 1.0 if mode == "tension" else late)
    return time, moved + 1e-3 * noise[0], push + 5e-4 * noise[1]


def write_study(folder: Path, samples=ONE_ANIMAL, table: str = "samples.tsv") -> Path:
    """Write images, records and the table; returns the table's path."""
    rows = ["sample\tgroup\tmode\timage\trecord"]
    for name, group, mode in samples:
        seed = SEEDS[name]
        nibabel.save(nibabel.Nifti1Image(*image(seed)), folder / f"{name}.nii.gz")
        columns = np.stack(record(mode, seed), axis=1)
        header = "time_s,displacement_mm,force_N"
        np.savetxt(folder / f"{name}.csv", columns, "%.4f", ",", header=header, comments="# toy\n")
        rows.append(f"{name}\t{group}\t{mode}\t{name}.nii.gz\t{name}.csv")
    (folder / table).write_text("\n".join(rows) + "\n")
    return folder / table
