"""Compute a camera's picture of one frame: boxes, ground, horizon, ROI and the car's own body, in native pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Camera
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.grid import VoxelGrid
from riglens.core.vehicle.solid import Solid
from riglens.core.view.frames import FrameBoxes
from riglens.core.view.hits import BODY, cast
from riglens.core.view.projection import Points, Projection

GRID_STEP_M = 5.0
_FAR_M = 1e4
_HORIZON_STEPS = 180
_MASK_WIDTH = 480
_LIGHT = np.array([0.35, 0.45, 0.82])
_CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
_FACES = np.array([[4, 6, 7, 5], [0, 1, 3, 2], [2, 3, 7, 6], [0, 4, 5, 1], [1, 5, 7, 3], [0, 2, 6, 4]])
_NORMALS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], np.float64)
_EDGES = np.array([[a, b] for a in range(8) for b in range(a + 1, 8) if bin(a ^ b).count("1") == 1])


@dataclass(frozen=True)
class Face:
    """A side of a box in the picture: corners_px (k, 2), the box's number in the frame, light 0 to 1."""

    corners_px: Points
    box: int
    cls: int
    range_m: float
    light: float


@dataclass(frozen=True)
class CameraPicture:
    """Picture in native pixels (x right, y down), in the order of drawing.

    ground_px (k, 2), empty when none is in view; lines are (m, 2) each; `faces` go from far to near; body
    (rows, columns) uint8 over the whole image: 0 where the car's own body is not, else how light it is; 1, the darkest,
    also where the view is blocked;
    boxes_seen: how many boxes of each class are not wholly hidden by nearer ones or by the body.
    """

    camera: Camera
    ground_px: Points
    grid_px: list[Points]
    horizon_px: list[Points]
    roi_px: list[Points]
    faces: tuple[Face, ...]
    body: NDArray[np.uint8]
    boxes_seen: dict[str, int]

    @property
    def body_share(self) -> float:
        """Share of the image that the car's own body covers, or a blocked sector."""
        return float(np.count_nonzero(self.body) / self.body.size)

    def face_at(self, x_px: float, y_px: float) -> Face | None:
        """Return the nearest side of a box at a pixel."""
        point = np.array([x_px, y_px])
        return next((face for face in reversed(self.faces) if _holds(face.corners_px, point)), None)


def camera_picture(camera: Camera, grid: VoxelGrid, boxes: FrameBoxes, body: Solid) -> CameraPicture:
    """Return the picture of a camera for the boxes of one frame and the car's own body."""
    view = Projection(camera)
    ground = _ground_m()[None] if camera.position[2] > 0.0 else np.zeros((0, 4, 3))
    low = np.array(grid.origin_m)
    roi_m = low + (_CORNERS + 1.0) / 2.0 * np.array(grid.roi_m)
    return CameraPicture(
        camera,
        next(iter(view.polygons(ground)), np.zeros((0, 2))),
        view.lines(*_grid_lines_m(grid)),
        view.lines(*_horizon_m(camera)),
        view.lines(roi_m[_EDGES[:, 0]], roi_m[_EDGES[:, 1]]),
        _faces(view, boxes),
        *_first_hits(view, boxes, body),
    )


def _ground_m() -> Points:
    return np.array([[1, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0]], np.float64) * _FAR_M


def _grid_lines_m(grid: VoxelGrid) -> tuple[Points, Points]:
    """Return lines on the ground every GRID_STEP_M metres of x and of y, within the ROI."""
    half_x, half_y = grid.roi_m[0] / 2, grid.roi_m[1] / 2
    x, y = _steps(half_x), _steps(half_y)
    starts = [*((at, -half_y, 0.0) for at in x), *((-half_x, at, 0.0) for at in y)]
    ends = [*((at, half_y, 0.0) for at in x), *((half_x, at, 0.0) for at in y)]
    return np.array(starts), np.array(ends)


def _steps(half_m: float) -> Points:
    """Return whole steps within the ROI; wider ones where there would be more than a hundred."""
    step_m = GRID_STEP_M
    while half_m / step_m > 50:
        step_m *= 2
    count = int(half_m / step_m)
    return np.arange(-count, count + 1, dtype=np.float64) * step_m


def _horizon_m(camera: Camera) -> tuple[Points, Points]:
    """Return a far circle at the camera's height."""
    angle = np.linspace(0.0, 2.0 * np.pi, _HORIZON_STEPS + 1)
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1) * _FAR_M
    circle += np.array(camera.position)
    return circle[:-1], circle[1:]


def _faces(view: Projection, boxes: FrameBoxes) -> tuple[Face, ...]:
    """Return the faces towards the camera, of far boxes first."""
    eye = np.array(view.camera.position)
    half = boxes.size_m / 2
    local_eye = np.einsum("nji,nj->ni", boxes.rotation, eye - boxes.centre_m)
    range_m = np.linalg.norm(local_eye - np.clip(local_eye, -half, half), axis=1)
    corners = boxes.centre_m[:, None] + np.einsum("nij,nkj->nki", boxes.rotation, _CORNERS * half[:, None])
    beyond = local_eye @ _NORMALS.T - np.abs(half @ np.abs(_NORMALS).T)
    order = np.argsort(-range_m, kind="stable")
    pairs = [(int(box), side) for box in order for side in range(6) if beyond[box, side] > 0.0]
    if not pairs:
        return ()
    box, side = np.array(pairs).T
    outlines = view.polygons(corners[box[:, None], _FACES[side]])
    light = np.abs(np.einsum("nij,nj->ni", boxes.rotation[box], _NORMALS[side]) @ _LIGHT)
    return tuple(
        Face(outline, int(n), int(boxes.cls[n]), float(range_m[n]), float(bright))
        for outline, n, bright in zip(outlines, box, light, strict=True)
        if len(outline) >= 3
    )


def _first_hits(view: Projection, boxes: FrameBoxes, body: Solid) -> tuple[NDArray[np.uint8], dict[str, int]]:
    """Return the first hits of a coarse lattice of rays over the image: the mask of the body, and the boxes seen."""
    width, height = view.camera.image
    columns = min(width, _MASK_WIDTH)
    rows = max(1, min(height, round(columns * height / width), _MASK_WIDTH * 2))
    rays = view.directions(columns, rows)
    from riglens.core.sensing.body_ends import barrier_of  # loads the compiler: not while a window opens

    barrier = barrier_of(view.camera, body)
    is_blocked = view.camera.blocked_rays(rays @ view.camera.pose.rotation())
    rays[is_blocked] = 0.0
    hits = cast(view.camera.position, rays, boxes, barrier, (0.0, np.inf), has_ground=False)
    mask = np.where(hits.what == BODY, 1.0 + 254.0 * hits.facing, 0.0)
    mask[is_blocked] = 1.0
    seen = boxes.cls[np.unique(hits.what[hits.what >= 0])]
    counts = {name: int(np.count_nonzero(seen == number)) for number, name in enumerate(CLASSES)}
    return mask.astype(np.uint8).reshape(rows, columns), counts


def _holds(corners_px: Points, point: Points) -> bool:
    """Return whether a polygon holds a point: a line to its right crosses the outline an odd number of times."""
    here, there = corners_px, np.roll(corners_px, -1, axis=0)
    crossed = (here[:, 1] <= point[1]) != (there[:, 1] <= point[1])
    here, there = here[crossed], there[crossed]
    share = (point[1] - here[:, 1]) / (there[:, 1] - here[:, 1])
    right = here[:, 0] + share * (there[:, 0] - here[:, 0]) > point[0]
    return bool(np.count_nonzero(right) % 2)
