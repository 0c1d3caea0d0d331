"""What an evaluation says: entropies in nats, S-MIG, S-MS and `seen` per class (names of the paper)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Reading = Literal["covered", "residual", "hits"]
Method = Literal["exact", "bresenham"]
READINGS: tuple[Reading, ...] = ("covered", "residual", "hits")
METHODS: tuple[Method, ...] = ("exact", "bresenham")
DEFAULT_LAMBDA = 0.1


@dataclass(frozen=True)
class MetricSettings:
    """How the score is computed: traversal method, reading of S-MIG and the camera weight lambda."""

    method: Method = "exact"
    reading: Reading = "covered"
    camera_weight: float = DEFAULT_LAMBDA


PAPER_SETTINGS = MetricSettings()


@dataclass(frozen=True)
class KindScore:
    """Score of all cameras or all LiDARs: S-MIG in nats, `seen` as a fraction of H(Omega)."""

    s_mig: float
    seen: float


@dataclass(frozen=True)
class ClassScores:
    """Scores of one class; entropies in nats, `any_seen` is the share seen by any sensor."""

    h_total: float
    camera: KindScore
    lidar: KindScore
    any_seen: float
    s_ms: float


@dataclass(frozen=True)
class Scores:
    """Scores per class name, and the number of informative voxels covered by "camera", "lidar", "any"."""

    classes: dict[str, ClassScores]
    covered_voxels: dict[str, int]
