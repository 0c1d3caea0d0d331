"""Recall of a detector of one's own by points and class: its detections in nuScenes' format, joined to boxes."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.detect.precision import Detections, Truth, found_objects
from riglens.core.errors import InputError
from riglens.core.files import open_regular
from riglens.core.geometry import Vec3
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.readers.classes import ANY_TABLE, NUSCENES, UNMAPPED, ClassTable
from riglens.core.scene.readers.nuscenes_tables import NuscenesTables, tables_folder
from riglens.core.shown_text import visible
from riglens.core.study.curves import FoundByCameras, FoundObjects
from riglens.core.study.true_points import true_points
from riglens.core.targets.calibration import MATCH_M, MIN_SCORE, Calibration, Curve, Curves, Domain
from riglens.core.targets.traffic import Traffic

Doubles = NDArray[np.float64]
Counts = NDArray[np.int64]

MAX_BYTES = 1 << 30
LARGEST = 1e9
"""Coordinates and point counts are smaller: an integer in JSON may be too large for a double or for 64 bits."""
FEWEST, BLOCKS = 30, 5
"""Classes with fewer objects get no curve; a recording of one sequence is cut into this many runs of frames."""
NO_CLASS = ("barrier", "traffic_cone")
"""Classes that nuScenes detects and that are not objects of the traffic."""
_FIELDS = "sample_token, translation, detection_name and detection_score"


@dataclass(frozen=True)
class Rules:
    """Rules of a match; raise InputError for numbers out of their limits."""

    min_score: float = MIN_SCORE
    match_m: float = MATCH_M

    def __post_init__(self) -> None:
        if not math.isfinite(self.min_score):
            raise InputError(f"must be a finite number (got {self.min_score})", "min_score")
        if not 0.0 < self.match_m <= 4.0:
            raise InputError(f"must be above 0 and at most 4 m (got {self.match_m:g})", "match_m")


@dataclass(frozen=True)
class Frames:
    """Frames of a data set by the token of results, and the pose that takes their positions into the vehicle frame:
    rotation (T, 3, 3) and place_m (T, 3) of the boxes' frame in the results' frame, origin_m of the boxes' frame."""

    number: Mapping[str, int]
    rotation: Doubles
    place_m: Doubles
    origin_m: Vec3

    def in_vehicle(self, frame: Counts, position_m: Doubles) -> Doubles:
        """Return positions (m, 3) of results in the vehicle frame."""
        offset = position_m - self.place_m[frame]
        return np.asarray(np.einsum("nji,nj->ni", self.rotation[frame], offset) + np.array(self.origin_m))


def frames_of(boxes: Path, traffic: Traffic, origin_m: Vec3) -> Frames:
    """Return the frames of a nuScenes folder by the tokens of its samples, whose results are in the global frame, or
    those of a table by SEQ/FRAME, whose results are in the frame of its boxes."""
    folder = tables_folder(boxes) if boxes.is_dir() else None
    if folder is not None:
        samples = NuscenesTables(folder).samples(lambda _: None)
        return Frames(samples.number, samples.rotation, samples.place_m, origin_m)
    labels = traffic.data.labels
    if labels is None:
        raise InputError(f"{boxes}: must name its frames in columns seq and frame, or be a nuScenes folder")
    count = len(labels.sequence)
    number = {"/".join(map(str, labels.of(frame))): frame for frame in range(count)}
    return Frames(number, np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3)), origin_m)


def points_of(boxes: Path, overrides: Mapping[str, str]) -> Counts:
    """Return the true points of every box that belongs to a class, in the order of the box reader.

    Raise InputError where the boxes have none."""
    folder = tables_folder(boxes) if boxes.is_dir() else None
    if folder is None:
        return true_points(boxes, overrides)
    tables = NuscenesTables(folder)
    number = tables.samples(lambda _: None).number
    names = tables.category_of_instance(lambda _: None)
    codes = dict(zip(names, ClassTable(NUSCENES, overrides).codes(names.values()), strict=True))
    table, frames, points = tables.table("sample_annotation"), list[int](), list[int]()
    for record in table.records(lambda _: None):
        if table.found(record, "instance_token", codes) == UNMAPPED:
            continue
        found = record.fields.get("num_lidar_pts")
        if type(found) is not int or not 0 <= found < LARGEST:
            raise table.fail(record, "num_lidar_pts", "a number of points from 0 up")
        frames.append(table.found(record, "sample_token", number))
        points.append(found)
    return np.array(points, np.int64)[np.argsort(frames, kind="stable")]


def read_detections(path: Path, frames: Frames, overrides: Mapping[str, str]) -> Detections:
    """Read a result file of nuScenes' detection task, positions into the vehicle frame.

    Raise InputError for anything else, for classes that belong to none of ours and for samples that the boxes lack.
    """
    results = _results(path)
    table = ClassTable({**ANY_TABLE, **dict.fromkeys(NO_CLASS, "ignore")}, overrides)
    rows: list[tuple[int, str, list[float], float]] = []
    for token, boxes in results.items():
        if token not in frames.number:
            raise InputError(f"{path}: sample '{_short(token)}' is not in the boxes")
        if not isinstance(boxes, list):
            raise InputError(f"{path}: results: '{_short(token)}' must be a list of detections")
        rows += [_row(path, token, place, box, frames.number[token]) for place, box in enumerate(boxes)]
    known = {**table.effective(), **dict.fromkeys(NO_CLASS, "")}
    for name in sorted({row[1].strip().lower() for row in rows} - known.keys()):
        if name not in overrides:
            raise InputError(f"{path}: class '{_short(name)}' is unknown; map it", "classes")
    if not rows:
        raise InputError(f"{path}: must hold at least one detection")
    code = np.array(table.codes([row[1] for row in rows]))
    mine = np.flatnonzero(code != UNMAPPED)
    frame = np.array([row[0] for row in rows], np.int64)[mine]
    place_m = frames.in_vehicle(frame, np.array([row[2] for row in rows])[mine])
    score = np.array([row[3] for row in rows])[mine]
    return Detections(frame, code[mine].astype(np.uint8), place_m[:, :2], score)


def _results(path: Path) -> dict[str, Any]:
    try:
        with open_regular(path, "detections in nuScenes' result format") as file:
            content = file.read(MAX_BYTES + 1)
        if len(content) > MAX_BYTES:
            raise InputError(f"{path}: must be at most {MAX_BYTES >> 20} MiB")
        document = json.loads(content)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: must be JSON ({error})") from error
    results = document.get("results") if isinstance(document, dict) else None
    if not isinstance(results, dict):
        raise InputError(f"{path}: must be a nuScenes result file, with 'results' by sample token")
    return results


def _row(path: Path, token: str, place: int, box: object, frame: int) -> tuple[int, str, list[float], float]:
    where = f"{path}: results: '{_short(token)}' [{place}]"
    if not isinstance(box, dict):
        raise InputError(f"{where}: must be a detection with {_FIELDS}")
    try:
        name, position, score = box["detection_name"], box["translation"], box["detection_score"]
    except KeyError as error:
        raise InputError(f"{where}: {error.args[0]} is missing (needed: {_FIELDS})") from error
    numbers = [*position, score] if isinstance(position, list) else []
    if len(numbers) != 4 or not all(type(n) in (int, float) and abs(n) < LARGEST for n in numbers):
        raise InputError(
            f"{where}: translation must be three finite numbers below 1e9 m, detection_score one"
        )
    if not isinstance(name, str):
        raise InputError(f"{where}: detection_name must be text")
    return frame, name, [float(n) for n in position], float(score)


def _short(text: object) -> str:
    return visible(str(text)[:60])


def recall(
    traffic: Traffic, points: Counts, found: Detections, rules: Rules, name: str, source: str
) -> Calibration:
    """Fit recall by points (n,), one of each box in the order of the data, over the objects that count.

    Raise InputError where no class has enough objects, or where nothing is found.
    """
    box = np.flatnonzero(traffic.counts)
    frame = traffic.frame[traffic.frame_of_box[box]]
    truth = Truth(frame, traffic.cls[box], traffic.centre_m[box, :2], points[traffic.row[box]])
    kept = found.where(found.score >= rules.min_score)
    group = _groups(traffic)[frame]
    curves: dict[str, Curve] = {}
    for number, class_name in enumerate(CLASSES):
        mine = np.flatnonzero(truth.cls == number)
        if len(mine) < FEWEST:
            continue
        hit = found_objects(truth, kept, number, rules.match_m)[mine]
        n, column = np.unique(truth.points[mine], return_inverse=True)
        objects = np.zeros((int(group.max()) + 1, len(n)))
        hits = np.zeros_like(objects)
        np.add.at(objects, (group[mine], column), 1.0)
        np.add.at(hits, (group[mine], column), hit)
        if hit.any():
            curves[class_name] = FoundObjects(n.astype(np.float64), objects, hits).fitted()
    if not curves:
        raise InputError(
            f"{source}: finds no object of a class with {FEWEST} or more objects within {traffic.within_m:g} m; "
            "are scores, frames and positions those of the boxes?"
        )
    errors = [curve.error for curve in curves.values()]
    return Calibration(
        name=name,
        predicts="recall",
        unit="points",
        detector=f"{name}, detections of score {rules.min_score:g} or more within {rules.match_m:g} m",
        source=source,
        domain=Domain(within_m=traffic.within_m, data=traffic.data.short_source),
        classes=Curves(**curves),
        mean_error=float(np.sqrt(np.mean(np.square(errors)) / len(errors))),
    )


def with_cameras(
    calibration: Calibration, traffic: Traffic, visible: Doubles, found: Detections, rules: Rules, source: str
) -> Calibration:
    """Add what cameras find to the curves of LiDARs: visible (k,) shares of the objects that count, and detections made
    of pictures alone.

    Raise InputError where they find no object of a class with a curve.
    """
    box = np.flatnonzero(traffic.counts)
    cls = traffic.cls[box]
    truth = Truth(
        traffic.frame[traffic.frame_of_box[box]], cls, traffic.centre_m[box, :2], np.zeros(len(box), np.int64)
    )
    kept, hit, most = (
        found.where(found.score >= rules.min_score),
        np.zeros(len(box), np.bool_),
        np.zeros(len(box)),
    )
    for number, class_name in enumerate(CLASSES):
        curve, mine = calibration.classes.of(class_name), cls == number
        if curve is not None:
            most[mine] = curve.a
            hit[mine] = found_objects(truth, kept, number, rules.match_m)[mine]
    shown = (most > 0.0) & (visible > 0.0)
    if not hit[shown].any():
        raise InputError(
            f"{source}: finds no object that the rig's cameras show; are they those of the results?"
        )
    objects = FoundByCameras(visible[shown], traffic.distance_m[box][shown], most[shown], hit[shown])
    return calibration.model_copy(update={"camera": objects.fitted()})


def _groups(traffic: Traffic) -> Counts:
    """Return the group of each frame of the data: its sequence, or a run of frames where there is one sequence."""
    labels = traffic.data.labels
    if labels is not None and len(np.unique(labels.sequence)) > 1:
        return labels.sequence
    count = int(traffic.frame.max(initial=0)) + 1
    return np.arange(count) * BLOCKS // count
