"""Compilation of the few loops that numpy has no words for, kept on disk so that it happens once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba


def compiled(*signature: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function for the given argument types; it lets go of Python's lock and is kept on disk where that can be written.

    Parameters
    ----------
    *signature : numba types
        Types of the arguments.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        try:
            return numba.njit(signature, nogil=True, cache=True)(function)
        except RuntimeError:  # no folder to keep it in
            return numba.njit(signature, nogil=True)(function)

    return decorate


def inlined(function: Callable[..., Any]) -> Any:
    """Function that compiled functions take in as if it were written there."""
    return numba.njit(inline="always")(function)
