"""Surfaces for the interactive view of the report, small enough to travel inside it."""

import base64
from collections.abc import Mapping
from typing import Any

import numpy as np
import pyvista
from numpy.typing import NDArray

from softsample.arrays import Array, Ids

Shape = tuple[Array, Array, Ids, Array]
"""Points before and after, faces, values."""

MOST_FACES = 12_000
"""A finer surface is decimated: a browser draws this many faces in a few hundredths of a second."""

PERCENTILE = 99.0
"""Of the values at which the colours end, which begin at no strain, as in figure 7."""

LARGEST = 32767


def scene(surfaces: Mapping[str, Shape]) -> dict[str, Any]:
    """One sample on several geometries, with common colours, as plain JSON values.

    Parameters
    ----------
    surfaces
        By geometry: points (n, 3) [mm] before the test, points (n, 3) [mm] at its end, faces
        (m, 3 or 4) outward by the right-hand rule, and values (n,) to colour by.

    Returns
    -------
    dict
        `limits` of the colours; `extent_mm`, the largest extent before the test; `surfaces` by
        geometry: `corners` of a face, `unit` [mm] of the coordinates, and little-endian arrays in
        base64: `before`, `after` (int16), `faces` (uint16), `values` (uint8, 0 to 255 between
        the limits).
    """
    values = np.concatenate([s[3] for s in surfaces.values()])
    limits = np.array([0.0, np.percentile(values[np.isfinite(values)], PERCENTILE)])
    return {
        "limits": [float(end) for end in limits],
        "extent_mm": max(float(np.ptp(s[0], axis=0).max()) for s in surfaces.values()),
        "surfaces": {name: _packed(_thinned(shape), limits) for name, shape in surfaces.items()},
    }


def _thinned(shape: Shape) -> Shape:
    """The surface without points that no face uses, decimated to triangles if it is too fine."""
    before, after, faces, values = shape
    corners = faces.shape[1]
    used, flat = np.unique(faces, return_inverse=True)
    before, after, values = before[used], after[used], values[used]
    faces = flat.reshape(-1, corners)
    if len(faces) <= MOST_FACES and len(used) <= 1 << 16:
        return before, after, faces, values
    whole = pyvista.PolyData(before, np.insert(faces, 0, corners, axis=1).ravel())
    whole["after"], whole["values"] = after, values
    triangles = whole.triangulate()
    coarse = triangles.decimate_pro(1.0 - MOST_FACES / triangles.n_cells)
    return (
        np.asarray(coarse.points, dtype=np.float64),
        np.asarray(coarse["after"]),
        coarse.faces.reshape(-1, 4)[:, 1:].astype(np.int64),
        np.asarray(coarse["values"]),
    )


def _packed(shape: Shape, limits: Array) -> dict[str, Any]:
    before, after, faces, values = shape
    unit = max(float(np.abs(before).max()), float(np.abs(after).max())) / LARGEST
    share = (values - limits[0]) / max(float(limits[1] - limits[0]), 1e-12)
    return {
        "corners": faces.shape[1],
        "unit": unit,
        "before": _base64(np.rint(before / unit), "<i2"),
        "after": _base64(np.rint(after / unit), "<i2"),
        "faces": _base64(faces, "<u2"),
        "values": _base64(np.rint(255.0 * np.clip(share, 0.0, 1.0)), "u1"),
    }


def _base64(array: NDArray[Any], kind: str) -> str:
    return base64.b64encode(array.astype(kind).tobytes()).decode()
