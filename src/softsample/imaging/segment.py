"""Segmentation of a tissue sample on a platen: image to signed distance in the sample frame.

The steps and the definitions are in ``docs/geometry.md``.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsample.arrays import Array, Mask
from softsample.errors import SegmentationError
from softsample.imaging import distance as sdf
from softsample.imaging import doubts, frame, intensity, platen, region
from softsample.imaging.boundary import boundary, on_image
from softsample.imaging.checked import checked_axes, checked_image, voxel_size
from softsample.imaging.settings import SegmentationSettings
from softsample.imaging.tissue import HALF, TissueShare, blur_of, cavities, margin_of, tissue_share
from softsample.meshing.levelset import highest_point
from softsample.units import MM


@dataclass(frozen=True)
class Segmentation:
    """A segmented sample.

    Attributes
    ----------
    mask : (nx, ny, nz) bool
        Sample on the grid of the image.
    distance : (mx, my, mz) float64
        Signed distance on a grid along the sample frame [m], negative inside. The walls go on
        below the base plane z = 0, which is not part of the surface.
    origin : (3,) float64
        Position of ``distance[0, 0, 0]`` in the sample frame [m].
    spacing : float
        Grid spacing of `distance` [m].
    sample_to_world : (4, 4) float64
        Rigid map from the sample frame to world RAS+ [m].
    sigma : (mx, my, mz) float64
        One standard deviation of the position of the surface nearest to each grid point [m].
    flags : tuple of str
        Peculiarities a person should look at.
    film : float
        Mean thickness of the film of fluid that was taken off [m].
    point_spread : str or None
        Of the image, if its voxels tell: one of `softsample.imaging.point_spread.POINT_SPREADS`.
    tilt : float
        Angle between the base normal and the nominal loading axis [rad].
    base_spread : float
        Robust standard deviation of the base about its plane [m].
    snr, noise, tissue_level, threshold : float
        Signal to noise ratio, standard deviation of the noise, median level of the tissue and
        median threshold at the boundary, intensities as in the image. NaN for a given mask or
        surface, the first two also where the surroundings have no noise.
    doubts : tuple of str
        Why this may be something else than the sample, with cures.
    """

    mask: Mask
    distance: Array
    origin: Array
    spacing: float
    sample_to_world: Array
    sigma: Array
    flags: tuple[str, ...]
    film: float = 0.0
    point_spread: str | None = None
    tilt: float = 0.0
    base_spread: float = 0.0
    snr: float = np.nan
    noise: float = np.nan
    tissue_level: float = np.nan
    threshold: float = np.nan
    doubts: tuple[str, ...] = ()

    @property
    def grids_mm(self) -> dict[str, NDArray[np.float32]]:
        """`distance` and `sigma` as images have them [mm]."""
        grids = {"distance": self.distance, "sigma": self.sigma}
        return {name: (1e3 * grid).astype(np.float32) for name, grid in grids.items()}

    @property
    def volume(self) -> float:
        """Volume above the base plane [m3]."""
        return sdf.volume_above_base(self.distance, self.origin, self.spacing)

    @property
    def boundary_sigma(self) -> float:
        """Mean of `sigma` over the surface above the base [m]."""
        base = round(float(-self.origin[2] / self.spacing))
        near = np.abs(self.distance[:, :, base:]) < 0.5 * self.spacing
        return float(self.sigma[:, :, base:][near].mean())

    @property
    def highest_point(self) -> Array:
        """Highest point of the surface in the sample frame, (3,) [m]."""
        return highest_point(self.distance, self.origin, self.spacing)

    @property
    def distance_affine_mm(self) -> Array:
        """Map (4, 4) from an index of `distance` to world [mm]."""
        affine = self.sample_to_world @ frame.grid_affine(self.origin, self.spacing)
        affine[:3] *= 1e3
        return affine

    def summary(self) -> dict[str, Any]:
        """Flat record in mm and degrees for ``segmentation/{sample}.json``."""
        to_world = self.sample_to_world.copy()
        to_world[:3, 3] *= 1e3
        names = ("snr", "noise", "tissue_level", "threshold")
        values = {name: getattr(self, name) for name in names}
        known = {k: v if np.isfinite(v) else None for k, v in values.items()}
        return {
            "sample_to_world": to_world.tolist(),
            "grid_origin_mm": (self.origin / MM).tolist(),
            "grid_spacing_mm": self.spacing / MM,
            "volume_mm3": self.volume / MM**3,
            "highest_point_mm": float(self.highest_point[2] / MM),
            "highest_point_position_mm": (self.highest_point / MM).tolist(),
            "boundary_sigma_mm": self.boundary_sigma / MM,
            "film_mm": self.film / MM,
            "point_spread": self.point_spread,
            "tilt_deg": float(np.degrees(self.tilt)),
            "base_flatness_mm": self.base_spread / MM,
            **known,
            "flags": [*self.flags, *(doubt.partition("; ")[0] for doubt in self.doubts)],
        }


def segment(
    data: ArrayLike,
    affine: ArrayLike,
    settings: SegmentationSettings | None = None,
    *,
    loading_axis: ArrayLike = (0.0, 0.0, 1.0),
    shear_axis: ArrayLike = (1.0, 0.0, 0.0),
    find_film: bool = True,
) -> Segmentation:
    """Segment a sample that stands on a dark platen, surrounded by air.

    Parameters
    ----------
    data : (nx, ny, nz) array
        Intensities, tissue bright (T2-weighted), free fluid brighter.
    affine : (4, 4) array
        From voxel index to world RAS+ [mm].
    loading_axis, shear_axis : (3,) array
        World directions, nominally: from the glued base upward, and of the shear.
    find_film : bool
        Whether a film of fluid is looked for, which takes most of the time.

    Returns
    -------
    Segmentation

    Raises
    ------
    InputError
        If the image or its affine cannot be one of a sample (shape, NaN, constant, voxel size).
    SegmentationError
        If no sample, or no whole sample, is found.
    """
    settings = settings or SegmentationSettings()
    image, to_world = checked_image(data, affine)
    up, shear = checked_axes(loading_axis, shear_axis)
    spacing = voxel_size(to_world)
    share = tissue_share(image, spacing, settings)
    region.check_component(share.mask, spacing, settings)
    region.refuse_surrounded(share.mask & ~share.hole, to_world, up)
    cavity = cavities(share, to_world, up)
    share = replace(share, mask=share.mask | cavity, hole=share.hole | cavity)
    if not find_film:
        share = replace(share, power=None, relative_noise=None)
    return _from_share(share, to_world, settings, up, shear, on_platen=True)


def segmentation_from_mask(
    mask: ArrayLike,
    affine: ArrayLike,
    settings: SegmentationSettings | None = None,
    *,
    loading_axis: ArrayLike = (0.0, 0.0, 1.0),
    shear_axis: ArrayLike = (1.0, 0.0, 0.0),
) -> Segmentation:
    """Take over a segmentation made elsewhere; the sample is where `mask` is not zero.

    Parameters, results and errors as in `segment`. The boundary lies half-way between voxels
    inside and outside, smoothed by half a voxel at least; its one-sigma is that of a voxel edge.
    """
    settings = settings or SegmentationSettings()
    image, to_world = checked_image(mask, affine)
    up, shear = checked_axes(loading_axis, shear_axis)
    spacing = voxel_size(to_world)
    left_out = region.left_out(image != 0.0, spacing)
    solid = intensity.largest_component(image != 0.0)
    region.check_component(solid, spacing, settings)
    share = TissueShare(
        share=intensity.smooth(solid.astype(np.float64), blur_of(spacing), spacing),
        mask=solid,
        fluid=np.zeros_like(solid),
        hole=np.zeros_like(solid),
        left_out=left_out,
    )
    # a segmentation made elsewhere has its say
    return _from_share(share, to_world, settings, up, shear, on_platen=False)


def _from_share(
    share: TissueShare,
    to_world: Array,
    settings: SegmentationSettings,
    up: Array,
    shear: Array,
    on_platen: bool,
) -> Segmentation:
    """Find the sample frame and bring the boundary into it."""
    kept = np.where(intensity.grown(share.mask), share.share, np.minimum(share.share, 0.0))
    kept = np.where(share.hole, 1.0, kept)
    surface = frame.iso_surface(kept, HALF, to_world)
    try:
        point, normal, spread = platen.base(surface, up, voxel_size(to_world), settings, on_platen)
    except SegmentationError as error:
        other = platen.other_end(surface, up, voxel_size(to_world), settings) if on_platen else None
        if other is None:
            raise
        raise SegmentationError(f"{str(error).partition('; ')[0]}; {other}") from error
    x = frame.wall_direction(surface, normal, shear)
    sample_to_world = frame.rigid(x, normal, point)
    found = boundary(kept, share, surface, to_world, sample_to_world, settings)
    distance, origin = found.distance, found.origin
    spacing = settings.grid_spacing_mm * MM
    shift = sdf.base_centroid(distance, origin, spacing)
    sample_to_world = frame.rigid(x, normal, point + sample_to_world[:3, :3] @ shift)
    origin = origin - shift
    tilt = float(np.arccos(np.clip(normal @ up, -1.0, 1.0)))
    voxel = voxel_size(to_world)
    to_sample = np.linalg.inv(sample_to_world) @ to_world
    beside = doubts.bright_beside(share.share, share.mask, voxel, 1.5 * margin_of(voxel), to_sample)
    return Segmentation(
        mask=on_image(distance, origin, spacing, to_sample, share.mask.shape),
        distance=distance,
        origin=origin,
        spacing=spacing,
        sample_to_world=sample_to_world,
        sigma=found.sigma,
        film=found.film,
        point_spread=found.point_spread,
        tilt=tilt,
        base_spread=spread,
        snr=share.snr,
        noise=share.noise,
        tissue_level=share.level,
        threshold=share.threshold,
        flags=(*_flags(share, spread, voxel), *frame.told_turn(x, shear)),
        doubts=(
            *beside,
            *doubts.odd_sections(distance, origin, spacing),
            *(doubts.unlike_a_scan(share.noise, share.shared_noise, found) if on_platen else ()),
        ),
    )


def _flags(share: TissueShare, spread: float, voxel: Array) -> tuple[str, ...]:
    """What a person should look at."""
    found = {
        "free fluid on the sample was left out": share.fluid.any(),
        "a hole in the sample was filled": share.hole.any(),
        f"another region of {share.left_out / MM**3:.0f} mm3 was left out": share.left_out,
        "base is not flat": spread > 0.5 * float(np.max(voxel)),
        "low signal to noise ratio": share.snr < 8.0,
    }
    return tuple(flag for flag, holds in found.items() if holds)
