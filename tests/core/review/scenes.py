"""A box on wheels and sensors above it, for which shadows can be worked out with a pencil."""

import numpy as np

from riglens.core.rig.body_mesh import BodyMesh
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig, Sensor, Vehicle

BOX_FILE = Vehicle(body="box.stl", length=4.0, width=2.0, height=1.5)


def box_mesh(length_m: float = 4.0, width_m: float = 2.0, height_m: float = 1.5) -> BodyMesh:
    """A closed box that stands on the ground around the origin."""
    x, y = length_m / 2, width_m / 2
    points = np.array(
        [[i * x, j * y, k] for i in (-1, 1) for j in (-1, 1) for k in (0.0, height_m)], np.float32
    )
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int32)
    return BodyMesh(points, np.zeros_like(points), triangles)


BOX = BOX_FILE.with_body_mesh(box_mesh())


def dense_lidar(z_m: float, beams: int = 901, turns: int = 720, x_m: float = 0.0) -> Lidar:
    """A LiDAR with a beam every tenth of a degree below the horizon."""
    return Lidar(
        name=f"lidar {x_m:g}",
        position=(x_m, 0.0, z_m),
        elevations_deg=LinearAngles(from_=-90.0, to=0.0, count=beams),
        azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=turns),
    )


def camera(position: tuple[float, float, float], yaw_deg: float = 0.0, pitch_deg: float = 0.0) -> Camera:
    """A pinhole of 90 degrees."""
    return Camera(
        name=f"camera {yaw_deg:g}",
        position=position,
        rpy_deg=(0.0, pitch_deg, yaw_deg),
        hfov_deg=90.0,
        image=(160, 120),
    )


def random_rig(rng: np.random.Generator, sensors: int = 4) -> Rig:
    """LiDARs and cameras in any pose about a car."""
    made: list[Sensor] = []
    for number in range(sensors):
        x, y, z = rng.uniform([-2.0, -1.0, 0.5], [2.0, 1.0, 2.5]).tolist()
        roll, pitch, yaw = rng.uniform([-20.0, -20.0, -180.0], [20.0, 40.0, 180.0]).tolist()
        turned = {"name": f"s{number}", "position": (x, y, z), "rpy_deg": (roll, pitch, yaw)}
        if number % 2:
            made.append(camera((x, y, z)).replace(**turned))
        else:
            made.append(dense_lidar(z, 12, 60).replace(**turned))
    return Rig(sensors=tuple(made))
