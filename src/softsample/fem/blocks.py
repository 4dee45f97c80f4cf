"""Values of elements in blocks of vector lanes, in an order that lets whole registers be loaded."""

import numpy as np
from numpy.typing import NDArray

from softsample.arrays import Mask
from softsample.fem.lanes import LANES, group


def aligned(shape: tuple[int, ...], dtype: np.dtype) -> NDArray:
    """Zeros that start at a cache line, so that no vector load crosses two."""
    size = int(np.prod(shape)) * dtype.itemsize
    raw = np.zeros(size + 64, np.uint8)
    start = -raw.ctypes.data % 64
    return raw[start : start + size].view(dtype).reshape(shape)


def groups_first(ids: NDArray, hexes: NDArray, precision: np.dtype) -> NDArray:
    """Reorder element `ids` (n,): groups first in which all eight nodes follow one another.

    Rows of a grid whose nodes are numbered along them give groups; `hexes` (n_elements, 8) are
    the nodes of all elements, `precision` says how many elements a group has.
    """
    size = group(LANES[precision])
    new_row = np.ones(len(ids), bool)
    new_row[1:] = np.any(np.diff(hexes[ids], axis=0) != 1, axis=1)
    starts, row = np.flatnonzero(new_row), np.cumsum(new_row) - 1
    lengths = np.diff(np.append(starts, len(ids)))
    whole = np.arange(len(ids)) - starts[row] < (lengths // size * size)[row]
    return np.concatenate([ids[whole], ids[~whole]])


def is_grouped(nodes: NDArray) -> Mask:
    """Whether each block of `nodes` (n_blocks, 8, n) is made of such groups only."""
    blocks, corners, count = nodes.shape
    steps = np.diff(nodes.reshape(blocks, corners, -1, group(count)), axis=-1)
    return np.asarray(np.all(steps == 1, axis=(1, 2, 3)))


def pack(values: NDArray, precision: np.dtype, padding: float | None = None) -> NDArray:
    """Values (n_elements, ...) as blocks (n_blocks, ..., n), floats in `precision`.

    The last block repeats the last element, or is filled with `padding`.
    """
    count, n = LANES[precision], len(values)
    index = np.arange(-(-n // count) * count)
    filled = values[np.minimum(index, n - 1)]
    if padding is not None:
        filled[n:] = padding
    blocks = np.moveaxis(filled.reshape(-1, count, *values.shape[1:]), 1, -1)
    packed = aligned(blocks.shape, precision if values.dtype.kind == "f" else np.dtype(np.int32))
    packed[:] = blocks
    return packed
