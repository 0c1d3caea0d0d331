"""Writes the annotations of an Argoverse 2 log as the av2 package stores them."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.feather

CATEGORIES = ("REGULAR_VEHICLE", "BICYCLIST", "PEDESTRIAN", "BOLLARD", "EGO_VEHICLE")


def random_columns(sweeps: int, per_sweep: int, seed: int = 5) -> dict[str, np.ndarray]:
    """Columns of boxes on the ground around a car whose rear axle is 0.33 m above it."""
    random = np.random.default_rng(seed)
    count = sweeps * per_sweep
    yaw, height = random.uniform(-np.pi, np.pi, count), random.uniform(1, 2, count)
    return {
        "timestamp_ns": np.repeat(315968867659956000 + np.arange(sweeps) * 100_000_000, per_sweep),
        "category": random.choice(CATEGORIES, count),
        "length_m": random.uniform(1, 5, count),
        "width_m": random.uniform(0.5, 2, count),
        "height_m": height,
        "qw": np.cos(yaw / 2),
        "qx": np.zeros(count),
        "qy": np.zeros(count),
        "qz": np.sin(yaw / 2),
        "tx_m": random.uniform(-30, 30, count),
        "ty_m": random.uniform(-20, 20, count),
        "tz_m": height / 2 - 0.33,
    }


def write_log(
    folder: Path, columns: Mapping[str, Sequence[object] | np.ndarray], compression: str = "lz4"
) -> Path:
    """annotations.feather in a folder of its own; returns the file."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "annotations.feather"
    pyarrow.feather.write_feather(pa.table(dict(columns)), str(path), compression=compression)
    return path
