"""What the links of a robot carry: by sensors and plugins of Gazebo, by frames of scans, by files of shapes."""

import math
from pathlib import Path

import pytest

from riglens.core.errors import InputError
from riglens.core.formats.exchange import read_rig
from riglens.core.formats.mounts import ReadOptions
from riglens.core.formats.report import OpenedRig
from riglens.core.rig.model import Lidar
from riglens.core.sensors.ultrasonic import Ultrasonic
from tests.core.formats.cases import VEHICLE, read_files, write_files
from tests.core.formats.test_reports import has


def robot(*parts: str) -> OpenedRig:
    """A robot with a mast, of which some parts say what it carries."""
    links = "".join(f"<link name='{name}'/>" for name in ("base_link", "mast", "front_scan"))
    joints = "".join(
        f"<joint name='j{name}' type='fixed'><parent link='base_link'/><child link='{name}'/></joint>"
        for name in ("mast", "front_scan")
    )
    return read_files({"rig.urdf": f"<robot name='r'>{links}{joints}{''.join(parts)}</robot>"})


def test_frames_of_scans_are_lidars() -> None:
    assert [(sensor.name, sensor.kind) for sensor in robot().rig.sensors] == [("front_scan", "lidar")]


@pytest.mark.parametrize(
    ("inside", "kind"),
    [
        ("<plugin name='p' filename='libgazebo_ros_velodyne_laser.so'/>", "lidar"),
        ("<plugin name='camera_controller' filename='libx.so'/>", "camera"),
        (
            "<sensor name='s' type='custom'><plugin name='p' filename='libgazebo_ros_livox.so'/></sensor>",
            "lidar",
        ),
        ("<sensor name='s' type='gpu_lidar'/>", "lidar"),
        ("<sensor name='s' type='depth'/>", "camera"),
        ("<plugin name='p' filename='libgazebo_ros_control.so'/>", None),
    ],
)
def test_what_a_link_carries_is_told_by_sensors_and_plugins_of_gazebo(inside: str, kind: str | None) -> None:
    sensors = robot(f"<gazebo reference='mast'>{inside}</gazebo>").rig.sensors
    kinds = [sensor.kind for sensor in sensors if sensor.name != "front_scan"]
    assert kinds == ([] if kind is None else [kind])


@pytest.mark.parametrize(
    "frame",
    [
        "<frameName>{}</frameName>",
        "<frame_name>{}</frame_name>",
        "<ros/><frameName> </frameName><frame_id> {} </frame_id>",
    ],
)
def test_a_plugin_without_a_reference_is_on_the_frame_that_it_names(frame: str) -> None:
    plugin = f"<gazebo><plugin name='p' filename='libgazebo_ros_laser.so'>{frame}</plugin></gazebo>"
    assert {sensor.name for sensor in robot(plugin.format("mast")).rig.sensors} == {"mast", "front_scan"}
    assert has(robot(plugin.format("nowhere")).report, "on the link 'nowhere', which does not exist")


def test_a_link_is_told_by_the_file_of_its_shape() -> None:
    mesh = "<mesh filename='package://velodyne_description/meshes/VLP16_base.dae'/>"
    joint = "<joint name='x' type='fixed'><parent link='mast'/><child link='thing'/></joint>"
    read = robot(f"<link name='thing'><visual><geometry>{mesh}</geometry></visual></link>{joint}")
    assert {sensor.name for sensor in read.rig.sensors} == {"thing", "front_scan"}
    assert has(read.report, "taken for a LiDAR by the name of its mesh", "thing")


SCAN = """<sensor name='s' type='ray'><ray><scan>
  <horizontal><samples>5</samples><min_angle>-1</min_angle><max_angle>1</max_angle></horizontal>
  <vertical><samples>3</samples><min_angle>{}</min_angle><max_angle>{}</max_angle></vertical></scan></ray>{}</sensor>"""


def test_a_scan_from_above_downwards_has_the_same_beams() -> None:
    def elevations(low: float, high: float) -> list[float]:
        read = robot(f"<gazebo reference='mast'>{SCAN.format(low, high, '')}</gazebo>")
        (lidar,) = (sensor for sensor in read.rig.sensors if sensor.name == "s")
        assert isinstance(lidar, Lidar)
        return list(lidar.elevations())

    assert (
        elevations(-0.1, -0.35)
        == elevations(-0.35, -0.1)
        == pytest.approx([-20.0535, -12.8916, -5.7296], abs=1e-4)
    )


RANGE = "libgazebo_ros_range.so"
ONE_RAY = """<sensor name='s' type='ray'><ray><scan><horizontal><samples>1</samples><min_angle>0</min_angle>
  <max_angle>0</max_angle></horizontal></scan><range><min>0.1</min><max>{}</max></range></ray></sensor>"""


def found(sensor: str) -> list[tuple[str, str]]:
    read = robot(f"<gazebo reference='mast'>{sensor}</gazebo>")
    return [(one.name, one.kind) for one in read.rig.sensors]


def test_a_range_finder_is_a_sonar_unless_it_uses_light() -> None:
    sonar = SCAN.format(-0.2, 0.2, f"<plugin name='p' filename='{RANGE}'/>")
    read = robot(f"<gazebo reference='mast'>{sonar}</gazebo>")
    one = read.rig.sensor("s")
    assert isinstance(one, Ultrasonic)
    assert one.azimuth_deg == pytest.approx((-57.29578, 57.29578))
    assert one.elevation_deg == pytest.approx((-11.459156, 11.459156))
    by_light = f"<plugin name='p' filename='{RANGE}'><radiation>infrared</radiation></plugin>"
    assert found(SCAN.format(0, 0, by_light)) == [("front_scan", "lidar")]


def test_a_single_ray_of_few_metres_is_a_sonar_and_a_long_one_is_a_lidar() -> None:
    assert ("s", "ultrasonic") in found(ONE_RAY.format(4.0)) and ("s", "lidar") in found(ONE_RAY.format(40.0))
    read = robot(f"<gazebo reference='mast'>{ONE_RAY.format(4.0)}</gazebo>")
    one = read.rig.sensor("s")
    assert isinstance(one, Ultrasonic)
    assert (one.pole_range_m, one.wall_range_m, one.range_m) == (4.0, 4.0, (0.1, math.inf))
    assert has(read.report, "approximated", "field of view of a sonar not in the file", "s")


def test_a_sonar_of_sdf_has_its_cone() -> None:
    read = robot(
        "<gazebo reference='mast'><sensor name='s' type='sonar'><sonar><min>0.1</min><max>5</max>"
        "<radius>2.5</radius></sonar></sensor></gazebo>"
    )
    one = read.rig.sensor("s")
    assert isinstance(one, Ultrasonic) and one.azimuth_deg == pytest.approx((-26.565051, 26.565051))


LASER = (
    "<link name='link'><pose>0 0 0.1 0 0 0</pose>"
    "<sensor name='laser' type='ray'><pose>0.2 0 0 0 0 0</pose></sensor></link>"
)


def included(tmp_path: Path, model: str, **others: str) -> OpenedRig:
    """A model in a folder of models, with others beside it."""
    for name, inside in {"car": model, **others}.items():
        write_files(
            tmp_path / name, {"model.sdf": f"<sdf version='1.9'><model name='{name}'>{inside}</model></sdf>"}
        )
    options = ReadOptions(vehicle=VEHICLE, origin_m=(0.0, 0.0, 0.0))
    return read_rig(tmp_path / "car" / "model.sdf", options=options)


def test_models_in_a_model_stand_where_it_has_them(tmp_path: Path) -> None:
    """Twice the same LiDAR, one on the model and one on a link of it, and a model written in it."""
    read = included(
        tmp_path,
        "<link name='mast'><pose>1 0 1 0 0 1.5707963267948966</pose></link>"
        "<include><uri>model://spinner</uri><pose>0 0 2 0 0 0</pose></include>"
        "<include><uri>model://spinner</uri><pose relative_to='mast'>0 0 1 0 0 0</pose></include>"
        f"<model name='own'><pose>-1 0 0 0 0 0</pose>{LASER}</model>"
        "<include><uri>model://nosuch</uri></include><include><uri>https://fuel.gazebosim.org/x</uri></include>",
        spinner=f"<pose>9 9 9 0 0 0</pose>{LASER}",
    )
    places = sorted(sensor.position for sensor in read.rig.sensors)
    assert places == [pytest.approx(at) for at in ((-0.8, 0.0, 0.1), (0.2, 0.0, 2.1), (1.0, 0.2, 2.1))]
    for uri in ("model://nosuch", "https://fuel.gazebosim.org/x"):
        assert has(read.report, "ignored", "included model that is not beside the model's folder", uri)


@pytest.mark.parametrize("folder", [".", "models"])
def test_models_included_in_a_world_are_models_of_it(tmp_path: Path, folder: str) -> None:
    write_files(tmp_path / folder / "car", {"model.sdf": f"<sdf><model name='car'>{LASER}</model></sdf>"})
    world = (
        "<sdf><world name='w'><model name='floor'><link name='l'/></model><include><uri>model://sun</uri></include>"
        "<include><uri>model://car</uri></include>"
        "<include><uri>model://car</uri><name>second</name><pose>9 9 0 0 0 1</pose></include></world></sdf>"
    )
    file = write_files(tmp_path / "worlds", {"w.world": world}) / "w.world"
    for token, other in ((None, "second"), ("second", "car")):
        read = read_rig(file, options=ReadOptions(vehicle=VEHICLE, origin_m=(0.0, 0.0, 0.0), token=token))
        assert [sensor.position for sensor in read.rig.sensors] == [pytest.approx((0.2, 0.0, 0.1))]
        assert has(
            read.report, "ignored", "included model that is not beside the model's folder", "model://sun"
        )
        assert has(read.report, "ignored", "another model", other)
        assert has(read.report, "ignored", "another model", "floor")


def test_a_world_whose_models_are_all_missing_names_the_first(tmp_path: Path) -> None:
    file = write_files(
        tmp_path, {"w.world": "<sdf><world><include><uri>model://car</uri></include></world></sdf>"}
    )
    with pytest.raises(InputError, match=r"w\.world: include: uri: .*model://car"):
        read_rig(file / "w.world")


def test_an_included_model_without_a_place_stands_where_it_says(tmp_path: Path) -> None:
    read = included(
        tmp_path, "<include><uri>spinner</uri></include>", spinner=f"<pose>0 0 1 0 0 0</pose>{LASER}"
    )
    assert [sensor.position for sensor in read.rig.sensors] == [pytest.approx((0.2, 0.0, 1.1))]


def test_no_model_is_read_from_elsewhere_or_for_ever(tmp_path: Path) -> None:
    outside = write_files(tmp_path / "away", {"model.sdf": f"<sdf><model name='away'>{LASER}</model></sdf>"})
    models = tmp_path / "models"
    models.mkdir()
    (models / "link").symlink_to(outside)
    for uri in ("model://../away", "model://link", "../../away", "model://..", "", "model://" + "a" * 300):
        read = included(models, f"{LASER}<include><uri>{uri}</uri></include>")
        assert len(read.rig.sensors) == 1 and has(read.report, "ignored", "not beside the model's folder")
    with pytest.raises(InputError, match="nested too deeply"):
        included(models, "<include><uri>model://car</uri></include>")
