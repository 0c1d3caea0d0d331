"""The Python interface, `import riglens as rl`: every command as a function, with the code of the command line.

Lengths are in metres, angles in degrees, entropies in nats. Coordinates are those of the vehicle frame: x forward,
y left, z up, origin on the ground under the centre of the body (ISO 8855). Lists, tuples and arrays are accepted
wherever a vector is meant. What a user can get wrong raises `InputError`, whose message is one line; a `Rig`, `Lidar`
or `Camera` with wrong values raises pydantic's `ValidationError`. Both are `ValueError`s.
"""

from __future__ import annotations

from riglens.arguments import RigLensWarning
from riglens.core.errors import InputError
from riglens.core.footprint.ground import Footprint
from riglens.core.geometry import Pose
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig, Vehicle
from riglens.core.targets.calibration import Calibration
from riglens.making import build_pog, report, simulate, survey, verify_report
from riglens.optimising import OptimiseResult, optimise
from riglens.pictures import Picture, render, show
from riglens.results import (
    AuditResult,
    BlindResult,
    CheckResult,
    ClassResult,
    FootprintResult,
    Listing,
    MountsResult,
    RangeResult,
    RedundancyResult,
    ReviewResult,
    RigResult,
    TargetResult,
    ToleranceResult,
)
from riglens.reviewing import (
    blind,
    check,
    detection_range,
    footprint,
    footprints,
    mounts,
    redundancy,
    review,
    tolerance,
)
from riglens.rigs import convert, open_rig, presets, save_rig, sensor, sensors, use_libraries
from riglens.scenes import Scene, SceneEngine, audit, body_triangles, load_scene, rays, score
from riglens.studying import study
from riglens.sweeping import SweepResult, sweep
from riglens.traffic import Traffic, TrafficEngine, calibrate, load_traffic, targets

__all__ = [
    "AuditResult",
    "BlindResult",
    "Calibration",
    "Camera",
    "CheckResult",
    "ClassResult",
    "Footprint",
    "FootprintResult",
    "InputError",
    "Lidar",
    "LinearAngles",
    "Listing",
    "MountsResult",
    "OptimiseResult",
    "Picture",
    "Pose",
    "RangeResult",
    "RedundancyResult",
    "ReviewResult",
    "Rig",
    "RigLensWarning",
    "RigResult",
    "Scene",
    "SceneEngine",
    "SweepResult",
    "TargetResult",
    "ToleranceResult",
    "Traffic",
    "TrafficEngine",
    "Vehicle",
    "audit",
    "blind",
    "body_triangles",
    "build_pog",
    "calibrate",
    "check",
    "convert",
    "detection_range",
    "footprint",
    "footprints",
    "load_scene",
    "load_traffic",
    "mounts",
    "open_rig",
    "optimise",
    "presets",
    "rays",
    "redundancy",
    "render",
    "report",
    "review",
    "save_rig",
    "score",
    "sensor",
    "sensors",
    "show",
    "simulate",
    "study",
    "survey",
    "sweep",
    "targets",
    "tolerance",
    "use_libraries",
    "verify_report",
]  # fmt: skip
