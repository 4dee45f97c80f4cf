"""Marks drawn in the image of a sample, looked up at places of its mesh."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsample.arrays import Array, Ids
from softsample.errors import InputError

M_TO_MM = np.diag([1e3, 1e3, 1e3, 1.0])


@dataclass(frozen=True, eq=False)
class MarkedImage:
    """Whole numbers on voxels, with their place in the sample frame.

    Parameters
    ----------
    values : (nx, ny, nz) array
        Whole numbers; 0 where nothing is marked.
    to_index : (4, 4) float64
        From the sample frame [m] to voxel index.
    source : str
        The file's path, for messages.
    """

    values: NDArray[Any]
    to_index: Array
    source: str = "image"

    @classmethod
    def in_world(
        cls, values: NDArray[Any], affine_mm: Array, sample_to_world_mm: ArrayLike, source: str
    ) -> "MarkedImage":
        """Image with an affine from index to world, and the sample's place in the same world.

        Parameters
        ----------
        values : (nx, ny, nz) array
            Whole numbers from 0 on.
        affine_mm : (4, 4) float64
            From voxel index to world [mm].
        sample_to_world_mm : (4, 4)
            From the sample frame to world [mm], as the segmentation found it.
        source
            The file's path, for messages.

        Raises
        ------
        InputError
            If the affine cannot be turned round or a value is no whole number from 0 on.
        """
        if not np.all(np.isfinite(affine_mm)) or np.linalg.matrix_rank(affine_mm[:3, :3]) < 3:
            raise InputError(f"{source}: the affine is singular; export it with its geometry")
        wrong = ~np.isfinite(values) | (values != np.rint(values)) | (values < 0)
        if wrong.any():
            raise InputError(
                f"{source}: {int(wrong.sum())} voxels hold no whole number from 0 on, such as "
                f"{values[wrong][0]:g}; export it as labels, not as intensities"
            )
        to_index = np.linalg.inv(affine_mm) @ np.asarray(sample_to_world_mm) @ M_TO_MM
        return cls(np.rint(values).astype(np.int64), to_index, source)

    def at(self, points: Array) -> Ids:
        """(n,) value of the voxel nearest to each of `points` (n, 3) [m]; 0 outside the image."""
        index = np.rint(points @ self.to_index[:3, :3].T + self.to_index[:3, 3]).astype(np.int64)
        inside = np.all((index >= 0) & (index < self.values.shape), axis=1)
        found = np.zeros(len(points), dtype=np.int64)
        found[inside] = self.values[tuple(index[inside].T)]
        return found
