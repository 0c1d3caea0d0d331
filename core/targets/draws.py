"""Random draws that depend only on their purpose: the seed, the sensor's name, the frame, the ray.

A counter-based hash of a key and some counters, the finaliser of SplitMix64 (Steele, Lea, Flood 2014). A sensor that
moves keeps its draws, and so do sensors of the same name on two rigs: what is compared differs by the poses, not by
luck.
"""

from __future__ import annotations

import hashlib

import numpy as np
from numpy.typing import NDArray

Keys = NDArray[np.uint64]
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)


def mixed(key: int | Keys, counters: NDArray[np.int64]) -> Keys:
    """Return keys (n,) that belong to counters (n,) under a key, or under keys (n,)."""
    word = np.asarray(key, np.uint64) + (np.atleast_1d(counters).astype(np.uint64) + np.uint64(1)) * _GOLDEN
    word = (word ^ (word >> np.uint64(30))) * _FIRST
    word = (word ^ (word >> np.uint64(27))) * _SECOND
    return np.asarray(word ^ (word >> np.uint64(31)))


def units(keys: Keys) -> NDArray[np.float64]:
    """Return numbers in [0, 1), one for each key."""
    return (keys >> np.uint64(11)).astype(np.float64) / (1 << 53)


def sensor_key(seed: int, name: str) -> int:
    """Return the key of a sensor: the first 8 bytes of the SHA-256 of seed and name."""
    digest = hashlib.sha256(f"{seed} {name}".encode()).digest()
    return int.from_bytes(digest[:8], "little")


def shuffled(frames: int) -> NDArray[np.int64]:
    """Return the frames 0..frames-1 in sampling order: any first part of them is a fair sample."""
    return np.argsort(mixed(0, np.arange(frames)), kind="stable").astype(np.int64)
