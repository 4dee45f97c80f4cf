"""Share of tissue in the voxels of an image, its free fluid and its bubbles."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from softsample.arrays import Array, Mask
from softsample.errors import SegmentationError
from softsample.imaging import intensity, region
from softsample.imaging.settings import SegmentationSettings
from softsample.units import MM

HALF = 0.5
"""Share of tissue at the boundary: the local half-maximum."""

LEAST_NOISE = 1e-3
"""Noise relative to the tissue at least: programs that mask the background leave none there, and
what there is in the sample is not known then."""

MOST_SHARED = 0.15
"""Part of the noise's variance that neighbours share up to which a voxel is a measurement of its
own. It is 0.05 at most in 60 simulated scans, and 0.26 or more in images that were zero-filled,
interpolated to half the voxel, filtered (Hamming) or smoothed by half a voxel."""

MIN_TEXTURE = 0.02
"""Smallest standard deviation of the tissue about its level nearby, relative."""

DROP_EDGE = 0.4
"""Edge of the voxels in which free fluid is told from a film [mm]."""

DROP_MM3 = 0.09
"""Smallest drop [mm3]; in large voxels, three of them."""

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

MIN_CONTRAST = 4.0
"""Signal of the tissue over the noise that a sample needs to be told from its surroundings."""


@dataclass(frozen=True)
class TissueShare:
    """Share of tissue in each voxel and what it rests on.

    Attributes
    ----------
    share : (nx, ny, nz) float64
        Smoothed image on the scale from surroundings (0) to the tissue nearby (1).
    mask, fluid, hole : (nx, ny, nz) bool
        Sample, free fluid (drops), and holes of the sample that were filled (bubbles).
    left_out : float
        Volume [m3] of another region that is large enough for a person to look at, or zero.
    power, relative_noise : (nx, ny, nz) float64, or None
        Square of the intensity over that of the tissue nearby, less the surroundings'; noise over
        that of the tissue nearby. None for a given mask, if no film is looked for, or if the
        voxels have no noise of their own.
    texture : float
        Standard deviation of the tissue about its level nearby, relative.
    snr, noise, level, threshold : float
        As in `Segmentation`.
    shared_noise : float
        Part of the noise's variance that neighbouring voxels share.
    """

    share: Array
    mask: Mask
    fluid: Mask
    hole: Mask
    left_out: float
    power: Array | None = None
    relative_noise: Array | None = None
    texture: float = 0.0
    snr: float = np.nan
    noise: float = np.nan
    level: float = np.nan
    threshold: float = np.nan
    shared_noise: float = 0.0


def tissue_share(image: Array, spacing: Array, settings: SegmentationSettings) -> TissueShare:
    """Share of tissue in every voxel, by the level of the tissue nearby.

    The boundary is where the smoothed image is half-way between the surroundings and the robust
    local level of the tissue itself. A bright film or drop at the wall thus does not raise it.
    """
    blur = blur_of(spacing)
    bright = intensity.bright_mask(image, spacing, blur)
    region.refuse_bright_rim(bright)
    left_out = region.left_out(bright, spacing)
    rough = intensity.largest_component(bright)
    bright |= rough
    margin = margin_of(spacing)
    interior = _interior(image, rough, spacing, margin, settings)
    around = intensity.surroundings(image, bright, spacing, 2.0 * margin)
    level = float(np.median(image[interior]))
    if np.median(around) < -LEAST_NOISE * level:
        raise SegmentationError(
            f"the surroundings of the sample are negative ({np.median(around):.4g}); give"
            " magnitudes as scanned, which are zero where there is no signal"
        )
    measured = intensity.noise_level(image, bright, spacing, 2.0 * margin)
    told = measured > LEAST_NOISE * level
    shared = intensity.shared_noise(image, bright, spacing, 2.0 * margin)
    own = told and shared < MOST_SHARED
    noise = max(measured, LEAST_NOISE * level)
    square = image**2 - np.mean(around**2)
    image = intensity.without_noise_floor(image, noise)
    background = float(np.mean(intensity.surroundings(image, bright, spacing, 2.0 * margin)))
    level = float(np.median(image[interior]))
    if level - background < MIN_CONTRAST * noise:
        raise SegmentationError(
            f"no sample found: its brightest region ({level:.4g}) does not stand out from the"
            f" surroundings ({np.median(around):.4g}) and their spread ({noise:.3g}); give an image"
            " of the sample in air"
        )
    bias = intensity.bias_field(image, interior, BIAS_ORDER)
    even = (image - background) / bias
    local = intensity.tissue_level(even, interior, spacing, LEVEL_REACH_MM * MM)
    raw = even / local
    grain = noise / (bias * local)
    low, high = np.percentile(raw[interior], [15.87, 84.13])
    texture = 0.25 * (high - low) ** 2 - np.median(grain[interior]) ** 2
    share = intensity.smooth(raw, blur, spacing)
    mask = intensity.largest_component(share > HALF)
    return TissueShare(
        share=share,
        mask=mask,
        fluid=_free_fluid(raw, spacing),
        hole=mask & (share <= HALF),
        power=square / (bias * local) ** 2 if own else None,
        texture=float(np.sqrt(max(texture, MIN_TEXTURE**2))),
        relative_noise=grain if own else None,
        snr=level / noise if told else np.nan,
        noise=noise if told else np.nan,
        level=level,
        threshold=background + HALF * (level - background),
        shared_noise=shared,
        left_out=left_out,
    )


def margin_of(spacing: Array) -> float:
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


def cavities(share: TissueShare, to_world: Array, up: Array) -> Mask:
    """What a sample encloses in its sections and covers: bubbles that are open to the platen.

    They are dark somewhere; where a slice lies half in the base, noise makes holes that are not.
    """
    cavity = np.zeros_like(share.mask)
    holes = region.from_above(cavity, to_world, up)
    above = np.zeros_like(holes[0])
    for hole, section in zip(holes, region.from_above(share.mask, to_world, up), strict=True):
        above |= section
        hole[:] = ndimage.binary_fill_holes(section) & above & ~section
    labels, _ = ndimage.label(cavity)
    dark = np.unique(labels[cavity & (share.share < 0.5 * HALF)])
    return np.isin(labels, dark) & cavity


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


def blur_of(spacing: Array) -> Array:
    """Standard deviation of the smoothing along each axis, (3,) [m].

    Less than 0.6 voxel edges and the surface would follow the voxels' steps.
    """
    return np.maximum(SMOOTHING_MM * MM, 0.6 * spacing)
