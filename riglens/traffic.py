"""Traffic as single objects, and the points and pixels of a rig on them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Unpack

from numpy.typing import ArrayLike

from riglens.arguments import BoxReading, StrPath, reads_boxes, scene_options, warn, warn_of_data
from riglens.core.errors import InputError
from riglens.core.metric.scores import Body
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import Progress
from riglens.core.scene.survey import doubtful
from riglens.core.targets.calibration import MATCH_M, MIN_SCORE, Calibration
from riglens.core.targets.calibration import WITHIN_M as CALIBRATED_WITHIN_M
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import Phase, TargetSettings
from riglens.core.targets.shapes import Shape
from riglens.core.targets.traffic import WITHIN_M
from riglens.core.targets.traffic import Traffic as Boxes
from riglens.evaluation.names import argument_with
from riglens.evaluation.options import ScoreOptions
from riglens.evaluation.traffic import load_traffic as load_boxes
from riglens.results import TargetResult
from riglens.scenes import ForManyRigs, with_blocking_mesh


class Traffic(Boxes):
    """Objects of all frames of a data set, made by `load_traffic`: arrays with an entry per box, never changed.

    `cls`, `centre_m`, `size_m`, `rotation`, `distance_m` and `counts` (whether it is near enough to count) of each box;
    `frame_of_box` its frame, in the order in which frames are sampled. `within(m)` counts to another distance,
    `part(range(200))` holds some frames alone.
    """

    def __repr__(self) -> str:
        return f"<Traffic of {self.data.short_source}: {self.frames:,} frames, {int(self.counts.sum()):,} objects>"

    def part(self, frames: range) -> Traffic:
        """Return some frames by themselves, a range of the order in which frames are sampled."""
        if frames.step != 1 or not 0 <= frames.start < frames.stop <= self.frames:
            raise InputError(f"must be a range of step 1 within 0 to {self.frames} (got {frames})", "frames")
        starts = self.starts[frames.start : frames.stop + 1]
        boxes = slice(int(starts[0]), int(starts[-1]))
        columns = {one: getattr(self, one)[boxes] for one in ("row", "cls", "centre_m", "size_m", "rotation")}
        return replace(
            self, frame=self.frame[frames.start : frames.stop], starts=starts - starts[0], **columns
        )

    def engine(self, threads: int | None = None) -> TrafficEngine:
        """Return an engine for many rigs, which casts only what changes from one to the next; use it in a `with`."""
        return TrafficEngine(self, threads)


@reads_boxes
def load_traffic(
    boxes: StrPath | None = None,
    *,
    within_m: float = WITHIN_M,
    surroundings: bool = False,
    occluders: tuple[StrPath, StrPath] | None = None,
    progress: Progress | None = None,
    **read_as: Unpack[BoxReading],
) -> Traffic:
    """Load the objects of a box data set, or of the bundled town, to count on with `targets`.

    The other arguments are those of `load_scene`. Boxes that do not count are reported as a `RigLensWarning`. Raises
    InputError on bad data.

    Parameters
    ----------
    within_m
        Count objects within this distance of the car; farther ones still occlude.
    surroundings
        Houses, walls and poles of the bundled town hide objects too.
    occluders
        Tables of what surrounds your own boxes, and of the poses of the car.
    """
    options = scene_options(boxes, surroundings=surroundings, occluders=occluders, **read_as)
    found = load_boxes(options, within_m, progress)
    warn_of_data(found.data)
    return Traffic(**{one.name: getattr(found, one.name) for one in fields(found)})


class TrafficEngine(ForManyRigs):
    """Engine that counts rigs one after the other and casts only the sensors that changed; the counts are those of
    `targets`.

    Made by `traffic.engine()`, for one thread. It holds what each sensor hits until the `with` block ends.
    """

    def __init__(self, traffic: Boxes, threads: int | None = None) -> None:
        ScoreOptions(threads=threads)
        self._engine: TargetEngine | None = TargetEngine(traffic, threads)

    def evaluate(
        self,
        rig: Rig,
        *,
        shape: Shape = "class",
        range_law: bool = True,
        phase: Phase = "random",
        seed: int = 0,
        min_points: int = 5,
        sample: int | range | None = None,
        body: Body | None = None,
        mesh_folder: StrPath = ".",
        calibration: Calibration | None = None,
    ) -> TargetResult:
        """Count for a rig; arguments as for `targets`. Raises RuntimeError after the `with` block."""
        if self._engine is None:
            raise RuntimeError("this engine was closed at the end of its with block")
        if isinstance(sample, int) and sample < 1:
            raise InputError(f"must be an integer ≥ 1 (got {sample})", "sample")
        body = ScoreOptions(body=body).body_of(rig)
        settings = TargetSettings(shape, range_law, phase, seed, min_points, body, calibration)
        found = self._engine.evaluate(with_blocking_mesh(rig, body, mesh_folder), settings, sample)
        return TargetResult(found)


def targets(
    rig: Rig,
    traffic: Boxes,
    *,
    shape: Shape = "class",
    range_law: bool = True,
    phase: Phase = "random",
    seed: int = 0,
    min_points: int = 5,
    sample: int | range | None = None,
    threads: int | None = None,
    body: Body | None = None,
    mesh_folder: StrPath = ".",
    calibration: Calibration | None = None,
) -> TargetResult:
    """Count the points and pixels of a rig on objects, with occlusion by traffic.

    The other arguments are those of `score`. Raises InputError when a number is out of its range, or when the mesh of a
    body that blocks cannot be read.

    Parameters
    ----------
    rig, traffic
        The rig to count for, and the objects: made by `load_traffic`. For many rigs use `traffic.engine()`.
    shape
        "class": cars have glass and a gap below, cyclists and pedestrians are slim; "box": plain boxes.
    range_law
        Whether LiDAR returns from far or oblique surfaces may get lost.
    phase, seed
        "random" turns each LiDAR in each frame by a part of its azimuth step, drawn by the seed; "0" does not.
    min_points
        LiDAR points that detect an object.
    sample
        Number of frames to use, drawn fairly, or a range of them: `range(100, 1100)` are held out from `100`.
    calibration
        Calibration of predicted detection, made by `calibrate`; the bundled one by default.
    """
    with TrafficEngine(traffic, threads) as engine:
        return engine.evaluate(
            rig, shape=shape, range_law=range_law, phase=phase, seed=seed, min_points=min_points, sample=sample,
            body=body, mesh_folder=mesh_folder, calibration=calibration,
        )  # fmt: skip


def calibrate(
    detections: StrPath,
    boxes: StrPath,
    *,
    within_m: float = CALIBRATED_WITHIN_M,
    origin_m: ArrayLike | None = None,
    classes: Mapping[str, str] | None = None,
    min_score: float = MIN_SCORE,
    match_m: float = MATCH_M,
    name: str | None = None,
    rig: Rig | None = None,
    camera_results: StrPath | None = None,
) -> Calibration:
    """Fit a detector's recall by points and class, as `riglens calibrate` does; the result has `text()` for a file.

    Raises InputError on bad data.

    Parameters
    ----------
    detections, boxes
        Results of nuScenes' detection task, and the boxes with the points on each: a nuScenes folder, or a table with
        the column num_lidar_pts.
    within_m, origin_m, classes
        As in `load_traffic`.
    min_score, match_m
        Lowest score of a detection that counts, and the distance on the ground within which it finds an object.
    name
        Name of the detector.
    rig
        Count the points that RigLens predicts for this rig, instead of true ones.
    camera_results
        Results of a detector of this rig's pictures alone: fits what cameras add.
    """
    from riglens.core.study.calibrating import Rules
    from riglens.evaluation.calibrating import calibrated  # loads scipy's optimisers

    options = scene_options(boxes, origin_m=origin_m, classes=classes)
    traffic = load_boxes(options, within_m)
    for line in doubtful(traffic.data, argument_with):
        warn(line)
    alone = None if camera_results is None else Path(camera_results)
    return calibrated(Path(detections), options, traffic, Rules(min_score, match_m), name, rig, alone)
