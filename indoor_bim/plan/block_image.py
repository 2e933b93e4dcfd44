"""Images of which most blocks are zero."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

BLOCK_BITS = 6
BLOCK = 1 << BLOCK_BITS
"""Pixels of a row that are kept together."""


@dataclass(frozen=True, slots=True, eq=False)
class BlockImage:
    """The blocks of an image that are not zero everywhere.

    Parameters
    ----------
    shape : tuple of int
        Shape of the image; the last axis runs along the rows.
    slot : (..., blocks) int32
        Where the pixels of each block stand; 0 where all are zero.
    values : (k, BLOCK) array
        Pixels of the blocks; those of the first are zero.

    Examples
    --------
    >>> image = BlockImage.of(np.eye(2, 500, dtype=np.int64))
    >>> image.slot.tolist(), image.values.shape, image.at(np.array([0, 1, 501])).tolist()
    ([[1, 0, 0, 0, 0, 0, 0, 0], [2, 0, 0, 0, 0, 0, 0, 0]], (3, 64), [1, 0, 1])
    """

    shape: tuple[int, ...]
    slot: NDArray[np.int32]
    values: NDArray[Any]

    @classmethod
    def of(cls, image: NDArray[Any]) -> Self:
        """Image in blocks of a whole one."""
        *rows, columns = image.shape
        padded = np.zeros((*rows, blocks_across(columns) * BLOCK), dtype=image.dtype)
        padded[..., :columns] = image
        padded = padded.reshape(*rows, blocks_across(columns), BLOCK)
        used: NDArray[np.bool_] = np.asarray(padded.any(axis=-1))
        return cls(image.shape, slots_of(used), np.concatenate([np.zeros((1, BLOCK), dtype=image.dtype), padded[used]]))

    def side(self, number: int) -> BlockImage:
        """One image of several."""
        return BlockImage(self.shape[1:], self.slot[number], self.values)

    def at(self, places: NDArray[np.int64]) -> NDArray[Any]:
        """Values at places (n,) of the flat image."""
        *index, column = np.unravel_index(places, self.shape)
        slots = self.slot[(*index, column >> BLOCK_BITS)]
        values: NDArray[Any] = self.values[slots, column & (BLOCK - 1)]
        return values

    def nonzero(self) -> tuple[NDArray[np.int64], ...]:
        """Indices of the pixels that are not zero, one array for each axis, ascending."""
        *index, block = np.nonzero(self.slot)
        number, column = np.nonzero(self.values[self.slot[(*index, block)]])
        return (*(axis[number] for axis in index), block[number] * BLOCK + column)

    def whole(self) -> NDArray[Any]:
        """The whole image."""
        *rows, columns = self.shape
        image: NDArray[Any] = self.values[self.slot].reshape(*rows, self.slot.shape[-1] * BLOCK)
        return image[..., :columns]


def blocks_across(columns: int) -> int:
    """Number of blocks of a row."""
    return -(-columns // BLOCK)


def slots_of(used: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Slots of blocks, numbered in their order from 1; 0 for those that are not used.

    Examples
    --------
    >>> slots_of(np.array([[False, True], [True, False]])).tolist()
    [[0, 1], [2, 0]]
    """
    slot = np.zeros(used.shape, dtype=np.int32)
    slot[used] = np.arange(1, np.count_nonzero(used) + 1)
    return slot
