"""Idealised shape and areas of a sample, from its signed distance.

The definitions are in ``docs/geometry.md``; they follow sections 2.4.1 and 3.1 of the study
as far as it states them (S. Arzemanzadeh, K. Miller, A. Wittek, On the validity of using idealised
sample geometries for interpreting mechanical tests of very soft tissues).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from skimage.measure import find_contours

from softsample.arrays import Array
from softsample.errors import InputError, SegmentationError
from softsample.imaging import distance as sdf
from softsample.imaging import frame
from softsample.meshing.levelset import column_heights, highest_point
from softsample.shapes import IdealShape
from softsample.units import MM

ROUND = 0.7
"""A sample of at least this `circularity` is proposed to be idealised as a cylinder.

A cuboid whose vertical edges have a third of its shorter edge as radius reaches 0.44, an ellipse
whose axes differ by 10 % has 0.91 and one by 40 % 0.71; `docs/geometry.md` has synthetic samples.
"""

LEVELS = (0.25, 0.5, 0.75)
"""Heights of the sections of `circularity`, over that of the highest point."""

WIDTH_CORE = 0.7
"""Central part of a section's extent across over which its mean width is taken: rounded vertical
edges do not count."""

TOP_CORE = 0.7
"""Central part of length and width over which the top's height is averaged: its rim does not
count."""


@dataclass(frozen=True)
class MeasurementSettings:
    """Settings of `measure`; the names and defaults of the config section `measurement`.

    Attributes
    ----------
    section_offset_mm : float
        Distance of the lower and upper section from base and top [mm].
    top_normal_deg : float
        Surface within this angle of vertical belongs to the top [degrees].
    preload_mm : float
        Depth below the highest point down to which the top is glued [mm].
    """

    section_offset_mm: float = 0.75
    top_normal_deg: float = 30.0
    preload_mm: float = 1.0


def measure(
    distance: ArrayLike,
    origin: ArrayLike,
    spacing: float,
    settings: MeasurementSettings | None = None,
    shape: str = "cuboid",
) -> dict[str, Any]:
    """Measure the idealised shape and the areas of a sample.

    Parameters
    ----------
    distance : (nx, ny, nz) array
        Signed distance in the sample frame [m], negative inside, walls carried on below z = 0.
        A grid layer must lie at z = 0.
    origin : (3,) array
        Position of ``distance[0, 0, 0]`` [m].
    spacing : float
        Grid spacing [m].
    shape : {"cuboid", "cylinder"}
        What the sample is idealised as.

    Returns
    -------
    dict
        Flat record in mm, mm2, mm3 and percent, the keys of ``cuboid/{sample}.json``. Percents
        are ``100 (area / ideal area - 1)``. `circularity` and `proposed_shape` say which shape
        the sample looks like, whichever it is idealised as.

    Raises
    ------
    InputError
        If the arguments do not describe a grid.
    SegmentationError
        If the surface is too low, or open, for the sections.
    """
    settings = settings or MeasurementSettings()
    field, start = _checked(distance, origin, spacing)
    top = top_heights(field, start, spacing)
    peak = highest_point(field, start, spacing)
    ideal, sections, top_sd = _idealised(field, start, spacing, top, settings, shape)
    areas = _areas(field, start, spacing, float(peak[2]), settings)
    roundness = circularity(field, start, spacing)
    return {
        **ideal.report(),
        **{
            f"{name}_sections_mm": [size / MM for size in sizes] for name, sizes in sections.items()
        },
        **{f"{name}_area_mm2": area / MM**2 for name, area in areas.items()},
        **{
            f"{name}_difference_percent": 100.0 * (area / ideal.area - 1.0)
            for name, area in areas.items()
        },
        "volume_real_mm3": sdf.volume_above_base(field, start, spacing) / MM**3,
        "highest_point_mm": float(peak[2] / MM),
        "highest_point_position_mm": [float(value / MM) for value in peak],
        "top_height_sd_mm": top_sd / MM,
        "circularity": roundness,
        "proposed_shape": proposed_shape(roundness),
    }


def circularity(distance: Array, origin: Array, spacing: float) -> float:
    """How much the sections look like a disc: 1 for a disc, 0 for a rectangle.

    The product of two ratios, mean over three sections: how much of the smallest rectangle
    around the section its corners leave empty, from 0 to the ``1 - pi/4`` of an ellipse (1 there,
    less again if more is empty), and its shorter side over its longer one.

    Parameters
    ----------
    distance, origin, spacing
        As of `measure`.
    """
    peak = highest_point(distance, origin, spacing)[2]
    planes = [section(distance, origin, spacing, float(level * peak)) for level in LEVELS]
    return float(np.mean([_section_circularity(plane) for plane in planes]))


def proposed_shape(circularity: float) -> str:
    """Shape that a sample of this `circularity` looks like; a person decides."""
    return "cylinder" if circularity >= ROUND else "cuboid"


def _section_circularity(plane: Array) -> float:
    """`circularity` of one section, from its outline at grid resolution or better."""
    outline = np.concatenate(find_contours(plane, 0.0))
    angles = np.radians(np.arange(90))
    across = np.ptp(outline @ np.stack([np.cos(angles), np.sin(angles)]), axis=0)
    along = np.ptp(outline @ np.stack([-np.sin(angles), np.cos(angles)]), axis=0)
    best = int(np.argmin(across * along))
    empty = 1.0 - section_area(plane, 1.0) / (across[best] * along[best])
    sides = sorted((across[best], along[best]))
    full = 1.0 - 0.25 * np.pi
    return float(max(0.0, 1.0 - abs(empty - full) / full) * sides[0] / sides[1])


def section(field: Array, origin: Array, spacing: float, height: float) -> Array:
    """Signed distance on the plane z = `height`, linear between layers, (nx, ny) [m]."""
    place = (height - origin[2]) / spacing
    place = float(np.round(place)) if abs(place - np.round(place)) < 1e-6 else place
    lower = int(np.floor(place))
    if lower < 0 or lower + 1 >= field.shape[2]:
        raise SegmentationError(
            f"section at {height / MM:.3g} mm lies outside the segmented sample; look at it"
        )
    share = place - lower
    return np.asarray((1.0 - share) * field[:, :, lower] + share * field[:, :, lower + 1])


def section_area(plane: Array, spacing: float) -> float:
    """Area inside the zero contour of a section [m2], by the contour's polygons."""
    total = 0.0
    for contour in find_contours(plane, 0.0):
        x, y = contour[:, 0], contour[:, 1]
        total += 0.5 * float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))
    return abs(total) * spacing**2


def mean_width(plane: Array, spacing: float, core: float) -> float:
    """Mean width of a section along its first axis [m].

    Mean of the chords along the first axis at the rows in the central part `core` of the
    section's extent along the second axis: rounded vertical edges do not count.
    """
    inside = plane < 0.0
    rows = np.flatnonzero(inside.any(axis=0))
    if rows.size < 3:
        raise SegmentationError("a section for the cuboid is empty; look at the segmentation")
    chords = np.array([_chord(plane[:, row]) for row in rows]) * spacing
    columns = np.flatnonzero(inside.any(axis=1))
    across = [_crossings(plane[column]) for column in columns]
    low, high = min(pair[0] for pair in across), max(pair[1] for pair in across)
    share = _overlap(rows.astype(np.float64), 0.5 * (low + high), 0.5 * core * (high - low))
    return float(np.sum(share * chords) / np.sum(share))


def _overlap(centres: Array, middle: float, half: float) -> Array:
    """Share of each unit cell around `centres` within `half` of `middle`."""
    low = np.maximum(centres - 0.5, middle - half)
    high = np.minimum(centres + 0.5, middle + half)
    return np.asarray(np.maximum(high - low, 0.0))


def _crossings(line: Array) -> tuple[float, float]:
    """First and last zero of a line of distances, in grid spacings."""
    inside = np.flatnonzero(line < 0.0)
    first, last = int(inside[0]), int(inside[-1])
    if first == 0 or last == len(line) - 1:
        raise SegmentationError("the segmented sample is cut by its grid; look at it")
    start = first - line[first] / (line[first] - line[first - 1])
    end = last + line[last] / (line[last] - line[last + 1])
    return float(start), float(end)


def _chord(line: Array) -> float:
    """Length inside on a line of distances, in grid spacings; re-entrant gaps are left out."""
    a, b = line[:-1], line[1:]
    low, high = np.minimum(a, b), np.maximum(a, b)
    inside = np.where(high <= 0.0, 1.0, np.where(low >= 0.0, 0.0, -low / (high - low + 1e-300)))
    return float(inside.sum())


def top_heights(field: Array, origin: Array, spacing: float) -> Array:
    """Height of the top over each column, (nx, ny) [m]; NaN outside the sample."""
    if (field[:, :, -1] < 0.0).any():
        raise SegmentationError("the segmented sample is cut by its grid at the top; look at it")
    height = column_heights(field, origin, spacing)
    return np.where(height > 0.0, height, np.nan)


def _core_heights(top: Array, share: Array) -> tuple[float, float]:
    """Mean and standard deviation of the top [m] over `share` (nx, ny) of each column."""
    share = share * np.isfinite(top)
    if share.sum() == 0.0:
        raise SegmentationError("the core of the top is empty; look at the segmentation")
    height = np.where(share > 0.0, top, 0.0)
    # ASSUME: the cuboid is as high as the mean of the top's core; the paper fixes no height.
    mean = float(np.sum(share * height) / share.sum())
    return mean, float(np.sqrt(np.sum(share * (height - mean) ** 2) / share.sum()))


def _core(
    kind: str, columns: tuple[int, ...], origin: Array, spacing: float, sides: tuple[float, float]
) -> Array:
    """Share of each column of the grid (nx, ny) in the rectangle, or circle, of `sides` [m]."""
    x, y = (origin[axis] / spacing + np.arange(columns[axis]) for axis in (0, 1))
    half = [0.5 * side / spacing for side in sides]
    if kind == "cylinder":
        away = np.hypot(x[:, None], y) - half[0]
        return np.asarray(np.clip(0.5 - away, 0.0, 1.0))
    return np.outer(_overlap(x, 0.0, half[0]), _overlap(y, 0.0, half[1]))


def _idealised(
    field: Array,
    origin: Array,
    spacing: float,
    top: Array,
    settings: MeasurementSettings,
    kind: str,
) -> tuple[IdealShape, dict[str, list[float]], float]:
    """Idealised shape, the sizes of its three sections, and the top's standard deviation [m].

    The height sets the sections and the lengths set the core of the height: iterated.
    """
    sizes_of = _round_sizes if kind == "cylinder" else _straight_sizes
    height = float(np.nanmedian(top))
    length, width = (spacing * np.isfinite(top).any(axis=1 - axis).sum() for axis in (0, 1))
    for _ in range(20):
        before = np.array([length, width, height])
        core = (TOP_CORE * length, TOP_CORE * width)
        height, spread = _core_heights(top, _core(kind, top.shape, origin, spacing, core))
        planes = _three_sections(field, origin, spacing, height, settings.section_offset_mm * MM)
        length, width, sections = sizes_of(planes, spacing)
        if np.allclose(before, [length, width, height], rtol=1e-6, atol=0.0):
            break
    return IdealShape(kind, length, width, height), sections, spread


def _three_sections(
    field: Array, origin: Array, spacing: float, height: float, offset: float
) -> list[Array]:
    """Sections at `offset` above the base, at half the height, and `offset` below the top."""
    # ASSUME: the paper measures "at the top, middle and bottom"; how far from the ends is not said.
    if height < 2.0 * offset:
        raise SegmentationError(
            f"sample is {height / MM:.3g} mm high, lower than two section offsets; look at"
            " the segmentation or lower measurement: section_offset_mm"
        )
    return [section(field, origin, spacing, z) for z in (offset, 0.5 * height, height - offset)]


def _straight_sizes(
    planes: list[Array], spacing: float
) -> tuple[float, float, dict[str, list[float]]]:
    """Length and width of a cuboid, and those of its sections [m]: mean widths."""
    lengths = [mean_width(plane, spacing, WIDTH_CORE) for plane in planes]
    widths = [mean_width(plane.T, spacing, WIDTH_CORE) for plane in planes]
    sections = {"length": lengths, "width": widths}
    return float(np.mean(lengths)), float(np.mean(widths)), sections


def _round_sizes(
    planes: list[Array], spacing: float
) -> tuple[float, float, dict[str, list[float]]]:
    """Diameter of a cylinder, twice, and those of its sections [m]: circles of equal area."""
    areas = np.array([section_area(plane, spacing) for plane in planes])
    diameter = float(np.sqrt(4.0 / np.pi * areas.mean()))
    return diameter, diameter, {"diameter": np.sqrt(4.0 / np.pi * areas).tolist()}


def _areas(
    field: Array, origin: Array, spacing: float, peak: float, settings: MeasurementSettings
) -> dict[str, float]:
    """Areas of the base, of the top by its normal, and of what is glued by its depth [m2].

    The last two take upward facing surface, counted as its projection on the base.
    """
    surface = frame.iso_surface(-field, 0.0, frame.grid_affine(origin, spacing))
    vectors, centres = surface.area_vectors, surface.centres
    area = np.linalg.norm(vectors, axis=1)
    rising = vectors[:, 2] > 0.0
    upper = rising & (centres[:, 2] > 0.5 * peak)
    steep = vectors[:, 2] > np.cos(np.radians(settings.top_normal_deg)) * area
    glued = rising & (centres[:, 2] >= peak - settings.preload_mm * MM)
    return {
        "bottom": section_area(section(field, origin, spacing, 0.0), spacing),
        "top": float(vectors[upper & steep, 2].sum()),
        "glued": float(vectors[glued, 2].sum()),
    }


def _checked(distance: ArrayLike, origin: ArrayLike, spacing: float) -> tuple[Array, Array]:
    """Arguments of `measure` as arrays, or an error."""
    field, start = np.asarray(distance, dtype=np.float64), np.asarray(origin, dtype=np.float64)
    if field.ndim != 3 or start.shape != (3,) or not spacing > 0.0:
        raise InputError(
            f"distance {field.shape}, origin {start.shape} and spacing {spacing} are not a grid"
        )
    if not np.all(np.isfinite(field)) or not np.any(field < 0.0):
        raise InputError("distance must be finite and negative inside the sample")
    if abs(start[2] / spacing - np.round(start[2] / spacing)) > 1e-4 or start[2] > 0.0:
        raise InputError(
            f"distance has no grid layer at z = 0 (first layer at {start[2] / MM:.4g} mm);"
            " resample it"
        )
    return field, start
