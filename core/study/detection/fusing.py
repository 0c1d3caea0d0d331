"""Join the detections of LiDARs and of cameras late, as lists: two detectors that know nothing of each other.

Scores of two nets do not mean the same. Each is first turned into the chance that a detection is right, learned on
half of the test's sequences and used on the other half. A detection by both is wrong only if both err.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from riglens.core.detect.precision import Detections, Truth, right_detections
from riglens.core.scene.boxes import CLASSES

Doubles = NDArray[np.float64]
Flags = NDArray[np.bool_]
Judged = tuple[Truth, Detections]
"""Objects of the test frames, and what a net finds there."""

RIGHT_M = 2.0
"""A detection is right within this distance of its object, metres."""
MEETING_M, MEETING_SHARE = 2.0, 0.1
"""Detections of a LiDAR and of a camera are one object within this distance, plus this share of the distance from the
car: pictures err in proportion to it."""
_STEPS, _RIDGE, _UNIT_M = 25, 1e-3, 10.0


@dataclass(frozen=True)
class Reliability:
    """Chance that a detection is right, by class: logistic in the logit of its score and in its distance, (classes,
    3)."""

    weights: Doubles

    @classmethod
    def of(cls, judged: Sequence[Judged], frames: Flags) -> Self:
        """Fit the chances on those of the frames (f,) that are chosen."""
        known, right, kinds = [], [], []
        for truth, found in judged:
            truth, found = truth.where(frames[truth.frame]), found.where(frames[found.frame])
            for number in range(len(CLASSES)):
                mine = found.cls == number
                known.append(_known(found)[mine])
                right.append(right_detections(truth, found, number, RIGHT_M)[mine])
                kinds.append(np.full(int(mine.sum()), number))
        every, is_right, kind = np.concatenate(known), np.concatenate(right), np.concatenate(kinds)
        return cls(np.stack([_logistic(every[kind == k], is_right[kind == k]) for k in range(len(CLASSES))]))

    def chances(self, found: Detections) -> Doubles:
        """Return the chances of detections, (m,)."""
        return _chance((_known(found) * self.weights[found.cls]).sum(axis=1))


def _known(found: Detections) -> Doubles:
    score = np.clip(found.score, 1e-6, 1.0 - 1e-6)
    away = np.hypot(*found.centre_m.T) / _UNIT_M
    return np.stack([np.ones(len(score)), np.log(score / (1.0 - score)), away], axis=1)


def _chance(logit: Doubles) -> Doubles:
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(logit, -30.0, 30.0))))


def _logistic(known: Doubles, right: Flags) -> Doubles:
    """Return the weights (3,) of a logistic regression, by Newton's method with a slight pull towards 0."""
    weights = np.zeros(known.shape[1])
    for _ in range(_STEPS):
        chance = _chance(known @ weights)
        slope = known.T @ (right - chance) - _RIDGE * weights
        bend = (known * (chance * (1.0 - chance))[:, None]).T @ known + _RIDGE * np.eye(len(weights))
        weights = weights + np.linalg.solve(bend, slope)
    return weights


def reliable(judged: Sequence[Judged], half: Flags) -> list[Detections]:
    """Return the detections with chances as scores; frames (f,) of one `half` by what the other teaches."""
    taught = {side: Reliability.of(judged, half != side) for side in (True, False)}
    found = []
    for _, one in judged:
        score = np.where(half[one.frame], taught[True].chances(one), taught[False].chances(one))
        found.append(one._replace(score=score))
    return found


def fused(lidars: Detections, cameras: Detections) -> Detections:
    """Return the detections of both, whose scores are chances: where they meet, at the place by LiDARs with the chance
    that one of them is right."""
    score, alone = lidars.score.copy(), np.ones(len(cameras.score), np.bool_)
    theirs = _groups(lidars)
    for key, mine in _groups(cameras).items():
        places = theirs.get(key)
        if places is None:
            continue
        apart = np.linalg.norm(cameras.centre_m[mine][:, None] - lidars.centre_m[places], axis=-1)
        reach = MEETING_M + MEETING_SHARE * np.hypot(*cameras.centre_m[mine].T)
        free = np.ones(len(places), np.bool_)
        for row in np.argsort(-cameras.score[mine], kind="stable").tolist():
            distance = np.where(free, apart[row], np.inf)
            nearest = int(distance.argmin())
            if distance[nearest] < reach[row]:
                free[nearest], alone[mine[row]] = False, False
                place = places[nearest]
                score[place] = 1.0 - (1.0 - score[place]) * (1.0 - cameras.score[mine[row]])
    more = cameras.where(alone)
    return Detections.joined([lidars._replace(score=score), more])


def _groups(found: Detections) -> dict[int, NDArray[np.int64]]:
    """Return the places of detections by frame and class."""
    key = found.frame * len(CLASSES) + found.cls
    order = np.argsort(key, kind="stable")
    values, starts = np.unique(key[order], return_index=True)
    return dict(zip(values.tolist(), np.split(order, starts[1:]), strict=True)) if len(order) else {}
