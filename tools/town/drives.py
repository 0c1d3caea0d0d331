"""Drives through the bundled town: ego cars, the objects around them in each frame, and their poses.

Boxes are in the ego vehicle frame: x forward, y left, z up, origin on the ground under the centre of the ego's body.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from tools.town.streets import rng_for
from tools.town.traffic import Actor, Frame, Pose, Size

EGO_COUNT = 50
FRAMES_PER_EGO = 50
EGO_MIN_MEAN_SPEED_MPS = 4.0
EGO_MAX_STANDING_SHARE = 0.45
EGO_BODY = Size(4.60, 1.85, 1.52)

KEEP_M = 100.0
"""Boxes are kept while their centre is at most so far from the ego car's."""


def fixed(value: float, digits: int) -> str:
    """Fixed-point text without a negative zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


@dataclass(frozen=True)
class Box:
    """One row of the table; centre and size in metres, yaw in radians, ego vehicle frame."""

    kind: str
    x_m: float
    y_m: float
    size: Size
    yaw_rad: float

    def row(self, seq: int, frame: int) -> str:
        size = self.size
        metres = (self.x_m, self.y_m, size.height_m / 2, size.length_m, size.width_m, size.height_m)
        texts = [fixed(value, 3) for value in metres]
        return ",".join([str(seq), str(frame), self.kind, *texts, fixed(self.yaw_rad, 4)])


Place = tuple[float, float, float]
"""x, y in metres and the heading in radians, anticlockwise from east, of the ego vehicle frame in SUMO's map frame."""


@dataclass(frozen=True)
class Drive:
    """One ego car for FRAMES_PER_EGO frames: first frame of the simulation, id, and per frame its place and boxes."""

    first: int
    ego: str
    places: list[Place]
    boxes: list[list[Box]]


def _stay(car: str, frames: list[Frame]) -> tuple[int, list[Pose]]:
    """First frame index and poses of a car; a car enters and leaves the simulation once."""
    present = [k for k, frame in enumerate(frames) if car in frame]
    return present[0], [frames[k][car] for k in present]


def _drives_well(poses: list[Pose]) -> bool:
    """True for a drive that moves through town: red lights are fine, a jam is not."""
    speeds = [pose.speed_mps for pose in poses]
    standing = sum(speed < 0.3 for speed in speeds) / len(speeds)
    return sum(speeds) / len(speeds) >= EGO_MIN_MEAN_SPEED_MPS and standing <= EGO_MAX_STANDING_SHARE


def ego_candidates(frames: list[Frame], actors: dict[str, Actor]) -> list[tuple[int, str]]:
    """(first frame index, id) of a part of FRAMES_PER_EGO frames of each car that moves well in it."""
    seen = sorted({actor_id for frame in frames for actor_id in frame})
    cars = [i for i in seen if actors[i].kind == "car" and not i.startswith("parked")]
    candidates: list[tuple[int, str]] = []
    for car in cars:
        first, poses = _stay(car, frames)
        if len(poses) >= FRAMES_PER_EGO:
            skipped = rng_for("start", car).randrange(len(poses) - FRAMES_PER_EGO + 1)
            if _drives_well(poses[skipped : skipped + FRAMES_PER_EGO]):
                candidates.append((first + skipped, car))
    return candidates


def _centre(pose: Pose, size: Size) -> tuple[float, float]:
    """Map position of the body's centre: half a length behind the front."""
    half_m, heading_rad = size.length_m / 2, pose.heading_rad
    return pose.front_x_m - half_m * math.cos(heading_rad), pose.front_y_m - half_m * math.sin(heading_rad)


def box_in_ego_frame(actor: Actor, pose: Pose, ego: Actor, ego_pose: Pose) -> Box:
    """Turn a map pose into a box in the ego vehicle frame."""
    x, y = _centre(pose, actor.size)
    ego_x, ego_y = _centre(ego_pose, ego.size)
    dx, dy = x - ego_x, y - ego_y
    cos, sin = math.cos(ego_pose.heading_rad), math.sin(ego_pose.heading_rad)
    yaw_rad = math.remainder(pose.heading_rad - ego_pose.heading_rad, math.tau)
    return Box(actor.kind, cos * dx + sin * dy, cos * dy - sin * dx, actor.size, yaw_rad)


def boxes_around(ego_id: str, frame: Frame, actors: dict[str, Actor]) -> list[Box]:
    """Boxes of one frame near the ego car, without the ego car itself, ordered by id."""
    ego, ego_pose = actors[ego_id], frame[ego_id]
    others = [i for i in sorted(frame) if i != ego_id]
    boxes = [box_in_ego_frame(actors[i], frame[i], ego, ego_pose) for i in others]
    return [b for b in boxes if math.hypot(b.x_m, b.y_m) <= KEEP_M]


def _reach_m(box: Box, axis_rad: float) -> tuple[float, float]:
    """Interval that the box's footprint covers along a horizontal axis through the origin."""
    centre_m = box.x_m * math.cos(axis_rad) + box.y_m * math.sin(axis_rad)
    along, across = abs(math.cos(box.yaw_rad - axis_rad)), abs(math.sin(box.yaw_rad - axis_rad))
    half_m = (box.size.length_m * along + box.size.width_m * across) / 2
    return centre_m - half_m, centre_m + half_m


def touches_ego(box: Box) -> bool:
    """True when the footprints of the box and of EGO_BODY overlap (separating axes)."""
    ego = Box("car", 0.0, 0.0, EGO_BODY, 0.0)
    axes_rad = (0.0, math.pi / 2, box.yaw_rad, box.yaw_rad + math.pi / 2)
    reaches = [(_reach_m(box, axis), _reach_m(ego, axis)) for axis in axes_rad]
    return all(a[0] < b[1] and b[0] < a[1] for a, b in reaches)


def drives(frames: list[Frame], actors: dict[str, Actor]) -> list[Drive]:
    """Return EGO_COUNT drives drawn by SEED in which nothing runs into the ego car.

    (Now and then SUMO lets objects pass through each other at a crossing.)
    """
    candidates = ego_candidates(frames, actors)
    rng_for("egos").shuffle(candidates)
    found: list[Drive] = []
    for first, ego in candidates:
        seen = frames[first : first + FRAMES_PER_EGO]
        boxes = [boxes_around(ego, frame, actors) for frame in seen]
        if not any(touches_ego(box) for frame in boxes for box in frame):
            found.append(Drive(first, ego, [_place(frame[ego], actors[ego]) for frame in seen], boxes))
        if len(found) == EGO_COUNT:
            return sorted(found, key=lambda drive: (drive.first, drive.ego))
    raise SystemExit(f"only {len(found)} of {EGO_COUNT} ego drives found")


def _place(pose: Pose, ego: Actor) -> Place:
    return (*_centre(pose, ego.size), pose.heading_rad)
