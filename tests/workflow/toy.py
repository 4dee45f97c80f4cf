"""A made-up study of two small samples, as cheap as a real one can be (no code under test)."""

from pathlib import Path

import nibabel
import numpy as np

LENGTH, WIDTH, HEIGHT = 13.0, 11.0, 8.0  # mm
VOXEL = 0.4  # mm
MU, ALPHA = (800.0, 200.0), (-8.0, 16.0)  # Pa, 1


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


def record(mode, seed):
    """Time [s], travel [mm], force [N] of 0.5 s of rest and a ramp at 0.3 mm/s."""
    sign, travel = (1.0, 1.6) if mode == "tension" else (-1.0, 2.0)
    time = np.round(np.arange(0.0, 0.5 + travel / 0.3, 0.02), 2)
    moved = 0.3 * np.clip(time - 0.5, 0.0, None)
    share = 1.0 if mode == "tension" else 0.54 * np.clip(moved / 1.0, 0.0, 1.0) ** 0.5
    noise = np.random.default_rng(100 + seed).normal(size=(2, len(time)))
    pull = force(1.0 + sign * moved / HEIGHT, share)
    return time, sign * moved + 1e-3 * noise[0], pull + 5e-4 * noise[1]


def write_study(folder: Path) -> Path:
    """Write images, records and the table; returns the table's path."""
    rows = ["sample\tgroup\tmode\timage\trecord"]
    for seed, (name, mode) in enumerate((("A", "tension"), ("B", "compression"))):
        nibabel.save(nibabel.Nifti1Image(*image(seed)), folder / f"{name}.nii.gz")
        columns = np.stack(record(mode, seed), axis=1)
        header = "time_s,displacement_mm,force_N"
        np.savetxt(folder / f"{name}.csv", columns, "%.4f", ",", header=header, comments="# toy\n")
        rows.append(f"{name}\tAB\t{mode}\t{name}.nii.gz\t{name}.csv")
    (folder / "samples.tsv").write_text("\n".join(rows) + "\n")
    return folder / "samples.tsv"
