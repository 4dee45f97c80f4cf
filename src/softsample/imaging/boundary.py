"""Boundary of the tissue in the sample frame: half-maximum, film off, walls carried on."""

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from softsample.arrays import Array, Mask
from softsample.imaging import distance as sdf
from softsample.imaging import film, frame, intensity, relief
from softsample.imaging.checked import voxel_size
from softsample.imaging.settings import SegmentationSettings
from softsample.imaging.tissue import HALF, TissueShare
from softsample.imaging.voxels import voxels_near
from softsample.units import MM

FLUID_REACH_MM = 1.0
"""Around free fluid the boundary is replaced by its smooth continuation up to here [mm]: as far as
voxels and smoothing spread its light."""

CONTINUATION_MM = 1.5
"""Height of wall that gives the slope of its continuation to the base [mm]: several voxels, so that
noise does not tilt it."""

PADDING_MM = 2.5
"""Rim around the sample in the grid of the distance [mm]: room for the walls below the base."""

MOST_MISFIT = 1.5
"""Misfit up to which voxels tell the boundary. It is 0.92 to 1.04 in 8 simulated scans whose point
spread is one of those that are tried, up to 1.25 in 52 that were taken for means over voxels, and
1.9 or more in images that were blurred, whose fit was up to 0.5 mm off."""


@dataclass(frozen=True)
class Boundary:
    """Signed distance, its first grid point, its standard deviation and the mean film [m].

    And what the fitted voxels leave, over their noise, and their point spread; none if it is the
    half-maximum alone.
    """

    distance: Array
    origin: Array
    sigma: Array
    film: float
    misfit: float | None = None
    point_spread: str | None = None

    @property
    def is_fitted(self) -> bool:
        """Whether the voxels near it tell where it is, as a scan of these voxels shows an edge."""
        return self.misfit is not None and self.misfit <= MOST_MISFIT


def boundary(
    kept: Array,
    share: TissueShare,
    surface: frame.Surface,
    to_world: Array,
    sample_to_world: Array,
    settings: SegmentationSettings,
) -> Boundary:
    """Boundary in the frame `sample_to_world`: half-maximum, film off, walls carried on."""
    spacing = settings.grid_spacing_mm * MM
    origin, shape = _grid(surface, sample_to_world, spacing, PADDING_MM * MM)
    grid = frame.grid_affine(origin, spacing)
    to_sample = np.linalg.inv(sample_to_world) @ to_world
    to_voxel = np.linalg.inv(to_sample) @ grid
    local = frame.sampled(kept, to_voxel, shape, order=3)
    dips = intensity.largest_component(local > HALF) & (local <= HALF)
    local[dips] = 1.0  # next to a bubble the spline may fall below what its voxels hold
    first = round(float(settings.base_clearance_mm * MM - origin[2]) / spacing)
    raised = grid.copy()
    raised[:3, 3] += (first - 1) * grid[:3, 2]
    walls = frame.iso_surface(local[:, :, first - 1 :], HALF, raised)
    wet = frame.sampled(share.fluid.astype(np.float64), to_voxel, shape, order=1) > 0.01
    reach = FLUID_REACH_MM * MM
    away = _away(wet, spacing)
    walls = walls.where(frame.values_at(away, grid, walls.centres) > 0.75 * reach)
    rough = sdf.signed_distance(local > HALF, walls, origin, spacing)
    rough = sdf.fill_smoothly(rough, away < reach)
    hole = frame.sampled(share.hole.astype(np.float64), to_voxel, shape, order=1) > 0.01
    seen = np.minimum(away, _away(hole, spacing)) > reach
    found = _fitted(rough, seen, origin, share, to_sample, settings)
    top = int(np.argwhere(found.distance < 0.0)[:, 2].max())
    layers = max(1, min(round(CONTINUATION_MM * MM / spacing), (top - first) // 2))
    whole = found.distance
    if found.is_fitted:  # else nothing is known of the surface's error
        whole = relief.without_error(whole, found.sigma, origin, spacing)
    whole = sdf.continue_below(whole, first, layers, blur=2.0)
    outer = frame.iso_surface(-whole, 0.0, grid)
    distance = sdf.signed_distance(whole < 0.0, outer, origin, spacing)
    return replace(found, distance=distance)


def _fitted(
    rough: Array,
    seen: Mask,
    origin: Array,
    share: TissueShare,
    to_sample: Array,
    settings: SegmentationSettings,
) -> Boundary:
    """Move the half-maximum to where the voxels near it say that tissue ends."""
    spacing = settings.grid_spacing_mm * MM
    voxel = float(np.max(voxel_size(to_sample)))
    alone = Boundary(rough, origin, np.full(rough.shape, voxel / np.sqrt(12.0)), 0.0)
    if share.power is None or share.relative_noise is None:
        return alone
    height = origin[2] + spacing * np.arange(rough.shape[2])
    usable = seen & (height > settings.base_clearance_mm * MM)
    voxels = voxels_near(
        share.power, share.relative_noise, share.texture, usable, rough, origin, spacing, to_sample
    )
    fit = film.fit(voxels, settings.fluid_brightness)
    if fit.misfit > MOST_MISFIT:
        return replace(alone, misfit=fit.misfit)
    near = np.abs(rough) < 1.0 * MM
    points = origin + spacing * np.argwhere(near)
    distance, sigma = rough.copy(), np.full(rough.shape, float(np.median(fit.sigma)))
    shift, sigma[near] = fit.at(points)
    distance[near] -= shift
    return Boundary(distance, origin, sigma, fit.film, fit.misfit, fit.point_spread)


def _away(marked: Mask, spacing: float) -> Array:
    """Distance to the nearest marked grid point [m]; infinite if there is none."""
    if not marked.any():
        return np.full(marked.shape, np.inf)
    return np.asarray(ndimage.distance_transform_edt(~marked, sampling=spacing))


def _grid(
    surface: frame.Surface, sample_to_world: Array, spacing: float, padding: float
) -> tuple[Array, tuple[int, int, int]]:
    """First point and shape of a grid around a surface, with grid points at z = 0 [m]."""
    points = surface.centres - sample_to_world[:3, 3]
    points = points @ sample_to_world[:3, :3]
    low = np.floor((points.min(axis=0) - padding) / spacing)
    high = np.ceil((points.max(axis=0) + padding) / spacing)
    shape = (high - low).astype(int) + 1
    return low * spacing, (int(shape[0]), int(shape[1]), int(shape[2]))


def on_image(
    distance: Array, origin: Array, spacing: float, to_sample: Array, shape: tuple[int, ...]
) -> Mask:
    """Sample on the grid of the image: inside the surface and above the base plane."""
    to_index = np.linalg.inv(frame.grid_affine(origin, spacing)) @ to_sample
    inside = frame.sampled(distance, to_index, shape, order=1, outside=1.0) < 0.0
    i, j, k = np.ogrid[: shape[0], : shape[1], : shape[2]]
    row = to_sample[2]
    return np.asarray(inside & (row[0] * i + row[1] * j + row[2] * k + row[3] >= 0.0), dtype=bool)
