"""The orbiting camera as pure maths: views, pixel rays, projection, orbit, pan, zoom. No Qt, no VTK."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.rig.model import Camera
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensors.camera import field_of_view_deg

Points = NDArray[np.float64]
Size = tuple[int, int]
"""Width and height of a picture in pixels."""
Pixel = tuple[float, float]
"""Right and down from the upper left corner."""
VIEWS = ("iso", "top", "front", "left", "rear")
"""The views of a picture; the window has the right side, too."""
_DIRECTION_DEG = {
    "iso": (-149.0, 18.5),
    "top": (-90.0, 90.0),
    "front": (0.0, 0.0),
    "left": (90.0, 0.0),
    "rear": (180.0, 0.0),
    "right": (-90.0, 0.0),
}
_FIT_BOX = (np.array([0.02, 0.03]), np.array([0.98, 0.87]))
_FIRST_ASPECT = 1.6
_MIN_DISTANCE_M, _MAX_DISTANCE_M = 0.3, 2000.0


_LEVEL_DEG, _STEEP_DEG = 4.0, 18.0


@dataclass(frozen=True)
class ViewRay:
    """A half-line: origin (3,) in metres and unit direction (3,), vehicle frame."""

    origin_m: Points
    direction: Points


@dataclass(frozen=True)
class OrbitCamera:
    """Camera directed at `focal_m` from a distance; z stays up, even straight from above.

    Azimuth turns left from the car's front, elevation 90 is straight above. Lengths are true if `parallel`; turning the
    view ends that unless it is `orthographic` by choice.
    """

    focal_m: tuple[float, float, float] = (0.0, 0.0, 0.8)
    distance_m: float = 19.0
    azimuth_deg: float = -52.0
    elevation_deg: float = 24.0
    parallel: bool = False
    view_angle_deg: float = 30.0
    orthographic: bool = False

    def axes(self) -> tuple[Points, Points, Points]:
        """Return the unit vectors right, up and forward (into the picture), each (3,)."""
        azimuth, elevation = math.radians(self.azimuth_deg), math.radians(self.elevation_deg)
        ca, sa, ce, se = math.cos(azimuth), math.sin(azimuth), math.cos(elevation), math.sin(elevation)
        return (
            np.array([-sa, ca, 0.0]),
            np.array([-se * ca, -se * sa, ce]),
            np.array([-ce * ca, -ce * sa, -se]),
        )

    def position_m(self) -> Points:
        """Return the position of the camera, (3,) metres."""
        return np.asarray(np.array(self.focal_m) - self.distance_m * self.axes()[2])

    def half_height_m(self) -> float:
        """Return half the visible height at the focal point, metres; the parallel scale of a parallel view."""
        return self.distance_m * math.tan(math.radians(self.view_angle_deg) / 2)

    def metres_per_pixel(self, point_m: Points, size: Size) -> float:
        """Return the length of one pixel at the depth of a point, metres."""
        depth = self.distance_m
        if not self.parallel:
            depth = max(1e-3, float((np.asarray(point_m) - self.position_m()) @ self.axes()[2]))
        return depth * math.tan(math.radians(self.view_angle_deg) / 2) * 2.0 / max(1, size[1])

    def ray(self, pixel: Pixel, size: Size) -> ViewRay:
        """Return the view ray through a pixel; pixels count right and down from the upper left corner."""
        right, up, forward = self.axes()
        scale = self.half_height_m() * 2.0 / max(1, size[1])
        offset = (pixel[0] - size[0] / 2) * scale * right - (pixel[1] - size[1] / 2) * scale * up
        target = np.array(self.focal_m) + offset
        if self.parallel:
            return ViewRay(target - self.distance_m * forward, forward)
        direction = target - self.position_m()
        return ViewRay(self.position_m(), direction / np.linalg.norm(direction))

    def project(self, points_m: Points, size: Size) -> Points:
        """Return pixels and depth (n, 3) of points (n, 3): right, down, metres in front of the camera."""
        offset = np.atleast_2d(points_m) - self.position_m()
        right, up, forward = self.axes()
        depth = offset @ forward
        along = np.full_like(depth, self.distance_m) if self.parallel else np.maximum(depth, 1e-9)
        scale = size[1] / 2 / math.tan(math.radians(self.view_angle_deg) / 2) / along
        return np.stack(
            [size[0] / 2 + offset @ right * scale, size[1] / 2 - offset @ up * scale, depth], axis=1
        )

    @property
    def from_the_side(self) -> float:
        """Return how far objects in the ROI hide one another, from 0, seen steeply, to 1, seen level."""
        share = (_STEEP_DEG - abs(self.elevation_deg)) / (_STEEP_DEG - _LEVEL_DEG)
        return min(1.0, max(0.0, share))

    def orbited(self, dx_px: float, dy_px: float, size: Size) -> OrbitCamera:
        """Return the camera turned about the focal point by a mouse movement; a full window height is half a turn."""
        turn = 180.0 / max(1, size[1])
        elevation = min(90.0, max(-89.0, self.elevation_deg + dy_px * turn))
        azimuth = (self.azimuth_deg - dx_px * turn + 180.0) % 360.0 - 180.0
        return replace(self, azimuth_deg=azimuth, elevation_deg=elevation, parallel=self.orthographic)

    def projected(self, orthographic: bool) -> OrbitCamera:
        """Return the camera with parallel rays by choice, or with perspective."""
        return replace(self, orthographic=orthographic, parallel=orthographic)

    def panned(self, dx_px: float, dy_px: float, size: Size) -> OrbitCamera:
        """Return the camera moved sideways so that the focal plane follows the mouse."""
        right, up, _ = self.axes()
        scale = self.half_height_m() * 2.0 / max(1, size[1])
        focal = np.array(self.focal_m) - dx_px * scale * right + dy_px * scale * up
        return replace(self, focal_m=(float(focal[0]), float(focal[1]), float(focal[2])))

    def zoomed(self, factor: float, pixel: Pixel, size: Size) -> OrbitCamera:
        """Return the camera closer (factor < 1) or farther away; the point under the cursor stays fixed."""
        distance = min(_MAX_DISTANCE_M, max(_MIN_DISTANCE_M, self.distance_m * factor))
        kept = 1.0 - distance / self.distance_m
        dx_px, dy_px = (pixel[0] - size[0] / 2) * kept, (pixel[1] - size[1] / 2) * kept
        return replace(self.panned(-dx_px, -dy_px, size), distance_m=distance)


_AROUND_M = 5.0
WIDEST_M = 700.0
"""Points further apart are not framed together: from so far away a car is less than a pixel."""


def framed(camera: OrbitCamera, places_m: Points, size: Size) -> OrbitCamera:
    """Return the camera with points (n, 3) in the middle of a picture of this size; its direction stays.

    A single point is seen from 5 m.
    """
    low, high = places_m.min(axis=0), places_m.max(axis=0)
    middle = (low + high) / 2.0
    narrow = min(1.0, size[0] / max(1, size[1]))
    half_angle = math.atan(narrow * math.tan(math.radians(camera.view_angle_deg) / 2.0))
    distance = _AROUND_M + float(np.linalg.norm(high - low)) / 2.0 / math.sin(half_angle)
    focal = (float(middle[0]), float(middle[1]), float(middle[2]))
    return replace(camera, focal_m=focal, distance_m=min(distance, _MAX_DISTANCE_M))


def view_camera(
    name: str, grid: VoxelGrid, aspect: float, wide: bool = False, car_m: tuple[float, float] = (4.6, 1.45)
) -> OrbitCamera:
    """Return the camera of a named view; InputError for another name. `car_m` is length and height of the car.

    The iso view shows the car and its surroundings, or the whole ROI if `wide`; the top view the whole ROI;
    the side views the car with its sensors.
    """
    if name not in _DIRECTION_DEG:
        raise InputError(f"view must be {', '.join(_DIRECTION_DEG)} (got '{name}')")
    azimuth, elevation = _DIRECTION_DEG[name]
    if name == "iso" and wide:
        around = OrbitCamera((0.0, 0.0, 0.0), 1.0, azimuth, elevation + 11.5)
        return _fitted(around, _corners_m(grid), aspect)
    if name == "iso":
        return _first_view(aspect, car_m)
    longer_m, taller_m = max(0.0, car_m[0] - 4.6), max(0.0, car_m[1] - 1.45)
    side_m = (4.6 + 1.4 * taller_m, 7.4 + 1.2 * longer_m)
    tall_m, long_m = (grid.roi_m[1] * 1.14, grid.roi_m[0] * 1.10) if name == "top" else side_m
    focal = (0.0, 0.0, 0.0 if name == "top" else 1.45 + 0.5 * taller_m)
    camera = OrbitCamera(focal, 1.0, azimuth, elevation, parallel=True)
    distance = max(tall_m, long_m / aspect) / 2 / math.tan(math.radians(camera.view_angle_deg) / 2)
    return replace(camera, distance_m=distance)


def _first_view(aspect: float, car_m: tuple[float, float]) -> OrbitCamera:
    """Return the view from behind: the car a quarter of the width, and what sensors see of the road ahead of it."""
    azimuth, elevation = _DIRECTION_DEG["iso"]
    scale = max(1.0, car_m[0] / 4.6, car_m[1] / 1.45) * max(1.0, _FIRST_ASPECT / aspect) ** 0.7
    focal = (4.9 * scale, -0.8 * scale, 0.05)
    return OrbitCamera(focal, 18.6 * scale, azimuth, elevation, view_angle_deg=34.0)


def _corners_m(grid: VoxelGrid) -> Points:
    """Return the eight corners of the ROI, (8, 3) metres."""
    low = np.array(grid.origin_m)
    unit = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    return np.asarray(low + unit * np.array(grid.roi_m))


def _fitted(camera: OrbitCamera, points_m: Points, aspect: float) -> OrbitCamera:
    """Return the camera moved back and sideways until all points are in the picture, above the legend."""
    size = (round(1000 * aspect), 1000)
    low, high = _FIT_BOX[0] * size, _FIT_BOX[1] * size
    for _ in range(4):
        near, far = 1.0, _MAX_DISTANCE_M
        for _ in range(30):
            camera = replace(camera, distance_m=(near + far) / 2)
            seen = camera.project(points_m, size)
            inside = (seen[:, :2] > low).all() and (seen[:, :2] < high).all() and (seen[:, 2] > 0.0).all()
            near, far = (near, camera.distance_m) if inside else (camera.distance_m, far)
        seen = camera.project(points_m, size)[:, :2]
        offset = (low + high - seen.min(axis=0) - seen.max(axis=0)) / 2
        camera = camera.panned(float(offset[0]), float(offset[1]), size)
    return camera


_WIDEST_DEG, _AHEAD_M = 120.0, 8.0
"""Field of view that a flat picture may have, and the distance of its focal point: so far that the near plane is beyond
the camera's own housing."""


def through(camera: Camera) -> OrbitCamera | None:
    """Return the view along a camera, without distortion, roll and shift of its centre; None of one too wide for a flat
    picture."""
    wide, high = field_of_view_deg(camera)
    if not (wide <= _WIDEST_DEG and high <= _WIDEST_DEG):
        return None
    return along(camera, camera.pose.rotation()[:, 0], high)


def along(camera: Camera, ahead: Points, view_angle_deg: float) -> OrbitCamera:
    """Return the view from a camera's place along a unit vector (3,)."""
    x, y, z = (np.array(camera.position) + _AHEAD_M * ahead).tolist()
    azimuth = math.degrees(math.atan2(-ahead[1], -ahead[0]))
    elevation = math.degrees(math.asin(max(-1.0, min(1.0, -ahead[2]))))
    return OrbitCamera((x, y, z), _AHEAD_M, azimuth, elevation, view_angle_deg=view_angle_deg)
