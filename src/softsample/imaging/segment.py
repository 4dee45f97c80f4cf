"""Segmentation of a tissue sample on a platen: image to signed distance in the sample frame.

The steps and the definitions are in ``docs/geometry.md``.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from softsample.arrays import Array, Mask
from softsample.errors import InputError, SegmentationError
from softsample.imaging import distance as sdf
from softsample.imaging import doubts, film, frame, intensity, relief
from softsample.units import MM

HALF = 0.5
"""Share of tissue at the boundary: the local half-maximum."""

LEAST_NOISE = 1e-3
"""Noise relative to the tissue at least: programs that mask the background leave none there."""

MIN_TEXTURE = 0.02
"""Smallest standard deviation of the tissue about its level nearby, relative."""

DROP_EDGE = 0.4
"""Edge of the voxels in which free fluid is told from a film [mm]."""

DROP_MM3 = 0.09
"""Smallest drop [mm3]; in large voxels, three of them."""

BASE_REACH = (0.15, 0.25)
"""What lies this near to the base plane is base [mm, voxel edges; the larger of the two]."""

BIAS_ORDER = 2
"""Total degree of the polynomial of the bias field: coils vary over the sample as a whole, and more
would follow its texture."""

SMOOTHING_MM = 0.25
"""Standard deviation of the Gaussian smoothing [mm], against noise; in large voxels, 0.6 of their
edges."""

LEVEL_REACH_MM = 1.0
"""Standard deviation of the mean that gives the local level of the tissue [mm]: over its grain."""

LEVEL_MARGIN_MM = 0.5
"""Tissue nearer to the boundary than this does not count for the level [mm]: it is partly fluid or
air. In large voxels, one edge."""

FLUID_RATIO = 1.5
"""Voxels this many times brighter than the tissue nearby are free fluid: between it and
saline."""

FLUID_REACH_MM = 1.0
"""Around free fluid the boundary is replaced by its smooth continuation up to here [mm]: as far as
voxels and smoothing spread its light."""

CONTINUATION_MM = 1.5
"""Height of wall that gives the slope of its continuation to the base [mm]: several voxels, so that
noise does not tilt it."""

PADDING_MM = 2.5
"""Rim around the sample in the grid of the distance [mm]: room for the walls below the base."""

LEFT_OUT = 0.05
"""A region that is larger than this beside the sample may be a part of it, in its volumes."""

MOST_ENCLOSED = 0.2
"""Part of the sections of a sample that it may enclose: a bubble of half its width does 0.1, tubes
and baths 0.3 to 0.5."""

MIN_CONTRAST = 4.0
"""Signal of the tissue over the noise that a sample needs to be told from its surroundings."""


@dataclass(frozen=True)
class SegmentationSettings:
    """Settings of `segment`; the names and defaults of the config section `segmentation`.

    Attributes
    ----------
    fluid_brightness : float
        Expected brightness of saline over that of tissue.
    base_clearance_mm : float
        Walls lower than this above the platen (meniscus) are continued from above [mm].
    max_tilt_deg : float
        Largest tilt of the base that is taken out [degrees].
    grid_spacing_mm : float
        Spacing of the signed distance [mm].
    min_base_share : float
        Share of the underside that must lie on one plane for there to be a platen.
    min_volume_mm3 : float
        Anything smaller is not a sample [mm3].
    """

    fluid_brightness: float = 2.2
    base_clearance_mm: float = 0.75
    max_tilt_deg: float = 10.0
    grid_spacing_mm: float = 0.25
    min_base_share: float = 0.75
    min_volume_mm3: float = 100.0


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
    film : float
        Mean thickness of the film of fluid that was taken off [m].
    tilt : float
        Angle between the base normal and the nominal loading axis [rad].
    base_spread : float
        Robust standard deviation of the base about its plane [m].
    snr, noise, tissue_level, threshold : float
        Signal to noise ratio, standard deviation of the noise, median level of the tissue and
        median threshold at the boundary, intensities as in the image. NaN for a given mask.
    flags : tuple of str
        Peculiarities a person should look at.
    doubts : tuple of str
        Why this may be something else than the sample, with cures.
    """

    mask: Mask
    distance: Array
    origin: Array
    spacing: float
    sample_to_world: Array
    sigma: Array
    film: float
    tilt: float
    base_spread: float
    snr: float
    noise: float
    tissue_level: float
    threshold: float
    flags: tuple[str, ...]
    doubts: tuple[str, ...]

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
        return sdf.highest_point(self.distance, self.origin, self.spacing)

    @property
    def distance_affine_mm(self) -> Array:
        """Map (4, 4) from an index of `distance` to world [mm]."""
        affine = self.sample_to_world @ frame.grid_affine(self.origin, self.spacing)
        return frame.index_to_mm(affine)

    def summary(self) -> dict[str, Any]:
        """Flat record in mm and degrees for ``segmentation/{sample}.json``."""
        intensities = {
            "snr": self.snr,
            "noise": self.noise,
            "tissue_level": self.tissue_level,
            "threshold": self.threshold,
        }
        known = {k: v if np.isfinite(v) else None for k, v in intensities.items()}
        return {
            "sample_to_world": frame.rigid_to_mm(self.sample_to_world).tolist(),
            "grid_origin_mm": (self.origin / MM).tolist(),
            "grid_spacing_mm": self.spacing / MM,
            "volume_mm3": self.volume / MM**3,
            "highest_point_mm": float(self.highest_point[2] / MM),
            "highest_point_position_mm": (self.highest_point / MM).tolist(),
            "boundary_sigma_mm": self.boundary_sigma / MM,
            "film_mm": self.film / MM,
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
    settings : SegmentationSettings, optional
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
    check_component(share.mask, spacing, settings)
    _refuse_surrounded(share.mask & ~share.hole, to_world, up)
    cavity = _cavities(share, to_world, up)
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
    left_out = _left_out(image != 0.0, spacing)
    solid = intensity.largest_component(image != 0.0)
    check_component(solid, spacing, settings)
    share = TissueShare(
        share=intensity.smooth(solid.astype(np.float64), _blur(spacing), spacing),
        mask=solid,
        fluid=np.zeros_like(solid),
        hole=np.zeros_like(solid),
        power=None,
        relative_noise=None,
        texture=0.0,
        snr=np.nan,
        noise=np.nan,
        level=np.nan,
        threshold=np.nan,
        left_out=left_out,
    )
    # a segmentation made elsewhere has its say
    return _from_share(share, to_world, settings, up, shear, on_platen=False)


@dataclass(frozen=True)
class TissueShare:
    """Share of tissue in each voxel and what it rests on.

    Attributes
    ----------
    share : (nx, ny, nz) float64
        Smoothed image on the scale from surroundings (0) to the tissue nearby (1).
    mask, fluid, hole : (nx, ny, nz) bool
        Sample, free fluid (drops), and holes of the sample that were filled (bubbles).
    power, relative_noise : (nx, ny, nz) float64, or None
        Square of the intensity over that of the tissue nearby, less the surroundings'; noise over
        that of the tissue nearby. None for a given mask, or if no film is looked for.
    texture : float
        Standard deviation of the tissue about its level nearby, relative.
    snr, noise, level, threshold : float
        As in `Segmentation`.
    left_out : float
        Volume [m3] of another region that is large enough for a person to look at, or zero.
    """

    share: Array
    mask: Mask
    fluid: Mask
    hole: Mask
    power: Array | None
    relative_noise: Array | None
    texture: float
    snr: float
    noise: float
    level: float
    threshold: float
    left_out: float


def tissue_share(image: Array, spacing: Array, settings: SegmentationSettings) -> TissueShare:
    """Share of tissue in every voxel, by the level of the tissue nearby.

    The boundary is where the smoothed image is half-way between the surroundings and the robust
    local level of the tissue itself. A bright film or drop at the wall thus does not raise it.
    """
    blur = _blur(spacing)
    bright = intensity.bright_mask(image, spacing, blur)
    left_out = _left_out(bright, spacing)
    rough = intensity.largest_component(bright)
    bright |= rough
    margin = _margin(spacing)
    interior = _interior(image, rough, spacing, margin, settings)
    around = intensity.surroundings(image, bright, spacing, 2.0 * margin)
    level = float(np.median(image[interior]))
    if np.median(around) < -LEAST_NOISE * level:
        raise SegmentationError(
            f"the surroundings of the sample are negative ({np.median(around):.4g}); give"
            " magnitudes as scanned, which are zero where there is no signal"
        )
    noise = intensity.noise_level(image, bright, spacing, 2.0 * margin)
    noise = max(noise, LEAST_NOISE * level)
    square = image**2 - np.mean(around**2)
    image = intensity.without_noise_floor(image, noise)
    floor = float(np.mean(intensity.surroundings(image, bright, spacing, 2.0 * margin)))
    level = float(np.median(image[interior]))
    if level - floor < MIN_CONTRAST * noise:
        raise SegmentationError(
            f"no sample found: its brightest region ({level:.4g}) does not stand out from the"
            f" surroundings ({floor:.4g}) and noise ({noise:.3g}); check the image"
        )
    bias = intensity.bias_field(image, interior, BIAS_ORDER)
    even = (image - floor) / bias
    local = intensity.tissue_level(even, interior, spacing, LEVEL_REACH_MM * MM)
    raw = even / local
    grain = noise / (bias * local)
    low, high = np.percentile(raw[interior], [15.87, 84.13])
    texture = 0.25 * (high - low) ** 2 - np.median(grain[interior]) ** 2
    share = intensity.smooth(raw, blur, spacing)
    mask = intensity.largest_component(share > HALF)
    snr = level / max(noise, 1e-12 * level)
    return TissueShare(
        share=share,
        mask=mask,
        fluid=_free_fluid(raw, spacing),
        hole=mask & (share <= HALF),
        power=square / (bias * local) ** 2,
        texture=float(np.sqrt(max(texture, MIN_TEXTURE**2))),
        relative_noise=grain,
        snr=snr,
        noise=noise,
        level=level,
        threshold=floor + HALF * (level - floor),
        left_out=left_out,
    )


def _margin(spacing: Array) -> float:
    """Distance from the boundary within which voxels may be partly tissue [m]."""
    return max(LEVEL_MARGIN_MM * MM, float(np.max(spacing))) + 0.25 * MM


def _interior(
    image: Array, rough: Mask, spacing: Array, margin: float, settings: SegmentationSettings
) -> Mask:
    """Voxels at least `margin` [m] inside the largest bright region; refuses one too small."""
    if np.count_nonzero(rough) * np.prod(spacing) < settings.min_volume_mm3 * MM**3:
        raise SegmentationError(
            f"no sample found: the largest bright region is smaller than"
            f" {settings.min_volume_mm3:g} mm3; check the image and its scale"
        )
    interior = intensity.eroded(rough, spacing, margin)
    interior &= image > HALF * np.median(image[rough])  # no bubbles
    if np.count_nonzero(interior) < 100:
        raise SegmentationError(
            "no sample found: the largest bright region has no interior; check the image and"
            " its scale"
        )
    return interior


def _left_out(regions: Mask, spacing: Array) -> float:
    """Volume [m3] of what is largest beside the sample; zero if it is small beside it.

    Refuses what is more than half as large as the sample.
    """
    labels, _ = ndimage.label(regions)
    sizes = np.bincount(labels.ravel())[1:] * float(np.prod(spacing))
    first, second = np.sort(np.append(sizes, [0.0, 0.0]))[[-1, -2]]
    if second > 0.5 * first:
        raise SegmentationError(
            f"two samples found, of {first / MM**3:.0f} and {second / MM**3:.0f} mm3; crop the "
            "image to one, or keep one region of a mask"
        )
    return float(second) if second > LEFT_OUT * first else 0.0


def _refuse_surrounded(solid: Mask, to_world: Array, up: Array) -> None:
    """Refuse a sample whose sections are rings: a container, or a bath about the sample."""
    sections = _from_above(solid, to_world, up)
    filled = sum(np.count_nonzero(ndimage.binary_fill_holes(section)) for section in sections)
    enclosed = 1.0 - np.count_nonzero(solid) / filled
    if enclosed > MOST_ENCLOSED:
        raise SegmentationError(
            f"the brightest region encloses {100.0 * enclosed:.0f} % of its sections: it looks "
            "like a container, or fluid about a sample; give an image of the sample in air, or "
            "a mask in column segmentation"
        )


def _cavities(share: TissueShare, to_world: Array, up: Array) -> Mask:
    """What a sample encloses in its sections and covers: bubbles that are open to the platen.

    They are dark somewhere; where a slice lies half in the base, noise makes holes that are not.
    """
    cavity = np.zeros_like(share.mask)
    holes = _from_above(cavity, to_world, up)
    above = np.zeros_like(holes[0])
    for hole, section in zip(holes, _from_above(share.mask, to_world, up), strict=True):
        above |= section
        hole[:] = ndimage.binary_fill_holes(section) & above & ~section
    labels, _ = ndimage.label(cavity)
    dark = np.unique(labels[cavity & (share.share < 0.5 * HALF)])
    return np.isin(labels, dark) & cavity


def _from_above(mask: Mask, to_world: Array, up: Array) -> Mask:
    """Sections across the image's axis that is nearest to the loading axis, the highest first."""
    along = up @ (to_world[:3, :3] / voxel_size(to_world))
    axis = int(np.abs(along).argmax())
    sections = np.moveaxis(mask, axis, 0)
    return sections[::-1] if along[axis] > 0.0 else sections


def _free_fluid(raw: Array, spacing: Array) -> Mask:
    """Groups of voxels much brighter than the tissue nearby.

    Smaller voxels are smoothed to the size of `DROP_EDGE`, or a film would fill them.
    """
    blur = np.sqrt(np.maximum((DROP_EDGE * MM) ** 2 - spacing**2, 0.0) / 12.0)
    bright = intensity.smooth(raw, blur, spacing) > FLUID_RATIO
    labels, _ = ndimage.label(bright, np.ones((3, 3, 3)))
    sizes = np.bincount(labels.ravel())
    fewest = max(3.0, DROP_MM3 * MM**3 / float(np.prod(spacing)))
    return np.asarray((sizes[labels] >= fewest) & (labels > 0), dtype=bool)


def _blur(spacing: Array) -> Array:
    """Standard deviation of the smoothing along each axis, (3,) [m].

    Less than 0.6 voxel edges and the surface would follow the voxels' steps.
    """
    return np.maximum(SMOOTHING_MM * MM, 0.6 * spacing)


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
        point, normal, spread = _base(surface, up, voxel_size(to_world), settings, on_platen)
    except SegmentationError as error:
        other = _other_end(surface, up, voxel_size(to_world), settings) if on_platen else None
        if other is None:
            raise
        raise SegmentationError(f"{str(error).partition('; ')[0]}; {other}") from error
    x = frame.wall_direction(surface, normal, shear)
    sample_to_world = frame.rigid(x, normal, point)
    found = _boundary(kept, share, surface, to_world, sample_to_world, settings)
    distance, origin = found.distance, found.origin
    spacing = settings.grid_spacing_mm * MM
    shift = sdf.base_centroid(distance, origin, spacing)
    sample_to_world = frame.rigid(x, normal, point + sample_to_world[:3, :3] @ shift)
    origin = origin - shift
    tilt = float(np.arccos(np.clip(normal @ up, -1.0, 1.0)))
    voxel = voxel_size(to_world)
    to_sample = np.linalg.inv(sample_to_world) @ to_world
    beside = doubts.bright_beside(share.share, share.mask, voxel, 1.5 * _margin(voxel), to_sample)
    return Segmentation(
        mask=_on_image(distance, origin, spacing, sample_to_world, to_world, share.mask.shape),
        distance=distance,
        origin=origin,
        spacing=spacing,
        sample_to_world=sample_to_world,
        sigma=found.sigma,
        film=found.film,
        tilt=tilt,
        base_spread=spread,
        snr=share.snr,
        noise=share.noise,
        tissue_level=share.level,
        threshold=share.threshold,
        flags=(*_flags(share, spread, voxel), *frame.told_turn(x, shear)),
        doubts=(*beside, *doubts.odd_sections(distance, origin, spacing)),
    )


def _base(
    surface: frame.Surface,
    up: Array,
    spacing: Array,
    settings: SegmentationSettings,
    on_platen: bool,
) -> tuple[Array, Array, float]:
    """Base plane, as of `frame.fit_base`; refuses an underside that no platen has made flat."""
    point, normal, spread = frame.fit_base(surface, up, np.radians(settings.max_tilt_deg))
    if not on_platen:
        return point, normal, spread
    reach = max(BASE_REACH[0] * MM, BASE_REACH[1] * float(np.max(spacing)))
    flat = frame.base_share(surface, point, normal, reach)
    if flat < settings.min_base_share:
        raise SegmentationError(
            f"no platen found below the sample: {100.0 * flat:.0f} % of its underside lie within"
            f" {reach / MM:.2g} mm of one plane, at least {100.0 * settings.min_base_share:.0f} %"
            " are expected; give an image of the sample bonded to its platen, and a loading_axis"
            " that points from there upward, or lower segmentation.min_base_share"
        )
    return point, normal, spread


def _other_end(
    surface: frame.Surface, up: Array, spacing: Array, settings: SegmentationSettings
) -> str | None:
    """What to do about a sample without a base whose other end could be one, or None."""
    try:
        _base(surface, -up, spacing, settings, on_platen=True)
    except SegmentationError:
        return None
    axis = int(np.abs(up).argmax())
    opposite = f"{'-' if up[axis] > 0.0 else '+'}{'xyz'[axis]}"
    return (
        f"its other end is flat: if the image is upside down, write {opposite} into column"
        " loading_axis; if something below the sample is as bright, such as a holder, give a mask"
        " without it in column segmentation"
    )


@dataclass(frozen=True)
class Boundary:
    """Signed distance, its first grid point, its standard deviation and the mean film [m]."""

    distance: Array
    origin: Array
    sigma: Array
    film: float


def _boundary(
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
    walls = frame.iso_surface(local[:, :, first - 1 :], HALF, _raised(grid, first - 1))
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
    if share.power is not None:  # else nothing is known of the surface's error
        whole = relief.without_error(whole, found.sigma, origin, spacing)
    whole = sdf.continue_below(whole, first, layers, blur=2.0)
    boundary = frame.iso_surface(-whole, 0.0, grid)
    distance = sdf.signed_distance(whole < 0.0, boundary, origin, spacing)
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
    if share.power is None or share.relative_noise is None:
        voxel = float(np.max(voxel_size(to_sample)))
        return Boundary(rough, origin, np.full(rough.shape, voxel / np.sqrt(12.0)), 0.0)
    height = origin[2] + spacing * np.arange(rough.shape[2])
    usable = seen & (height > settings.base_clearance_mm * MM)
    voxels = film.voxels_near(
        share.power, share.relative_noise, share.texture, usable, rough, origin, spacing, to_sample
    )
    fit = film.fit(voxels, settings.fluid_brightness)
    near = np.abs(rough) < 1.0 * MM
    points = origin + spacing * np.argwhere(near)
    distance, sigma = rough.copy(), np.full(rough.shape, float(np.median(fit.sigma)))
    shift, sigma[near] = fit.at(points)
    distance[near] -= shift
    return Boundary(distance, origin, sigma, fit.film)


def _away(marked: Mask, spacing: float) -> Array:
    """Distance to the nearest marked grid point [m]; infinite if there is none."""
    if not marked.any():
        return np.full(marked.shape, np.inf)
    return np.asarray(ndimage.distance_transform_edt(~marked, sampling=spacing))


def _raised(grid: Array, layers: int) -> Array:
    """Affine of the part of a grid that begins `layers` higher."""
    raised = grid.copy()
    raised[:3, 3] += layers * grid[:3, 2]
    return raised


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


def _on_image(
    distance: Array,
    origin: Array,
    spacing: float,
    sample_to_world: Array,
    to_world: Array,
    shape: tuple[int, ...],
) -> Mask:
    """Sample on the grid of the image: inside the surface and above the base plane."""
    to_sample = np.linalg.inv(sample_to_world) @ to_world
    to_index = np.linalg.inv(frame.grid_affine(origin, spacing)) @ to_sample
    inside = frame.sampled(distance, to_index, shape, order=1, outside=1.0) < 0.0
    i, j, k = np.ogrid[: shape[0], : shape[1], : shape[2]]
    row = to_sample[2]
    return np.asarray(inside & (row[0] * i + row[1] * j + row[2] * k + row[3] >= 0.0), dtype=bool)


def _flags(share: TissueShare, spread: float, voxel: Array) -> tuple[str, ...]:
    """What a person should look at."""
    flags = []
    if share.fluid.any():
        flags.append("free fluid on the sample was left out")
    if share.hole.any():
        flags.append("a hole in the sample was filled")
    if share.left_out:
        flags.append(f"another region of {share.left_out / MM**3:.0f} mm3 was left out")
    if spread > 0.5 * float(np.max(voxel)):
        flags.append("base is not flat")
    if share.snr < 8.0:
        flags.append("low signal to noise ratio")
    return tuple(flags)


def voxel_size(affine: Array) -> Array:
    """Edges of a voxel, (3,), in the unit of the affine."""
    return np.asarray(np.linalg.norm(affine[:3, :3], axis=0))


def checked_image(data: ArrayLike, affine: ArrayLike) -> tuple[Array, Array]:
    """Image as float64 and its affine in metres, or an `InputError` with the cure."""
    image, to_world = np.asarray(data, dtype=np.float64), np.array(affine, dtype=np.float64)
    if image.ndim != 3 or min(image.shape) < 8:
        raise InputError(
            f"image has shape {image.shape}; give one volume of at least 8 voxels along each axis"
        )
    if to_world.shape != (4, 4) or not np.all(np.isfinite(to_world)):
        raise InputError("the affine of the image must be a finite 4 x 4 matrix; export it again")
    size = voxel_size(to_world)
    if np.any(size < 0.05) or np.any(size > 2.0):
        raise InputError(
            f"voxel size {size.round(4).tolist()} mm is outside 0.05 to 2 mm; check that the"
            " header is in mm"
        )
    if abs(np.linalg.det(to_world[:3, :3])) < 0.5 * np.prod(size):
        raise InputError("the image axes are far from perpendicular; resample the image")
    bad = int(np.count_nonzero(~np.isfinite(image)))
    if bad:
        raise InputError(f"image has {bad} NaN or infinite voxels of {image.size}; export it again")
    if np.ptp(image) == 0.0:
        raise InputError(f"image is {image.flat[0]:g} everywhere; export it again")
    to_world[:3] *= MM
    return image, to_world


def checked_axes(loading: ArrayLike, shear: ArrayLike) -> tuple[Array, Array]:
    """Unit loading axis and unit shear axis, the latter made perpendicular to the former."""
    up, x = np.array(loading, dtype=np.float64), np.array(shear, dtype=np.float64)
    if up.shape != (3,) or x.shape != (3,) or not (np.any(up) and np.any(x)):
        raise InputError(f"loading_axis {up} and shear_axis {x} must be directions")
    up /= np.linalg.norm(up)
    x = x - (x @ up) * up
    if np.linalg.norm(x) < 1e-6:
        raise InputError("loading_axis and shear_axis are parallel; give two different axes")
    return up, x / np.linalg.norm(x)


def check_component(mask: Mask, spacing: Array, settings: SegmentationSettings) -> None:
    """Refuse a sample that is too small or cut by the edge of the image."""
    volume = np.count_nonzero(mask) * np.prod(spacing) / MM**3
    if volume < settings.min_volume_mm3:
        raise SegmentationError(
            f"no sample found: the largest region has {volume:.3g} mm3, at least"
            f" {settings.min_volume_mm3:g} mm3 are expected; check the image and its scale"
        )
    for axis, name in enumerate("ijk"):
        for side, index in (("first", 0), ("last", -1)):
            if np.take(mask, index, axis=axis).any():
                raise SegmentationError(
                    f"sample touches the edge of the field of view ({side} slice along {name});"
                    " give an image of the whole sample"
                )
