"""Every kernel that the window may call, compiled step by step before it is needed.

Run as a process of its own, this module compiles the steps that it is given and that are not yet on disk, and ends;
the priority is the lowest there is. A finished step leaves a mark, so the next process goes on from there and the
window can show how many are ready.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import psutil

from riglens.core.blind.zones import BlindEngine, BlindSettings, by_names
from riglens.core.engine.audit import audit
from riglens.core.engine.engine import Engine
from riglens.core.engine.warm_up import (
    BENT,
    HALVES,
    ON_THE_CAR,
    WARM_UP,
    compile_beside,
    is_compiled,
    tiny_field,
    warm_up,
)
from riglens.core.figures.registry import voxel_heat_maps
from riglens.core.geometry import Pose
from riglens.core.metric.scores import BODIES, MetricSettings
from riglens.core.review.mounts import USUAL_LIMITS, violations
from riglens.core.review.profiles import bundled_profiles
from riglens.core.review.redundancy import target_coverage, voxel_coverage
from riglens.core.review.verdicts import ObjectVisibility
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES, DataReport
from riglens.core.targets.detection_range import RangePlan
from riglens.core.targets.detection_range_making import detection_range_of
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic, traffic_of
from riglens.core.vehicle.solid import solid_of
from riglens.core.view.camera_picture import camera_picture
from riglens.core.view.frame_scene import frame_scene, why_missed
from riglens.core.view.frames import FrameBoxes
from riglens.evaluation.kernel_steps import STEPS, first, is_done, mark_done
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.requests import EvaluationRequest
from riglens.evaluation.scoring import Scoring, load_scene

LOWEST_PRIORITY = 19
RIG = Rig(sensors=(*ON_THE_CAR.sensors, WARM_UP.sensors[1]))
"""Two LiDARs and a camera, close enough to the car that it stops some of their rays."""
MOVED = RIG.with_sensor(RIG.sensors[0].name, RIG.sensors[0].replace(position=(0.1, 0.0, 1.7)))


def _cast_rays() -> None:
    warm_up(tiny_field())


def _cast_bent_lenses() -> None:
    warm_up(tiny_field(), rig=Rig(sensors=(BENT,)), settings=MetricSettings(body="blocks"))


def _cast_dense_beams() -> None:
    lidar = sensor_from_model("hesai-ot128", "dense", Pose((0.0, 0.0, 2.0), (1.0, 2.0, 0.0)))
    engine = Engine(tiny_field(0.2))
    for body in BODIES:
        engine.evaluate(Rig(sensors=(lidar,)), MetricSettings(body=body))


def _draw_maps() -> None:
    scoring = Scoring(load_scene(SceneOptions(voxel_m=0.5), lambda _: None), None)
    for number, heat in enumerate(voxel_heat_maps()):
        for rig in (RIG, MOVED):
            request = EvaluationRequest(
                number, rig, RIG, MetricSettings(), heat.key, map_by=by_names()[0], blind=True
            )
            scoring.exact(request, lambda: False)


def _count_points() -> None:
    engine = TargetEngine(_traffic())
    for body in BODIES:
        engine.evaluate(RIG, TargetSettings(body=body))
        engine.evaluate(Rig(sensors=RIG.sensors[:2]), TargetSettings(body=body))


def _find_blind_zones() -> None:
    BlindEngine(RIG.vehicle, BlindSettings()).evaluate(RIG)


def _lose_sensors() -> None:
    field, traffic, settings = tiny_field(), _traffic(), TargetSettings()
    engine = Engine(field)
    engine.evaluate(RIG)
    voxel_coverage(engine, RIG)
    target_coverage(TargetEngine(traffic).evaluate(RIG, settings))


def _audit_rays() -> None:
    audit(Engine(tiny_field()), RIG)


def _find_ranges() -> None:
    plan = RangePlan(to_m=10.0)
    detection_range_of(RIG, plan, threads=1)


def _try_test_objects() -> None:
    visibility = ObjectVisibility(RIG, "blocks")
    for profile in bundled_profiles():
        visibility.verdict(profile)
    violations(RIG, USUAL_LIMITS)


def _show_a_frame() -> None:
    traffic, solid = _traffic(), solid_of(RIG.vehicle)
    boxes = FrameBoxes(traffic.cls, traffic.centre_m, traffic.size_m, traffic.rotation)
    frame_scene(RIG, 0, boxes, solid)
    why_missed(RIG, boxes, 1, solid, 5)
    camera_picture(RIG.enabled_cameras()[0], tiny_field().grid, boxes, solid)


def _traffic() -> Traffic:
    """Return two cars, one behind the other."""
    data = DataReport("tiny", 1, dict.fromkeys(CLASSES, 1))
    centre_m = np.array([[10.0, 0.0, 0.8], [20.0, 0.5, 0.8]])
    size_m = np.tile((4.6, 1.9, 1.6), (2, 1))
    return traffic_of(
        data, np.zeros(2, np.int64), np.zeros(2, np.uint8), centre_m, size_m, np.tile(np.eye(3), (2, 1, 1))
    )


FUNCTIONS: Mapping[str, Callable[[], None]] = {
    "rays": _cast_rays,
    "maps": _draw_maps,
    "points": _count_points,
    "beams": _cast_dense_beams,
    "lenses": _cast_bent_lenses,
    "blind": _find_blind_zones,
    "redundancy": _lose_sensors,
    "audit": _audit_rays,
    "range": _find_ranges,
    "objects": _try_test_objects,
    "frame": _show_a_frame,
}


def compile_steps(steps: Sequence[str]) -> None:
    """Run the steps that are not on disk yet."""
    for step in steps:
        if not is_done(step):
            FUNCTIONS[step]()
            mark_done(step)


def _main(arguments: list[str]) -> None:
    for half in HALVES:
        if first(half) in arguments and not is_compiled(half):
            compile_beside(half)
    psutil.Process().nice(getattr(psutil, "IDLE_PRIORITY_CLASS", LOWEST_PRIORITY))
    compile_steps([step for step in STEPS if step in arguments])


if __name__ == "__main__":
    _main(sys.argv[1:])
