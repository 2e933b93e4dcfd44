"""Images that are zero nearly everywhere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class SparseImage:
    """The values of an image that are not zero.

    Parameters
    ----------
    shape : tuple of int
        Shape of the image.
    places : (n,) int64
        Places of the values in the flat image, ascending.
    values : (n,) array
        Values.

    Examples
    --------
    >>> image = SparseImage.of(np.array([[0, 7, 0], [0, 0, 3]]))
    >>> image.at(np.array([0, 1, 1]), np.array([1, 1, 2])).tolist()
    [7, 0, 3]
    """

    shape: tuple[int, ...]
    places: NDArray[np.int64]
    values: NDArray[Any]

    @classmethod
    def of(cls, image: NDArray[Any]) -> Self:
        """Sparse image of a whole one."""
        return cls.at_places(image.shape, np.arange(image.size), image.ravel())

    @classmethod
    def at_places(cls, shape: tuple[int, ...], places: NDArray[np.int64], values: NDArray[Any]) -> Self:
        """Sparse image with the values at places of the flat image, ascending, that are not zero."""
        return cls(shape, places[values != 0], values[values != 0])

    def at(self, *index: Any) -> NDArray[Any]:
        """Values at indices inside the image, one array for each axis; they are broadcast."""
        place = np.ravel_multi_index(np.broadcast_arrays(*index), self.shape)
        if not len(self.places):
            return np.zeros(place.shape, dtype=self.values.dtype)
        nearest = np.minimum(np.searchsorted(self.places, place), len(self.places) - 1)
        return np.where(self.places[nearest] == place, self.values[nearest], self.values.dtype.type(0))

    def whole(self) -> NDArray[Any]:
        """The whole image."""
        image = np.zeros(self.shape, dtype=self.values.dtype)
        image.ravel()[self.places] = self.values
        return image
