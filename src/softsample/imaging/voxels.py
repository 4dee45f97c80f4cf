"""Voxels near a surface: what a model of the scanner is fitted to."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import map_coordinates

from softsample.arrays import Array, Ids, Mask
from softsample.units import MM

BAND = (-1.2 * MM, 0.8 * MM)
"""Depth of the voxels that are fitted [m], from inside to outside."""

LEAST_SLOPE = 0.9
"""Slope of the depth across a voxel that is fitted, at least: along the edges of a sample it is
less, and the surface about which the depths are taken is rounder than they are."""

FINE = 0.16 * MM
"""Longest edge of the cells that a voxel is divided into [m]."""

MOST = 150_000
"""Voxels that are fitted at most; of more, so many are drawn."""

SEEN = 10.0
"""Logarithm of the odds that show a film."""


@dataclass(frozen=True)
class Voxels:
    """Voxels near a surface.

    Attributes
    ----------
    depth : (n, q) float64
        Signed distance of the cells of each voxel to the surface [m], negative inside.
    across : (n, 3) float64
        Change of that distance [m] along each edge of the voxel.
    parts : (3,) int
        Cells along each edge.
    edge : float
        Geometric mean of the voxel's edges [m].
    place : (n, 3) float64
        Centres in the sample frame [m].
    power, noise : (n,) float64
        Square of the intensity over that of tissue, less that of the noise; standard deviation
        of the noise. Squares, since the mean of a magnitude's square is exact at any noise.
    texture : float
        Standard deviation of the tissue about its smooth level.
    area : float
        Of the surface that they lie about [m2].
    """

    depth: Array
    across: Array
    parts: Ids
    edge: float
    place: Array
    power: Array
    noise: Array
    texture: float
    area: float

    def spread(self, expected: Array | float) -> Array:
        """Standard deviation (n,) of `power` where the intensity `expected` (n,) is."""
        noise = 4.0 * self.noise**2 * (expected**2 + self.noise**2)
        return np.sqrt(noise + (2.0 * self.texture * expected**2) ** 2)

    def thinnest_film(self, brightness: float) -> float:
        """Thickness [m] of the thinnest film that these voxels show.

        A film of thickness t and r times the tissue's brightness adds ``r (r - 1) t**2`` to the
        second moment of the edge. That changes the voxels of a layer by half of it over the square
        of their edge.
        """
        noise = float(np.median(self.spread(0.5)))  # of the intensity as well: 2 * 0.5 is 1
        moment = 2.0 * self.edge**3 * noise * np.sqrt(2.0 * SEEN / self.area)
        return float(np.sqrt(moment / (brightness * (brightness - 1.0))))


def voxels_near(
    power: Array,
    noise: Array,
    texture: float,
    usable: Mask,
    distance: Array,
    origin: Array,
    spacing: float,
    to_sample: Array,
) -> Voxels:
    """Voxels near a surface, with the depth of their cells.

    Parameters
    ----------
    power, noise : (nx, ny, nz) float64
        As of `Voxels`, on the grid of the image.
    texture : float
        As of `Voxels`.
    usable : (mx, my, mz) bool
        Where voxels may be taken, on the grid of `distance`.
    distance : (mx, my, mz) float64
        Signed distance to the surface [m], sample frame.
    origin : (3,) float64
        Position of ``distance[0, 0, 0]`` [m].
    spacing : float
        Of the grid of `distance` [m].
    to_sample : (4, 4) float64
        From voxel index to the sample frame [m].
    """
    matrix = to_sample[:3, :3] / spacing
    first = (to_sample[:3, 3] - origin) / spacing

    def looked_up(field: Array, index: Array, outside: float) -> Array:
        place = matrix @ index.T + first[:, None]
        return np.asarray(map_coordinates(field, place, order=1, cval=outside))

    index = np.indices(power.shape).reshape(3, -1).T.astype(np.float64)
    depth = looked_up(distance, index, 1.0)
    index = index[(depth > BAND[0]) & (depth < BAND[1])]
    index = index[looked_up(usable.astype(np.float64), index, 0.0) > 0.99]
    edge = np.linalg.norm(to_sample[:3, :3], axis=0)
    across = np.stack(
        [looked_up(distance, index + half, 1.0) - looked_up(distance, index - half, 1.0)
         for half in 0.5 * np.eye(3)], axis=1,
    )  # fmt: skip
    even = np.linalg.norm(across / edge, axis=1) > LEAST_SLOPE
    index, across = index[even], across[even]
    area = len(index) * float(np.prod(edge)) / (BAND[1] - BAND[0])
    if len(index) > MOST:
        drawn = np.random.default_rng(0).choice(len(index), MOST, replace=False, shuffle=False)
        index, across = index[drawn], across[drawn]
    parts = np.ceil(edge / FINE - 1e-6).astype(int)
    steps = [(np.arange(n) + 0.5) / n - 0.5 for n in parts]
    cells = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    return Voxels(
        depth=np.stack([looked_up(distance, index + cell, 1.0) for cell in cells], axis=1),
        across=across,
        parts=parts,
        edge=float(np.prod(edge) ** (1.0 / 3.0)),
        place=index @ to_sample[:3, :3].T + to_sample[:3, 3],
        power=power[tuple(index.astype(np.int64).T)],
        noise=noise[tuple(index.astype(np.int64).T)],
        texture=texture,
        area=area,
    )
