"""Intensity of a sample image: noise, bias field, local level of the tissue."""

import numpy as np
from scipy import ndimage
from skimage.filters import threshold_otsu

from softsample.arrays import Array, Mask
from softsample.errors import SegmentationError

RAYLEIGH_SD = np.sqrt(2.0 - np.pi / 2.0)
"""Standard deviation of a Rayleigh variable of unit scale: noise in the magnitude of nothing."""

RICIAN = 1.6954
"""``E[sign(x) sqrt(abs(x))] = 0`` with ``x = r**2 - RICIAN`` for a Rayleigh variable r."""

APART = 4
"""Voxels so far apart share what the surroundings show, but no noise."""

EDGE = 3.0
"""Differences of more than so many standard deviations are of an edge, not of noise."""


def smooth(data: Array, sigma: float | Array, spacing: Array) -> Array:
    """Gaussian smoothing with a standard deviation `sigma` [m] on voxels of `spacing` [m]."""
    return ndimage.gaussian_filter(data, sigma / spacing, mode="nearest")


def largest_component(mask: Mask) -> Mask:
    """Largest face-connected component of a mask, holes filled; empty if the mask is empty."""
    labels, count = ndimage.label(mask)
    if count == 0:
        return np.zeros_like(mask)
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    return np.asarray(ndimage.binary_fill_holes(labels == np.argmax(sizes)), dtype=bool)


def bright_mask(data: Array, spacing: Array, smoothing: float | Array) -> Mask:
    """First guess of the tissue: the smoothed image above Otsu's threshold."""
    smoothed = smooth(data, smoothing, spacing)
    return np.asarray(smoothed > threshold_otsu(smoothed), dtype=bool)


def eroded(mask: Mask, spacing: Array, depth: float) -> Mask:
    """Voxels deeper than `depth` [m] inside a mask."""
    return np.asarray(ndimage.distance_transform_edt(mask, sampling=spacing) > depth, dtype=bool)


def grown(mask: Mask) -> Mask:
    """Mask and all voxels that touch it."""
    return np.asarray(ndimage.binary_dilation(mask, np.ones((3, 3, 3), dtype=bool)), dtype=np.bool_)


def noise_level(data: Array, mask: Mask, spacing: Array, margin: float) -> float:
    """Standard deviation of the noise, from the spread of the sample's surroundings.

    Parameters
    ----------
    data : (nx, ny, nz) float64
        Magnitude image; noise alone is Rayleigh distributed.
    mask : (nx, ny, nz) bool
        Rough sample.
    spacing : (3,) float64
        Voxel edges [m].
    margin : float
        Voxels closer to the sample than this [m] are left out.
    """
    low, high = np.percentile(surroundings(data, mask, spacing, margin), [15.87, 84.13])
    return float(0.5 * (high - low) / RAYLEIGH_SD)


def shared_noise(data: Array, mask: Mask, spacing: Array, margin: float) -> float:
    """Part of the noise's variance that neighbouring voxels share, along the worst axis.

    By the mean square of differences between neighbours over that of voxels `APART`, edges in the
    surroundings left out. A scan has none; interpolation and filters spread the noise of a voxel
    as they do edges.
    Parameters and errors as of `noise_level`.
    """
    outside = _outside(mask, spacing, margin)
    return max(_shared(np.moveaxis(data, a, 0), np.moveaxis(outside, a, 0)) for a in range(3))


def _shared(data: Array, outside: Mask) -> float:
    """The same along the first axis."""
    near, far = (np.abs(data[n:] - data[:-n])[outside[n:] & outside[:-n]] for n in (1, APART))
    most = EDGE * float(np.percentile(far, 68.27)) if len(far) else 0.0
    if most == 0.0:
        return 0.0
    near, far = (apart[apart <= most] for apart in (near, far))
    return 1.0 - float(np.mean(near**2) / np.mean(far**2))


def surroundings(data: Array, mask: Mask, spacing: Array, margin: float) -> Array:
    """Values of `data` farther than `margin` [m] from a mask, (n,)."""
    return np.asarray(data[_outside(mask, spacing, margin)])


def _outside(mask: Mask, spacing: Array, margin: float) -> Mask:
    """Voxels farther than `margin` [m] from a mask; refuses fewer than a hundred."""
    outside = ndimage.distance_transform_edt(~mask, sampling=spacing) > margin
    if np.count_nonzero(outside) < 100:
        raise SegmentationError(
            "fewer than 100 voxels lie outside the sample; give an image with a rim of background"
        )
    return np.asarray(outside, dtype=bool)


def without_noise_floor(data: Array, noise: float) -> Array:
    """Magnitudes with the mean that noise gives to darkness taken out.

    The magnitude of noise alone has a mean of 1.25 standard deviations, which would move the
    half-maximum outward. Darkness becomes zero in the mean, tissue is hardly changed (second
    order of noise over signal). Values may be negative, as noise about zero is.
    """
    square = data**2 - RICIAN * noise**2
    return np.asarray(np.sign(square) * np.sqrt(np.abs(square)))


def bias_field(data: Array, interior: Mask, order: int) -> Array:
    """Multiplicative bias: a polynomial of the logarithm of the tissue, robust against texture.

    Parameters
    ----------
    data : (nx, ny, nz) float64
        Intensities.
    interior : (nx, ny, nz) bool
        Voxels of pure tissue.
    order : int
        Total degree of the polynomial; 0 gives a field of ones.

    Returns
    -------
    (nx, ny, nz) float64
        Bias, geometric mean 1 over `interior`, everywhere positive. Outside the interior the
        polynomial is held at its value on the box around the interior: it must not run away.
    """
    index = np.argwhere(interior)
    low, high = index.min(axis=0), index.max(axis=0)
    centre, half = 0.5 * (low + high), np.maximum(0.5 * (high - low), 1.0)
    values = np.log(np.maximum(data[interior], 1e-6 * np.max(data)))
    values -= values.mean()  # of terms that are one in thin samples the level goes to none
    terms = _polynomial((index - centre) / half, order)
    weight = np.ones(len(values))
    for _ in range(5):
        coefficients = np.linalg.lstsq(terms * weight[:, None], values * weight, rcond=None)[0]
        residual = np.abs(values - terms @ coefficients)
        scale = max(1.4826 * float(np.median(residual)), 1e-9)
        weight = np.sqrt(np.minimum(1.0, 1.5 * scale / np.maximum(residual, 1e-12)))
    mean = float(np.mean(terms @ coefficients))
    axes = [
        np.clip((np.arange(n) - c) / h, -1.0, 1.0)
        for n, c, h in zip(data.shape, centre, half, strict=True)
    ]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    field = np.exp(_polynomial(grid, order) @ coefficients - mean)
    return np.asarray(field.reshape(data.shape), dtype=np.float64)


def _polynomial(x: Array, order: int) -> Array:
    """All monomials of `x` (n, 3) up to a total degree, (n, terms)."""
    powers = [
        (i, j, k)
        for i in range(order + 1)
        for j in range(order + 1 - i)
        for k in range(order + 1 - i - j)
    ]
    return np.stack([x[:, 0] ** i * x[:, 1] ** j * x[:, 2] ** k for i, j, k in powers], axis=1)


def tissue_level(data: Array, interior: Mask, spacing: Array, reach: float) -> Array:
    """Local level of the tissue, carried outward from the interior.

    A Gaussian mean over interior voxels only. Voxels near the boundary hold film, fluid or air
    and say nothing about the tissue; far from any interior voxel the median stands in.
    """
    weight = smooth(interior.astype(np.float64), reach, spacing)
    total = smooth(np.where(interior, data, 0.0), reach, spacing)
    middle = float(np.median(data[interior]))
    least = 1e-4
    return np.asarray((total + least * middle) / (weight + least), dtype=np.float64)
