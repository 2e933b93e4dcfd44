"""Images of which most blocks are zero."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

BLOCK_BITS = 6
BLOCK = 1 << BLOCK_BITS
"""Pixels of a row that are kept together."""
FIRST_SLOTS = 4096
"""Room for blocks at first, while bits are set."""


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


def bits_of_points(
    set_bits: Callable[[NDArray[np.int64], NDArray[np.int32], NDArray[np.uint32]], None], shape: tuple[int, ...], *, points: int
) -> BlockImage:
    """Image of the bits that a compiled loop sets for points, in as many blocks as they need.

    Parameters
    ----------
    set_bits : callable
        Takes a state, which is the number of points that are done and of slots that are used, the slots of all blocks, and the pixels at
        the slots; goes on where the state says until all points are done or there is no room for their blocks.
    shape : tuple of int
        Shape of the image.
    points : int
        Number of points.
    """
    slots = np.zeros((*shape[:-1], blocks_across(shape[-1])), dtype=np.int32)
    words, state = np.zeros((FIRST_SLOTS, BLOCK), dtype=np.uint32), np.array([0, 1])
    while True:
        set_bits(state, slots, words)
        done, used = state.tolist()
        if done == points:
            return BlockImage(shape, slots, words[:used])
        words = np.concatenate([words, np.zeros_like(words)])


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
