"""Define the result of an evaluation: entropies in nats, S-MIG, S-MS and `seen` per class (paper, eq. 15-17)."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Literal

Reading = Literal["covered", "residual", "hits"]
Method = Literal["exact", "bresenham"]
Body = Literal["ignored", "blocks"]
"""Effect of the car's own body on rays: they pass through it, as in the paper, or end at it."""
READINGS: tuple[Reading, ...] = ("covered", "residual", "hits")
METHODS: tuple[Method, ...] = ("exact", "bresenham")
BODIES: tuple[Body, ...] = ("ignored", "blocks")
DEFAULT_LAMBDA = 0.1
MAX_LAMBDA = 1e6


@dataclass(frozen=True)
class MetricSettings:
    """Settings of the score: traversal method, reading of S-MIG, the camera weight lambda, the car's body (None: as
    each rig says)."""

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


def s_ms(s_mig_by_kind: Mapping[str, float], camera_weight: float) -> float:
    """Return S-MS in nat from the S-MIG of all sensors of each kind (paper, eq. 17); camera_weight is lambda."""
    from riglens.core.sensors.registry import (
        kinds,  # the models of sensors take their time, and --help needs none
    )

    weights = {kind.name: kind.score_weight for kind in kinds()}
    parts = (
        (camera_weight if weights[kind] == "lambda" else float(weights[kind])) * value
        for kind, value in s_mig_by_kind.items()
        if weights[kind] != 0.0
    )
    return reduce(operator.add, parts, -0.0)


@dataclass(frozen=True)
class KindScore:
    """Score of all sensors of a kind: S-MIG in nats, `seen` as a fraction of H(Omega)."""

    s_mig: float
    seen: float


@dataclass(frozen=True)
class ClassScores:
    """Scores of one class by kind of sensor; entropies in nats, `any_seen` is the share seen by any sensor."""

    h_total: float
    kinds: Mapping[str, KindScore]
    any_seen: float
    s_ms: float

    @property
    def camera(self) -> KindScore:
        """Score of all cameras."""
        return self.kinds["camera"]

    @property
    def lidar(self) -> KindScore:
        """Score of all LiDARs."""
        return self.kinds["lidar"]


@dataclass(frozen=True)
class Scores:
    """Scores per class name, and the number of informative voxels covered by each kind of sensor and by "any"."""

    classes: dict[str, ClassScores]
    covered_voxels: dict[str, int]
