"""Samples that a net learns in seconds: road users as clouds of points on flat ground."""

from __future__ import annotations

import numpy as np

from riglens.core.detect.panorama import Panorama
from riglens.core.detect.pillars import Region, Sample, Samples, pillars
from riglens.core.detect.precision import Truth

REGION = Region(16.0, 16.0)
PANORAMA = Panorama(16, 128)
_SIZES = np.array([[4.0, 2.0, 1.5], [1.8, 0.6, 1.7], [0.5, 0.5, 1.8]])


def samples(frames: int, seed: int, panorama: Panorama | None = None) -> Samples:
    """Frames with two to four road users and ground, as pillars or as range images."""
    rng = np.random.default_rng(seed)
    return Samples.of(range(frames), iter([_sample(rng, panorama) for _ in range(frames)]))


def truth_of(held: Samples) -> Truth:
    """The objects of all samples, frames numbered by their place."""
    frame = np.repeat(np.arange(len(held)), np.diff(held.object_starts))
    return Truth(frame, held.cls, held.centre_m, held.points)


def _sample(rng: np.random.Generator, panorama: Panorama | None) -> Sample:
    count = int(rng.integers(2, 5))
    cls, centre = rng.integers(0, 3, count).astype(np.uint8), rng.uniform(-7, 7, (count, 2))
    size = _SIZES[cls]
    spread = rng.uniform(-0.5, 0.5, (60, count, 3)) * size
    users = spread + np.concatenate([centre, size[:, 2:] / 2], axis=1)
    ground = np.stack([*rng.uniform(-8, 8, (2, 300)), rng.normal(0, 0.02, 300)], axis=1)
    points = np.concatenate([users.reshape(-1, 3), ground]).astype(np.float32)
    bright = np.full(len(points), 50, np.float32)
    more = np.zeros((len(points), 0))
    image = (
        pillars(points, bright, REGION) if panorama is None else panorama.pixels(points, bright, REGION, more)
    )
    return Sample(*image, cls, centre, np.full(count, 60))
