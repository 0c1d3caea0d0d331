"""Small grids, and sensors on them, of which the stability study's cases are made."""

from __future__ import annotations

from collections.abc import Sequence

from riglens.core.geometry import Vec3
from riglens.core.rig.model import Camera, EvenAngles, Lidar
from riglens.core.scene.grid import VoxelGrid

Sensor = Lidar | Camera
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
    """A LiDAR with listed angles."""
    return Lidar(
        name="lidar",
        position=position,
        rpy_deg=rpy_deg,
        elevations_deg=tuple(map(float, elevations_deg)),
        azimuths_deg=tuple(map(float, azimuths_deg)),
    )


def spinning(position: Vec3, rpy_deg: Vec3 = (0.0, 0.0, 0.0), beams: int = 16, count: int = 90) -> Lidar:
    """A LiDAR with `beams` over [-25, 25] degrees and a full turn."""
    return Lidar(
        name="lidar",
        position=position,
        rpy_deg=rpy_deg,
        elevations_deg=EvenAngles(from_=-25.0, to=25.0, count=beams),
        azimuths_deg=EvenAngles(from_=-180.0, to=180.0, count=count),
    )


def camera(position: Vec3, rpy_deg: Vec3 = (0.0, 0.0, 0.0), cast: tuple[int, int] = (24, 14)) -> Camera:
    """A camera of 70 degrees."""
    return Camera(name="camera", position=position, rpy_deg=rpy_deg, hfov_deg=70.0, cast=cast)


def whole_slopes(position: Vec3, yaw_deg: float = 0.0, side: int = 2) -> Camera:
    """A camera with side x side rays whose slopes are odd numbers: +-1 for side 2, +-1 and +-3 for side 4."""
    return Camera(
        name="camera",
        position=position,
        rpy_deg=(0.0, 0.0, yaw_deg),
        fx=800.0 / side,
        fy=450.0 / side,
        cx=800.0,
        cy=450.0,
        cast=(side, side),
    )
