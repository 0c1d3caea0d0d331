"""Predicted detection from the published study: curves by class, and their errors on rigs left out of the fit."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.curves import FoundObjects, MeansOfRigs
from riglens.core.study.detection.protocol import Protocol, entrants, split
from riglens.core.study.detection.published import FOUR_16_RAYS
from riglens.core.study.detection.recall import WITHIN_M
from riglens.core.study.ranks import spearman
from riglens.core.targets.calibration import (
    MATCH_M,
    MIN_RECALL,
    MIN_SCORE,
    MOST,
    Calibration,
    CameraCurve,
    Curve,
    Curves,
    Domain,
    Unit,
)
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.traffic import Traffic

Doubles = NDArray[np.float64]
Counts = NDArray[np.int64]

GOAL_ERROR, GOAL_RANK = 0.015, 0.98
"""Set before the fit: root mean square error of predicted mAP of rigs left out at most so large, their rank correlation
with measured mAP at least so high."""
UNITS: tuple[Unit, ...] = ("cells", "points")
DETECTOR = "pillars of 0.25 m and a U-Net of 0.15 M weights, one sweep, shared by 30 rigs, five seeds"
SOURCE = (
    "curves: detection study of published rigs, 0.1 + 0.9 AP over all objects, docs/data/detection.csv; cameras: "
    "published ratios of average precision with and without cameras, docs/study-external.md"
)
CAMERA = CameraCurve(s=1.5, d0_m=15.0)
"""Fitted to published ratios of detectors with pictures alone and with points, and frozen: pairs of d0 and s on a
ridge, (8, 3.5), (12, 1.8) and (30, 0.8), do as well."""
DATA = "simulated sweeps of the bundled town"
BEYOND = "eight rigs of 230,400 to 960,512 rays were ranked right, but 3.1 points of mAP too low"
"""Of docs/study-detection-3.md, whose limit was 3 points."""
CAMERAS_ALONE = "eight sets of cameras were ranked right, but 8.6 points of mAP too high"
"""Of the same study, whose small picture net finds half of what published ones do."""
RECALL_DETECTOR = (
    "pillars of 0.25 m and a U-Net of 0.15 M weights, one sweep, shared by 23 rigs of real models, "
    f"detections of score {MIN_SCORE:g} or more within {MATCH_M:g} m"
)
RECALL_SOURCE = "second detection study, part one-sweep: docs/data/detection2-recall-points.csv"
RECALL_DATA = f"{DATA}, with houses and the car's solid body"


def objects_by_number(
    rigs: Sequence[Rig], traffic: Traffic, protocol: Protocol, tell: Callable[[float], None]
) -> dict[Unit, Counts]:
    """Count, for each rig, how many objects of the test frames have 0 to MOST cells and points: by unit
    (rigs, classes, MOST + 1). Objects in the region of average precision alone."""
    frames = split(traffic.data, protocol).test
    test = traffic.frames_alone(np.argsort(traffic.frame)[frames])
    found = {unit: np.zeros((len(rigs), len(CLASSES), MOST + 1), np.int64) for unit in UNITS}
    for place, entrant in enumerate(entrants(rigs)):
        objects = TargetEngine(test).evaluate(entrant.rig, protocol.simulation.targets()).objects
        inside = protocol.region.holds(test.centre_m[objects.box, :2])
        cls = test.cls[objects.box]
        for unit, n in zip(UNITS, (objects.cells, objects.all_points), strict=True):
            np.add.at(found[unit][place], (cls[inside], np.minimum(n[inside], MOST)), 1)
        tell((place + 1) / len(rigs))
    return found


def read_precision(path: Path, rigs: Sequence[Rig]) -> Doubles:
    """Read average precision, 0 to 1, (rigs, classes), from the table of `riglens study detection`."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            found = {(line["rig"], line["class"]): float(line["ap"]) / 100.0 for line in csv.DictReader(file)}
        return np.array([[found[rig.name, name] for name in CLASSES] for rig in rigs])
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except (KeyError, ValueError, TypeError, csv.Error) as error:
        raise InputError(
            f"{path}: must be the detection.csv of the detection study, with rig, class and ap"
        ) from error


@dataclass(frozen=True)
class Prediction:
    """AP of rigs, 0 to 1, (rigs, classes): observed, and predicted by the curves of all other rigs."""

    rigs: tuple[str, ...]
    rays: Counts
    observed: Doubles
    left_out: Doubles
    calibration: Calibration

    def errors(self) -> Doubles:
        """Return the root mean square errors of the classes and of their mean, (classes + 1,)."""
        misses = self.left_out - self.observed
        every = np.column_stack([misses, misses.mean(axis=1)])
        return np.asarray(np.sqrt(np.mean(every**2, axis=0)))

    def changes(self) -> tuple[Doubles, Doubles]:
        """Return the changes of mAP from one rig to another, of every pair of rigs: measured, and predicted."""
        i, j = np.triu_indices(len(self.rigs), 1)
        measured, predicted = (one.mean(axis=1) for one in (self.observed, self.left_out))
        return measured[j] - measured[i], predicted[j] - predicted[i]

    def rank(self, equal_rays: bool = False) -> float:
        """Return Spearman's coefficient of predicted and measured mAP, of all rigs or those of equal ray count."""
        chosen = self.rays == FOUR_16_RAYS if equal_rays else self.rays > 0
        return float(spearman(self.left_out.mean(axis=1)[chosen], self.observed.mean(axis=1)[chosen]))


def calibrate_rigs(
    rays: Mapping[str, int], objects: Counts, observed: Doubles, unit: Unit, protocol: Protocol
) -> Prediction:
    """Fit the curves of all classes to rigs, whose LiDAR rays are given by name.

    objects (rigs, classes, MOST + 1) have so many cells or points; observed (rigs, classes) average precision, 0 to 1,
    which leaves out recall up to MIN_RECALL: the curves are fitted to shares of objects found.
    """
    curves, left_out = {}, []
    for number, name in enumerate(CLASSES):
        n = np.flatnonzero(objects[:, number].any(axis=0))
        means = MeansOfRigs(
            n.astype(np.float64),
            objects[:, number, n].astype(np.float64),
            MIN_RECALL + (1.0 - MIN_RECALL) * observed[:, number],
        )
        curve, found = means.fitted()
        left_out.append(np.maximum(0.0, (found - MIN_RECALL) / (1.0 - MIN_RECALL)))
        error = float(np.sqrt(np.mean((left_out[-1] - observed[:, number]) ** 2)))
        curves[name] = curve.model_copy(update={"error": error})
    number_of_rays = np.array(list(rays.values()))
    region = protocol.region
    calibration = Calibration(
        name=f"study of {len(rays)} rigs",
        predicts="AP",
        unit=unit,
        detector=DETECTOR,
        source=SOURCE,
        domain=Domain(
            length_m=region.length_m,
            width_m=region.width_m,
            rays=(int(number_of_rays.min()), int(number_of_rays.max())),
            data=DATA,
            beyond=BEYOND,
            cameras_alone=CAMERAS_ALONE,
        ),
        camera=CAMERA,
        classes=Curves(**curves),
        mean_error=float(np.sqrt(np.mean((np.transpose(left_out) - observed).mean(axis=1) ** 2))),
    )
    return Prediction(tuple(rays), number_of_rays, observed, np.transpose(left_out), calibration)


def calibrate_recall(path: Path, rigs: Sequence[Rig], protocol: Protocol) -> Calibration:
    """Fit recall by points to the rigs of the second study, from its table of objects and found ones by rig and by
    sequence; the error of a class is that of rigs or of sequences left out, whichever is larger."""
    counted: dict[tuple[str, str], dict[str, dict[int, tuple[int, int]]]] = {}
    try:
        with path.open(newline="", encoding="utf-8") as file:
            for line in csv.DictReader(file):
                of = counted.setdefault((line["group"], line["cls"]), {}).setdefault(line["name"], {})
                of[int(line["points"])] = int(line["objects"]), int(line["found"])
        fitted = {
            name: [_recall_curve(list(counted[group, name].values())) for group in ("rig", "sequence")]
            for name in CLASSES
        }
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except (KeyError, ValueError, TypeError, csv.Error) as error:
        raise InputError(
            f"{path}: must be the detection-recall-points.csv of the detection study, with group, name, cls, points, "
            "objects and found"
        ) from error
    curves = {
        name: by_rig.model_copy(update={"error": max(by_rig.error, other.error)})
        for name, (by_rig, other) in fitted.items()
    }
    rays = [sum(lidar.ray_count for lidar in rig.enabled_lidars()) for rig in rigs]
    region = protocol.region
    return Calibration(
        name=f"second study, {len(rigs)} rigs",
        predicts="recall",
        unit="points",
        detector=RECALL_DETECTOR,
        source=RECALL_SOURCE,
        domain=Domain(
            within_m=WITHIN_M,
            length_m=region.length_m,
            width_m=region.width_m,
            rays=(min(rays), max(rays)),
            data=RECALL_DATA,
        ),
        classes=Curves(**curves),
        mean_error=float(np.linalg.norm([one.error for one in curves.values()]) / len(curves)),
    )


def _recall_curve(groups: Sequence[Mapping[int, tuple[int, int]]]) -> Curve:
    """Fit recall to objects and found ones by points, of each rig or sequence."""
    n = sorted({points for group in groups for points in group})
    table = np.array([[group.get(points, (0, 0)) for points in n] for group in groups], np.float64)
    return FoundObjects(np.array(n, np.float64), table[..., 0], table[..., 1]).fitted()
