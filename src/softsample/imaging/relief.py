"""A top that is flat as far as its image shows, without the error of its surface."""

import numpy as np
from scipy import ndimage

from softsample.arrays import Array, Mask
from softsample.imaging.measure import section, top_heights
from softsample.units import MM

SHOWN = 1.9
"""Standard deviation of the top about its plane, over that of the surface's error, from which on it
is relief: of 60 samples with relief the least had 2.7, of 17 flat ones the most had 1.3. Of others,
drawn later, eight with relief had 3.4 at least, four flat ones 1.0 at most."""

BELOW_MM = 1.0
"""Depth below the highest point at which the section of the top is taken [mm]."""

RIM_MM = 1.5
"""The top nearer to its rim than this has no say [mm]: voxels and smoothing round its edge."""

EDGE_MM = (0.5, 1.0)
"""From its rim inward, where the top begins to be replaced, and from where it is in full [mm]."""

DEPTH_MM = (1.0, 2.0)
"""Depth below the top down to which the distance moves with it, in full and at all [mm]."""

LEAST = 30
"""Columns of the grid that a top has at least."""


def without_error(distance: Array, sigma: Array, origin: Array, spacing: float) -> Array:
    """Signed distance with a plane for a top that shows no relief.

    The highest point of a flat top would be that of the surface's error, several standard
    deviations too high; at its rim by the more as voxels round the edge. A platen that presses from
    there meets the tissue too late.

    Parameters
    ----------
    distance, sigma : (nx, ny, nz) float64
        Signed distance, negative inside, and standard deviation of its error [m].
    origin : (3,) float64
        Position of ``distance[0, 0, 0]`` [m].
    spacing : float
        Of the grid [m].

    Returns
    -------
    (nx, ny, nz) float64
        The distance [m]; as it was where the top has relief, or is small.
    """
    top = top_heights(distance, origin, spacing)
    plane = section(distance, origin, spacing, float(np.nanmax(top)) - BELOW_MM * MM)
    away = ndimage.distance_transform_edt(plane < 0.0, sampling=spacing) / MM
    seen = (away > RIM_MM) & np.isfinite(top)
    flat = _plane(top, sigma, seen, origin, spacing)
    if flat is None:
        return distance
    height = origin[2] + spacing * np.arange(distance.shape[2])
    below = (flat[:, :, None] - height) / MM
    inner = np.clip((away - EDGE_MM[0]) / (EDGE_MM[1] - EDGE_MM[0]), 0.0, 1.0)
    near = np.clip((DEPTH_MM[1] - below) / (DEPTH_MM[1] - DEPTH_MM[0]), 0.0, 1.0)
    raised = np.where(np.isfinite(top), flat - top, 0.0) * inner
    moved = distance - raised[:, :, None] * near
    return np.asarray(np.maximum(moved, -below * MM))


def _plane(top: Array, sigma: Array, seen: Mask, origin: Array, spacing: float) -> Array | None:
    """Plane (nx, ny) [m] that the top is as far as the error of its surface shows, if it is one."""
    i, j = np.nonzero(seen)
    if len(i) < LEAST:
        return None
    layer = np.round((top[i, j] - origin[2]) / spacing).astype(int)
    error = float(np.median(sigma[i, j, layer]))
    terms = np.stack([np.ones(top.shape), *np.indices(top.shape)], axis=-1)
    plane = terms @ np.linalg.lstsq(terms[i, j], top[i, j], rcond=None)[0]
    relief = float(np.std(top[i, j] - plane[i, j]))
    return np.asarray(plane) if relief < SHOWN * error else None
