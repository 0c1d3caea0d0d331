"""What is written, read by programs of others where they are installed: yourdfpy, betterosi, OpenCV."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from riglens.core.formats.exchange import write_rig
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt, Rig
from riglens.core.sensors.camera import project_px
from tests.core.formats.cases import camera, lidar, rig_of, sensor_matrix, transform

LENS = {"fx": 500.0, "fy": 510.0, "cx": 402.0, "cy": 297.0}
RIG = rig_of(
    lidar("top", ((0.4, -0.1, 1.9), (3.0, -5.0, 40.0))),
    camera(
        "front",
        ((1.5, 0.2, 1.4), (1.0, 4.0, -25.0)),
        **LENS,
        distortion=BrownConrady(k1=-0.2, k2=0.05, p1=1e-3),
    ),
    camera("side", ((1.2, 0.9, 0.9), (0.0, 30.0, 90.0)), **LENS, distortion=KannalaBrandt(k1=0.05, k2=-0.01)),
)


def from_rear_axle(rig: Rig, height_m: float = 0.0) -> np.ndarray:
    return transform(Rotation.identity(), (rig.vehicle.rear_axle_x, 0.0, height_m))


def test_urdf_frames_stand_where_yourdfpy_puts_them(tmp_path: Path) -> None:
    yourdfpy = pytest.importorskip("yourdfpy", reason="pip install yourdfpy")
    write_rig(RIG, tmp_path / "rig.urdf")
    urdf = yourdfpy.URDF.load(str(tmp_path / "rig.urdf"), load_meshes=False)
    for sensor in RIG.sensors:
        found = from_rear_axle(RIG) @ urdf.get_transform(f"{sensor.name}_link", "base_link")
        np.testing.assert_allclose(found, sensor_matrix(sensor), atol=1e-11)


def test_osi_is_parsed_and_mounted_as_betterosi_reads_it(tmp_path: Path) -> None:
    betterosi = pytest.importorskip("betterosi", reason="pip install betterosi")
    write_rig(RIG, tmp_path / "osi.json", "osi")
    views = json.loads((tmp_path / "osi.json").read_text(encoding="utf-8"))["sensor_view_configuration"]
    for view, sensor in zip(views, RIG.sensors, strict=True):
        mounted = betterosi.SensorViewConfiguration.from_json(json.dumps(view)).mounting_position
        place, angles = mounted.position, mounted.orientation
        turned = Rotation.from_euler("xyz", [angles.roll, angles.pitch, angles.yaw])
        found = from_rear_axle(RIG, 0.33) @ transform(turned, (place.x, place.y, place.z))
        np.testing.assert_allclose(found, sensor_matrix(sensor), atol=1e-11)


@pytest.mark.parametrize("name", ["front", "side"])
def test_lenses_project_as_those_of_opencv(name: str) -> None:
    cv2 = pytest.importorskip("cv2", reason="pip install opencv-python-headless")
    one = RIG.sensor(name)
    assert isinstance(one, Camera) and one.distortion is not None
    across = np.stack(np.meshgrid(np.linspace(-0.5, 0.5, 9), np.linspace(-0.4, 0.4, 7)), axis=-1).reshape(
        -1, 2
    )
    optical = np.column_stack([across, np.ones(len(across))])
    matrix = np.array([[500.0, 0.0, 402.0], [0.0, 510.0, 297.0], [0.0, 0.0, 1.0]])
    bend = np.array(list(one.distortion.model_dump(exclude={"model"}).values()))
    points = cv2.fisheye.projectPoints if name == "side" else cv2.projectPoints
    args = (optical[:, None],) if name == "side" else (optical,)
    expected = points(*args, np.zeros(3), np.zeros(3), matrix, bend)[0].reshape(-1, 2)
    body = optical @ np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    found = project_px(one, body / np.linalg.norm(body, axis=1, keepdims=True))
    np.testing.assert_allclose(found, expected, atol=1e-9)
