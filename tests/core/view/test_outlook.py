"""Data that look one way only are known as such, and so are the sensors that look elsewhere."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from riglens.core.figures.heatmaps import Heatmaps
from riglens.core.geometry import Vec3
from riglens.core.rig.model import Camera, Lidar, LinearAngles
from riglens.core.view.display import DisplayGrid
from riglens.core.view.outlook import Gap, looks_into, widest_gap
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.scenario import load_scenario

HEAD = "seq,frame,cls,x,y,z,length,width,height,yaw"


def display(
    tmp_path: Path, azimuths_deg: list[float], distances_m: tuple[float, ...] = (6.0, 9.0)
) -> DisplayGrid:
    """Cars of half a metre at these azimuths, one in each frame."""
    rows, frame = [HEAD], 0
    for azimuth in azimuths_deg:
        for distance in distances_m:
            x, y = distance * math.cos(math.radians(azimuth)), distance * math.sin(math.radians(azimuth))
            rows.append(f"s,{frame},car,{x:.3f},{y:.3f},0.8,0.5,0.5,1.6,0")
            frame += 1
    path = tmp_path / "boxes.csv"
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    found = load_scenario(SceneOptions(boxes=path, voxel_m=0.25, roi_m=(20.0, 20.0, 2.0)))
    return Heatmaps(DisplayGrid.build(found.pog, found.field)).display


def test_labels_of_a_front_camera_leave_the_rest_without_boxes(tmp_path: Path) -> None:
    gap = widest_gap(display(tmp_path, [float(angle) for angle in range(-44, 45, 2)]))
    assert gap is not None
    low, high = gap.boxes_deg
    assert low == pytest.approx(-44, abs=5) and high == pytest.approx(44, abs=5)
    assert gap.words.startswith("boxes only ahead (\u2212")
    assert gap.holds(np.array([180.0, -180.0, 90.0, -90.0, 540.0])).all()
    assert not gap.holds(np.array([0.0, 30.0, -30.0, 360.0])).any()


def test_boxes_behind_are_said_to_be_behind(tmp_path: Path) -> None:
    gap = widest_gap(display(tmp_path, [float(angle) for angle in range(140, 221, 2)]))
    assert gap is not None and gap.words.startswith("boxes only behind")
    assert gap.holds(np.array([0.0]))[0] and not gap.holds(np.array([180.0]))[0]


def test_data_that_look_all_round_have_no_gap(tmp_path: Path) -> None:
    assert widest_gap(display(tmp_path, [float(angle) for angle in range(-180, 180, 6)])) is None
    assert widest_gap(display(tmp_path, [float(angle) for angle in range(-180, 120, 6)])) is None


def test_a_handful_of_boxes_says_nothing(tmp_path: Path) -> None:
    assert widest_gap(display(tmp_path, [0.0, 10.0, 20.0])) is None


def camera(yaw_deg: float, hfov_deg: float = 70.0, position: Vec3 = (0.0, 0.0, 1.5)) -> Camera:
    return Camera(
        name="c",
        position=position,
        rpy_deg=(0.0, 0.0, yaw_deg),
        image=(160, 90),
        hfov_deg=hfov_deg,
        cast=(64, 36),
    )


def test_a_sensor_looks_elsewhere_when_its_rays_run_in_the_gap() -> None:
    gap = Gap(45.0, 315.0)
    assert looks_into(camera(180.0), gap) and looks_into(camera(-110.0, 120.0), gap)
    assert not looks_into(camera(0.0), gap) and not looks_into(camera(55.0), gap)
    turn = LinearAngles(**{"from": -180.0, "to": 180.0, "count": 360})
    beams = LinearAngles(**{"from": -20.0, "to": 10.0, "count": 8})
    assert not looks_into(
        Lidar(name="l", position=(0.0, 0.0, 2.0), elevations_deg=beams, azimuths_deg=turn), gap
    )
    rear = LinearAngles(**{"from": 120.0, "to": 240.0, "count": 120})
    assert looks_into(Lidar(name="l", position=(0.0, 0.0, 2.0), elevations_deg=beams, azimuths_deg=rear), gap)
