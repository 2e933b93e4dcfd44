"""Where a key stands in a table with open addressing whose length is a power of two."""

from __future__ import annotations

import numpy as np

from indoor_bim.compiled import inlined

FREE = np.int64(-1)
HASH = np.uint64(0x9E3779B97F4A7C15)
ONE = np.uint64(1)
FOLD, HIGH = np.uint64(29), np.uint64(32)


@inlined
def slot_of(key, taken):  # type: ignore[no-untyped-def]
    """Slot that holds the key, or the free one where it belongs."""
    wrap = np.uint64(len(taken) - 1)
    word = np.uint64(key)
    slot = (((word ^ word >> FOLD) * HASH) >> HIGH) & wrap
    there = taken[slot]
    while there != key and there != FREE:
        slot = (slot + ONE) & wrap
        there = taken[slot]
    return slot
