"""Regions of different stiffness in a sample."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsample.arrays import Array, Ids
from softsample.errors import InputError
from softsample.meshing.marks import MarkedImage
from softsample.meshing.mesh import HexMesh


def element_regions(mesh: HexMesh, labels: MarkedImage) -> Ids:
    """(n_elements,) label of the voxel nearest to the middle of each element, 0 where none is.

    Raises
    ------
    InputError
        If no element has a label.
    """
    regions = labels.at(mesh.points[mesh.hexes].mean(axis=1))
    if not regions.any():
        raise InputError(
            f"{labels.source}: labels no element of the sample; give it the world frame of the "
            "sample's image, or leave labels empty"
        )
    return regions


def stiffness_of(
    cell_data: Mapping[str, NDArray[Any]], mapping: Mapping[int | str, float] | None
) -> Array | None:
    """`relative_stiffness` of the elements of a mesh, None if it has no regions."""
    return relative_stiffness(cell_data["region"], mapping or {}) if "region" in cell_data else None


def relative_stiffness(regions: Ids, mapping: Mapping[int | str, float]) -> Array:
    """Stiffness of each element relative to the sample's, whose moduli are calibrated.

    Parameters
    ----------
    regions : (n_elements,) int64
        Labels, see `element_regions`; 0 is unlabelled.
    mapping
        Relative stiffness > 0 by label, as in the config ``material: region_stiffness``; labels
        that the sample does not have are passed over, 0 is 1.0 if it is not named.

    Returns
    -------
    (n_elements,) float64

    Raises
    ------
    InputError
        If a label of the sample has no stiffness, or one that is not positive.
    """
    known = {0: 1.0, **{int(label): float(value) for label, value in mapping.items()}}
    present, place = np.unique(regions, return_inverse=True)
    unknown = [int(label) for label in present if int(label) not in known]
    if unknown:
        named = ", ".join(str(label) for label in sorted(known))
        raise InputError(
            f"labels {', '.join(map(str, unknown))} have no stiffness (known are {named}); name "
            f"each in the config, such as material: {{region_stiffness: {{{unknown[0]}: 1.0}}}}"
        )
    values = np.array([known[int(label)] for label in present])
    if not np.all((values > 0.0) & np.isfinite(values)):
        raise InputError(
            f"region_stiffness of label {present[np.argmin(values)]} is {values.min():g}; "
            "give a number above 0"
        )
    return values[place.ravel()]
