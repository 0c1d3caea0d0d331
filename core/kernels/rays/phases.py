"""Random numbers that depend on what they are for and on nothing else: not on order, threads or earlier draws.

A counter-based hash (the finaliser of SplitMix64: Steele, Lea, Flood 2014) of a key and some counters.
"""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.runtime.jit import lean_inlined

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)
_TO_UNIT = 1.0 / (1 << 53)


@lean_inlined
def mixed(key: np.uint64, counter: np.uint64) -> np.uint64:
    """Return a key that belongs to a counter under another key."""
    word = np.uint64(key + (counter + np.uint64(1)) * _GOLDEN)
    word = (word ^ (word >> np.uint64(30))) * _FIRST
    word = (word ^ (word >> np.uint64(27))) * _SECOND
    return np.uint64(word ^ (word >> np.uint64(31)))


@lean_inlined
def unit(key: np.uint64) -> float:
    """Return a number in [0, 1) from a key."""
    return np.float64(key >> np.uint64(11)) * _TO_UNIT
