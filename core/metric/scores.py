"""What an evaluation says: entropies in nats, S-MIG, S-MS and `seen` per class (paper, eq. 15-17)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

Reading = Literal["covered", "residual", "hits"]
Method = Literal["exact", "bresenham"]
Body = Literal["ignored", "blocks"]
"""Whether rays pass through the car's own body, as in the paper, or end at it."""
READINGS: tuple[Reading, ...] = ("covered", "residual", "hits")
METHODS: tuple[Method, ...] = ("exact", "bresenham")
BODIES: tuple[Body, ...] = ("ignored", "blocks")
DEFAULT_LAMBDA = 0.1
MAX_LAMBDA = 1e6


@dataclass(frozen=True)
class MetricSettings:
    """How the score is computed: traversal method, reading of S-MIG, the camera weight lambda, the car's body (None:
    as each rig says)."""

    method: Method = "exact"
    reading: Reading = "covered"
    camera_weight: float = DEFAULT_LAMBDA
    body: Body | None = "ignored"


PAPER_SETTINGS = MetricSettings()


def common_body(bodies: Iterable[Body | None]) -> Body | None:
    """Return the body mode that all rigs were scored with, None when they differ."""
    found = set(bodies)
    return found.pop() if len(found) == 1 else None


def s_mig(reading: Reading, seen_nat: float, unseen_nat: float, hits_nat: float = 0.0) -> float:
    """Return S-MIG in nat of all sensors of a kind (paper, eq. 16).

    seen_nat: H(Omega|C), the entropy of the voxels seen; unseen_nat: that of all others, which is the information gain
    of eq. 15; hits_nat: the sum over the voxels of every ray. The paper's reading is `covered`.
    """
    if reading == "residual":
        return -unseen_nat
    magnitude = hits_nat if reading == "hits" else seen_nat
    return -magnitude if magnitude else 0.0


def s_ms(camera_s_mig: float, lidar_s_mig: float, camera_weight: float) -> float:
    """Return S-MS in nat from the S-MIG of all cameras and of all LiDARs (paper, eq. 17); camera_weight is lambda."""
    return camera_weight * camera_s_mig + lidar_s_mig


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
