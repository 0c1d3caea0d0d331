"""Cases of the stability study on rays: a description of each, and why simple methods fail on it.

The grids are small, so that every ray can be checked in rational arithmetic; the two largest sensors come on
coarse grids. Directions that must be exact (diagonals) are those of cameras whose pixels lie at whole slopes:
sines and cosines of angles are rounded.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from riglens.core.geometry import Vec3
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Sensor
from riglens.core.rig.presets import preset
from riglens.core.scene.grid import VoxelGrid

UNIT = VoxelGrid(1.0, (12.0, 10.0, 8.0))
TENTHS = VoxelGrid(0.1, (1.2, 1.0, 0.8))
ROAD = VoxelGrid(1.0, (24.0, 16.0, 4.0))
OPEN_ROAD = VoxelGrid(0.5, (24.0, 16.0, 4.0))


def lidar(
    position: Vec3,
    elevations_deg: Sequence[float] = (0.0,),
    azimuths_deg: Sequence[float] = (0.0,),
    rpy_deg: Vec3 = (0.0, 0.0, 0.0),
) -> Lidar:
    """Return a LiDAR with listed angles."""
    return Lidar(
        name="lidar",
        position=position,
        rpy_deg=rpy_deg,
        elevations_deg=tuple(map(float, elevations_deg)),
        azimuths_deg=tuple(map(float, azimuths_deg)),
    )


def spinning(position: Vec3, rpy_deg: Vec3 = (0.0, 0.0, 0.0), beams: int = 16, count: int = 90) -> Lidar:
    """Return a LiDAR with `beams` over [-25, 25] degrees and a full turn."""
    return Lidar(
        name="lidar",
        position=position,
        rpy_deg=rpy_deg,
        elevations_deg=LinearAngles(from_=-25.0, to=25.0, count=beams),
        azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=count),
    )


def camera(position: Vec3, rpy_deg: Vec3 = (0.0, 0.0, 0.0), cast: tuple[int, int] = (24, 14)) -> Camera:
    """Return a camera of 70 degrees."""
    return Camera(name="camera", position=position, rpy_deg=rpy_deg, hfov_deg=70.0, cast=cast)


def whole_slopes(position: Vec3, side: int = 2) -> Camera:
    """Return a camera with side x side rays whose slopes are odd numbers: +-1 for side 2, +-1 and +-3 for side 4."""
    return Camera(
        name="camera",
        position=position,
        fx=800.0 / side,
        fy=450.0 / side,
        cx=800.0,
        cy=450.0,
        cast=(side, side),
    )


# ---------------------------------------------------------------- cases


FAR_M = 1e6
DENORMAL = 1e-310
RIGHT_ANGLES = (0.0, 90.0, 180.0, -90.0)
EIGHT_WAYS = (0.0, 45.0, 90.0, 135.0, 180.0, -135.0, -90.0, -45.0)


@dataclass(frozen=True)
class RayCase:
    """Sensors on a grid in which every voxel counts; `why`: what breaks simple methods here."""

    name: str
    why: str
    grid: VoxelGrid
    sensors: tuple[Sensor, ...]


def _case(name: str, why: str, *sensors: Sensor, grid: VoxelGrid = UNIT) -> RayCase:
    return RayCase(name, why, grid, sensors)


def ray_cases(quick: bool = False) -> Iterator[RayCase]:
    """Yield all cases, in the order of the table; `quick` thins the largest sensors."""
    yield from _planes()
    yield from _numbers()
    yield from _places()
    yield from _poses()
    yield from _sizes(quick)


def _planes() -> Iterator[RayCase]:
    yield _case(
        "rays in grid faces",
        "the ray never enters the voxels on either side; the rule gives it to the positive side",
        lidar((0.5, 1.0, 2.5), (0.0,), RIGHT_ANGLES),
        lidar((2.0, 0.5, 0.0), (0.0, 90.0), (0.0, 180.0)),
    )
    yield _case(
        "rays along edges",
        "four voxels share the ray",
        lidar((-3.5, 1.0, 2.0), (0.0,), (0.0, 180.0)),
        lidar((2.0, -3.0, 0.5), (90.0, -90.0)),
    )
    yield _case(
        "rays through corners",
        "three planes at one moment; voxels that are only touched do not count",
        whole_slopes((-5.0, -1.0, 3.0)),
        whole_slopes((0.0, 0.0, 4.0)),
        whole_slopes((2.0, 1.0, 4.0), side=4),
    )
    yield _case(
        "rays just off corners",
        "diagonals by angles: planes are met within 10⁻¹⁶ of each other, in an order that doubles lose",
        lidar((0.0, 0.0, 4.0), (0.0, 45.0, -45.0, _SPACE_DIAGONAL_DEG, -_SPACE_DIAGONAL_DEG), EIGHT_WAYS),
    )
    yield _case(
        "rays aimed at edges",
        "generic origins, every ray as near to an edge as doubles can aim it",
        *(_aimed(UNIT, number) for number in range(4)),
    )
    yield _case(
        "faces at multiples of 0.1 m",
        "0.1 has no double: a face is where the rounded quotient is whole",
        lidar((0.0, 0.3, 0.3), (0.0, 45.0, 90.0), EIGHT_WAYS),
        whole_slopes((-0.3, 0.1, 0.4), side=4),
        grid=TENTHS,
    )


_SPACE_DIAGONAL_DEG = math.degrees(math.atan(math.sqrt(0.5)))


def _aimed(grid: VoxelGrid, seed: int) -> Lidar:
    """Return a LiDAR whose azimuths go to edges and whose elevations go to corners."""
    rng = np.random.default_rng(seed)
    position = rng.uniform([-4.0, -4.0, 1.0], [4.0, 4.0, 7.0])
    planes = [np.arange(grid.shape[axis] + 1) + grid.origin_m[axis] for axis in range(2)]
    x, y = (part.ravel() for part in np.meshgrid(*planes))
    chosen = rng.choice(x.size, 40, replace=False)
    away = np.hypot(x[chosen] - position[0], y[chosen] - position[1])
    azimuths = np.degrees(np.arctan2(y[chosen] - position[1], x[chosen] - position[0]))
    levels = rng.integers(0, grid.shape[2] + 1, 6)
    elevations = np.degrees(np.arctan2(levels - position[2], away[:6]))
    return lidar((float(position[0]), float(position[1]), float(position[2])), elevations, azimuths)


def _numbers() -> Iterator[RayCase]:
    yield _case(
        "axis-parallel rays",
        "a component of zero: division by it, 0 · ∞",
        lidar((0.5, 0.25, 3.5), (0.0, 90.0, -90.0), (0.0,)),
        lidar((0.5, 0.25, 3.5), (0.0,), RIGHT_ANGLES),
    )
    yield _case(
        "components +0 and −0",
        "1 / −0 is −∞; the sign of a zero must not choose a side",
        lidar((-0.0, 0.0, 4.0), (0.0, -0.0), (0.0, -0.0), (0.0, -0.0, -0.0)),
        lidar((2.0, -0.0, -0.0), (-0.0,), (0.0,), (-0.0, 0.0, 0.0)),
    )
    yield _case(
        "denormal components",
        "the reciprocal overflows; products underflow to zero",
        lidar((0.0, 0.5, 3.5), (0.0, DENORMAL), (0.0, DENORMAL, -5e-324)),
        lidar((DENORMAL, -DENORMAL, 5e-324), (0.0,), (0.0, 180.0), (0.0, -DENORMAL, DENORMAL)),
    )


def _places() -> Iterator[RayCase]:
    turn, tilt = tuple(range(-180, 180, 15)), (-40.0, -10.0, 0.0, 25.0, 60.0)
    yield _case(
        "origin on a face",
        "the first voxel depends on the direction of the ray",
        lidar((2.0, 0.3, 3.6), tilt, turn),
    )
    yield _case("origin on a corner", "the first voxel is one of eight", lidar((2.0, -1.0, 4.0), tilt, turn))
    yield _case(
        "origin on the ROI's corner",
        "half of the rays leave at once",
        lidar((-6.0, -5.0, 0.0), tilt, turn),
        lidar((6.0, 5.0, 8.0), tilt, turn),
    )
    yield _case(
        "origin outside the ROI",
        "the ray has to be clipped first; rounding there starts in the wrong voxel",
        lidar((-17.3, 3.7, 9.9), tilt, turn),
        camera((-9.0, -8.0, 4.0), (0.0, 0.0, 40.0)),
    )
    far = (-FAR_M, -FAR_M, -FAR_M)
    yield _case(
        "origin 1,000,000 m away",
        "moments along the ray keep 9 digits fewer; rays still meet corners",
        *(whole_slopes((far[0] + dx, far[1] + dy, far[2] + dz)) for dx, dy, dz in _OFFSETS),
        *(whole_slopes((far[0] + dx, 3.0 * far[1] + dy, far[2] + dz), side=4) for dx, dy, dz in _OFFSETS),
    )
    yield _case(
        "ROI one voxel high",
        "the first face is also the last",
        spinning((0.3, 0.2, 0.25)),
        camera((-4.0, 0.5, 0.4), (0.0, 5.0, 10.0)),
        grid=VoxelGrid(0.5, (12.0, 9.0, 0.5)),
    )
    yield _case(
        "ROI one voxel wide",
        "the first face is also the last",
        spinning((0.3, 0.1, 1.9)),
        camera((-4.0, 0.5, 1.4), (0.0, 5.0, -10.0)),
        grid=VoxelGrid(0.5, (12.0, 0.5, 4.0)),
    )


_OFFSETS = ((0.0, 0.0, 4.0), (0.0, 2.0, 3.0), (1.0, 0.0, 5.5), (0.5, 0.5, 4.5), (0.3, 0.3, 4.0))


def _poses() -> Iterator[RayCase]:
    yield _case(
        "pitch +90° and −90°",
        "yaw and roll become one; cos 90° is 6 · 10⁻¹⁷, not 0",
        camera((0.0, 0.0, 4.0), (0.0, 90.0, 0.0)),
        camera((1.3, 0.0, 4.0), (0.0, -90.0, 30.0)),
        lidar((0.5, 0.5, 4.5), (-5.0, 0.0, 5.0), tuple(range(-180, 180, 10)), (0.0, 90.0, 45.0)),
    )
    yield _case(
        "tilted sensors",
        "no plane of rays is vertical: shortcuts for upright sensors do not apply",
        spinning((0.31, 0.17, 4.23), (16.0, 0.0, 0.0)),
        spinning((-1.3, 0.4, 4.4), (-16.0, -5.2, 77.0)),
        camera((1.1, -0.6, 3.8), (12.0, 20.0, -130.0)),
    )
    yield _case(
        "all sensors of W+T",
        "sensors at multiples of 0.1 m, straight ahead and sideways: many rays lie in faces",
        *(_thinned(sensor) for sensor in preset("W+T").sensors),
        grid=OPEN_ROAD,
    )


def _thinned(sensor: Sensor) -> Sensor:
    """Thin the sensor's rays to a number that rational arithmetic can handle."""
    changes = {"cast": (44, 16)} if isinstance(sensor, Camera) else {"azimuths_deg": _EVERY_FOUR_DEGREES}
    thinned: Sensor = sensor.replace(**changes)
    return thinned


_EVERY_FOUR_DEGREES = LinearAngles(from_=-180.0, to=180.0, count=90)


def _sizes(quick: bool) -> Iterator[RayCase]:
    pixels, turn = ((200, 112), (16, 360)) if quick else ((1600, 900), (128, 3600))
    yield _case(
        f"native camera, {pixels[0]} × {pixels[1]}",
        "a thousand rays to a voxel: none may be missing",
        camera((0.51, 0.03, 1.83), (0.0, 3.0, 30.0), pixels),
        grid=ROAD,
    )
    yield _case(
        f"LiDAR of {turn[0]} × {turn[1]} rays",
        "beams closer than voxels",
        spinning((0.21, 0.53, 2.17), (0.0, 0.0, 7.0), *turn),
        grid=ROAD,
    )
