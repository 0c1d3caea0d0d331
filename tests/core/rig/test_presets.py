"""The rigs of the paper, by every name they go by."""

import math

import pytest

from riglens.assets import asset_path
from riglens.core.errors import InputError
from riglens.core.rig.model import Camera, Lidar
from riglens.core.rig.presets import CARS, PAPER_RIGS, PRESETS, find_preset, preset
from riglens.core.rig.yaml.file import dumps, loads

LIDARS = {
    "C": [(0, 0, 2.4), (0, 0, 2.6), (0, 0, 2.8), (0, 0, 3.0)],
    "P": [(-0.2, -0.6, 2.2), (0.4, 0, 2.4), (-0.2, 0, 2.6), (-0.2, 0.6, 2.2)],
    "L": [(0, -0.6, 2.2), (0, -0.4, 2.2), (0, 0.4, 2.2), (0, 0.6, 2.2)],
    "T": [(-0.4, 0.2, 2.2), (-0.4, -0.2, 2.2), (0.2, 0.5, 2.2), (0.2, -0.5, 2.2)],
    "S": [(-0.5, 0.5, 2.2), (-0.5, -0.5, 2.2), (0.5, 0.5, 2.2), (0.5, -0.5, 2.2)],
}
CAMERAS = {
    "CAM_FRONT": (0.5, 0.0, 0.0),
    "CAM_FRONT_LEFT": (0.0, 0.5, 55.0),
    "CAM_BACK_LEFT": (-0.5, 0.5, 110.0),
    "CAM_BACK": (-1.5, 0.0, 180.0),
    "CAM_BACK_RIGHT": (-0.5, -0.5, -110.0),
    "CAM_FRONT_RIGHT": (0.0, -0.5, -55.0),
}


def test_the_eight_rigs_of_the_paper_come_first() -> None:
    assert PAPER_RIGS == ("W+C", "W+P", "W+L", "W+T", "N+C", "N+P", "N+L", "N+T")
    cars = tuple(one.name for one in CARS)
    assert tuple(PRESETS)[: len(cars) + 8] == (*cars, *PAPER_RIGS) and len(PRESETS) == 33


@pytest.mark.parametrize("letter", LIDARS)
def test_lidars_stand_where_the_paper_puts_them(letter: str) -> None:
    lidars = preset(f"W+{letter}").enabled_lidars()
    assert [lidar.position for lidar in lidars] == LIDARS[letter]
    for lidar in lidars:
        assert lidar.rpy_deg == (0.0, 0.0, 0.0) and lidar.range_m == (0.0, math.inf)
        beams, azimuths = lidar.elevations(), lidar.azimuths()
        assert (beams.size, beams[0], beams[-1]) == (16, -25.0, 25.0)
        assert (azimuths.size, azimuths[0], azimuths[-1]) == (360, -180.0, 179.0)


@pytest.mark.parametrize(("name", "hfov_deg", "back_hfov_deg"), [("Wide", 70, 110), ("Narrow", 55, 55)])
def test_cameras_look_where_the_paper_points_them(name: str, hfov_deg: float, back_hfov_deg: float) -> None:
    rig = preset(name)
    assert [sensor.name for sensor in rig.sensors] == list(CAMERAS)
    for camera in rig.enabled_cameras():
        x_m, y_m, yaw_deg = CAMERAS[camera.name]
        assert camera.position == (x_m, y_m, 1.8) and camera.rpy_deg == (0.0, 0.0, yaw_deg)
        assert camera.hfov_deg == (back_hfov_deg if camera.name == "CAM_BACK" else hfov_deg)
        assert (camera.image, camera.cast) == ((1600, 900), (352, 128))


def test_tilted_groups_are_converted_from_radians_exactly() -> None:
    for letters, upright in (("LR", "L"), ("PR", "P")):
        lidars = preset(f"N+{letters}").enabled_lidars()
        rolls = [lidar.rpy_deg[0] for lidar in lidars]
        assert rolls == [math.degrees(-0.28), 0.0, 0.0, math.degrees(0.28)]
        assert [lidar.position for lidar in lidars] == LIDARS[upright]
        assert all(lidar.rpy_deg[1:] == (0.0, 0.0) for lidar in lidars)
    lidars = preset("W+PP").enabled_lidars()
    assert [lidar.rpy_deg[1] for lidar in lidars] == [0.0, math.degrees(-0.09), 0.0, 0.0]
    assert [lidar.position for lidar in lidars] == LIDARS["P"] and lidars[1].position[0] == 0.4


@pytest.mark.parametrize(
    ("spelling", "name"),
    [
        ("w+t", "W+T"),
        (" W + T ", "W+T"),
        ("Wide+Trapezoid", "W+T"),
        ("narrow + line", "N+L"),
        ("WIDE+LINE_ROLL", "W+LR"),
        ("n+pp", "N+PP"),
        ("Wide+Centre", "W+C"),
        ("centre", "Center"),
        ("pyramid-ROLL", "Pyramid-roll"),
    ],
)
def test_names_may_be_spelled_in_words_and_in_any_case(spelling: str, name: str) -> None:
    assert preset(spelling) == preset(name)
    assert preset(spelling).name == name


def test_single_groups_hold_lidars_or_cameras_alone() -> None:
    assert len(preset("Square").sensors) == 4 and all(isinstance(s, Lidar) for s in preset("Square").sensors)
    assert len(preset("Wide").sensors) == 6 and all(isinstance(s, Camera) for s in preset("Wide").sensors)


def test_every_preset_has_a_description_and_survives_a_file() -> None:
    for name, entry in PRESETS.items():
        assert entry.name == name and len(entry.description) > 20
        assert loads(dumps(entry.rig())).rig == entry.rig()


def test_an_unknown_preset_is_refused_with_the_nearest_ones() -> None:
    with pytest.raises(
        InputError, match=r"unknown preset 'W\+X' .did you mean .*W\+T.*known: nuScenes car, .*W\+C, W\+P"
    ):
        preset("W+X")


def test_rays_pass_through_the_cars_of_the_papers_rigs_alone_however_they_are_edited() -> None:
    for name, entry in PRESETS.items():
        assert preset(name).self_occlusion == bool(entry.file), name
    edited = preset("W+T").replace(name="mine", sensors=preset("W+T").sensors[1:])
    assert loads(dumps(edited)).rig.body == "ignored"


def test_presets_are_named_in_words() -> None:
    assert PRESETS["W+T"].title == "Wide + Trapezoid (W+T)"
    assert PRESETS["N+PR"].title == "Narrow + Pyramid-roll (N+PR)"
    assert PRESETS["Center"].title == "Center" and PRESETS["KITTI car"].title == "KITTI car"


@pytest.mark.parametrize(
    ("name", "cameras", "lidars", "ahead", "up"),
    [
        ("nuScenes car", 6, 1, "CAM_FRONT", "LIDAR_TOP"),
        ("kitti CAR", 4, 1, "cam2", "velodyne"),
        ("pandaset car", 6, 2, "front_camera", "main_pandar64"),
        ("Argoverse 2 car", 9, 2, "ring_front_center", "up_lidar"),
        ("waymo car", 5, 5, "camera_front", "lidar_top"),
    ],
)
def test_real_cars_name_library_models_and_stand_as_published(
    name: str, cameras: int, lidars: int, ahead: str, up: str
) -> None:
    rig = preset(name)
    assert (len(rig.enabled_cameras()), len(rig.enabled_lidars())) == (cameras, lidars)
    assert all(sensor.model for sensor in rig.sensors)
    front, top = rig.sensor(ahead), rig.sensor(up)
    assert abs(front.rpy_deg[2]) < 2.0 and top.position[2] > 1.7
    half_m = rig.vehicle.length / 2
    assert all(abs(s.position[0]) < half_m + 0.03 and 0.45 < s.position[2] < 2.6 for s in rig.sensors)
    text = asset_path("rigs", PRESETS[rig.name].file).read_text(encoding="utf-8")
    assert text.startswith("# ") and "elevations_deg" not in text and len(text) < 2500
    assert loads(dumps(rig)).rig == rig and len(dumps(rig)) < 2500


def test_the_nuscenes_car_with_radars_is_the_nuscenes_car_and_radars() -> None:
    car, whole = preset("nuScenes car"), preset("nuScenes car with radars")
    assert whole.vehicle == car.vehicle
    assert tuple(sensor for sensor in whole.sensors if sensor.kind != "radar") == car.sensors


def test_a_folder_called_after_a_data_set_is_no_preset() -> None:
    assert [find_preset(name) for name in ("nuscenes", "kitti", "pandaset", "argoverse2", "waymo")] == [
        None
    ] * 5
