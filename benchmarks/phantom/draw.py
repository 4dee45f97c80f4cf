"""Random shapes and scans from a seed: the same seed gives the same phantom."""

from typing import Literal

import numpy as np

from phantom.scan import Scan
from phantom.shapes import ImperfectCylinder
from softsample.arrays import Array
from softsample.blindlab.phantom import Shape, gradient, waves

PROTOCOLS = {"fine": (0.25, 0.25, 0.5), "isotropic": (0.6, 0.6, 0.6)}
"""Voxel edges [mm] of the study's protocols: tension and compression; shear."""


def random_cylinder(seed: int, bumps: float = 1.0) -> ImperfectCylinder:
    """Imperfect cylinder of about 20 mm diameter; `bumps` scales its waves."""
    random = np.random.default_rng([seed, 2])
    phase = random.uniform(0.0, 2.0 * np.pi, 3)
    return ImperfectCylinder(
        diameter=random.uniform(15.0, 24.0),
        height=random.uniform(8.0, 14.0),
        lobes=tuple((0.2 * bumps * random.uniform(0.3, 1.0), float(p)) for p in phase),
        wall=waves(random, 2, 0.15 * bumps, 0.0),
        top=waves(random, 4, 0.3 * bumps, 0.006),
        taper=random.uniform(-0.02, 0.06),
        slope=(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05)),
        edge=random.uniform(0.7, 1.8),
    )


def random_scan(
    seed: int, shape: Shape, protocol: Literal["fine", "isotropic"], film: float = 0.0
) -> Scan:
    """Scan with everything that disturbs: noise, bias, texture, meniscus, drops, bubble, neighbour.

    Parameters
    ----------
    seed : int
    shape : Shape
        What is imaged; drops and bubbles are put on it.
    protocol : {"fine", "isotropic"}
        Voxel edges, `PROTOCOLS`.
    film : float
        Mean thickness of the saline film [mm].
    """
    random = np.random.default_rng([seed, 3])
    drops = tuple(
        _on_wall(random, shape, 0.1, random.uniform(0.4, 0.8))
        for _ in range(random.integers(1, 3) if random.uniform() < 0.3 else 0)
    )
    bubbles = (_on_wall(random, shape, -1.2, 0.5),) if random.uniform() < 0.2 else ()
    neighbours = (_on_wall(random, shape, 4.0, 2.0),) if random.uniform() < 0.2 else ()
    tilt, spin = random.uniform(0.0, 2.5), random.uniform(-6.0, 6.0)
    axes = turned(random.uniform(-12.0, 12.0), random.uniform(0.0, 8.0), random.uniform(0, 360))
    flips = random.uniform(size=3) < 0.3
    return Scan(
        voxel=PROTOCOLS[protocol],
        rotation=turned(spin, tilt, random.uniform(0.0, 360.0)),
        place=tuple(map(float, random.uniform(-3.0, 3.0, 3))),  # type: ignore[arg-type]
        image_rotation=axes,
        snr=float(random.uniform(12.0, 40.0)),
        bias=float(random.uniform(0.05, 0.3)),
        texture=float(random.uniform(0.05, 0.35)),
        film=film,
        fluid=float(random.uniform(1.9, 2.5)),
        meniscus=float(random.uniform(0.0, 0.25)),
        drops=drops,
        bubbles=bubbles,
        neighbours=neighbours,
        flips=(bool(flips[0]), bool(flips[1]), bool(flips[2])),
        seed=int(random.integers(2**31)),
    )


def turned(about_z: float, tilt: float, towards: float) -> Array:
    """Rotation (3, 3): `about_z`, then by `tilt` towards a direction in the plane [degrees]."""
    a, t, d = np.radians([about_z, tilt, towards])
    spin = np.array([[np.cos(a), -np.sin(a), 0.0], [np.sin(a), np.cos(a), 0.0], [0.0, 0.0, 1.0]])
    axis = np.array([-np.sin(d), np.cos(d), 0.0])
    cross = np.cross(np.eye(3), axis)
    lean = np.eye(3) - np.sin(t) * cross + (1.0 - np.cos(t)) * cross @ cross
    return np.asarray(lean @ spin)


def _on_wall(
    random: np.random.Generator, shape: Shape, outward: float, radius: float
) -> tuple[float, float, float, float]:
    """Ball whose centre lies `outward` of a random place of a wall [mm]."""
    half = shape.box
    angle = random.uniform(0.0, 2.0 * np.pi)
    height = random.uniform(0.35, 0.6) * half[2]
    reach = np.arange(0.0, 1.5 * float(np.max(half)), 0.01)
    line = np.stack([reach * np.cos(angle), reach * np.sin(angle), 0.0 * reach + height], axis=1)
    place = line[np.flatnonzero(shape.value(*line.T) < 0.0)[-1]]
    normal = gradient(shape, place[None])[0]
    place = place + (outward + (radius if outward > 1.0 else 0.0)) * normal / np.linalg.norm(normal)
    return float(place[0]), float(place[1]), float(place[2]), float(radius)
