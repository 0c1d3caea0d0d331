"""CARLA leaderboard agents: the list is read as it is written, nothing in the file is ever executed."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from riglens.core.errors import InputError
from riglens.core.formats.exchange import read_rig
from riglens.core.formats.mounts import ReadOptions
from riglens.core.rig.model import Camera, Lidar
from riglens.core.sensors.radar import Radar
from tests.core.formats.cases import CARLA_AGENT, assert_same_pose, read_files, sensor_matrix, transform
from tests.core.formats.test_reports import has

AGENT = CARLA_AGENT["agent.py"]
CAMERA = (
    "{'type': 'sensor.camera.rgb', 'x': %s, 'y': 0, 'z': 2, 'roll': 0, 'pitch': 0, 'yaw': 0, %s'id': 'a'}"
)
SIZE = "'width': 800, 'height': 600, 'fov': 100, "


def agent(entry: str, before: str = "") -> dict[str, str]:
    return {"agent.py": f"{before}\nclass A:\n    def sensors(self):\n        return [{entry}]\n"}


def test_poses_are_turned_from_carlas_axes_and_rays_are_the_leaderboards() -> None:
    read = read_files(CARLA_AGENT)
    camera, lidar = read.rig.sensors
    # CARLA: y to the right, positive pitch up, positive yaw to the right
    turned = Rotation.from_euler("xyz", (0.0, -5.0, 60.0), degrees=True)
    assert_same_pose(sensor_matrix(camera), transform(turned, (1.3, 0.5, 2.3)))
    assert isinstance(camera, Camera) and (camera.name, camera.image, camera.hfov_deg) == (
        "rgb_left",
        (960, 480),
        120,
    )
    assert isinstance(lidar, Lidar)
    beams = lidar.elevations()
    assert (beams.size, beams[0], beams[-1], lidar.azimuths().size) == (64, -30.0, 10.0, 938)
    assert lidar.range_m == (0.0, 85.0)
    assert has(read.report, "approximated", "as the leaderboard fixes them")
    assert has(read.report, "ignored", "neither camera nor LiDAR")


def test_sums_of_numbers_are_read_and_what_the_code_would_compute_is_told() -> None:
    (camera,) = read_files(agent(CAMERA % ("-1.5 + 2 * 0.25 + math.sin(math.pi) * 0", SIZE))).rig.sensors
    assert np.allclose(camera.position, (-1.0, 0.0, 2.0))
    files = agent(f"{CAMERA % ('self.x', SIZE)}, {CAMERA % ('1', SIZE)}")
    read = read_files(files)
    assert len(read.rig.sensors) == 1
    assert has(read.report, "ignored", "x would have to be computed by running the code")


def test_nothing_in_the_file_runs(tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    before = f"import os\nos.system('touch {mark}')\nopen({str(mark)!r}, 'w')\n"
    entry = CAMERA % (f"[open({str(mark)!r}, 'w'), 1.0][1]", SIZE)
    read = read_files(agent(f"{entry}, {CAMERA % ('1', SIZE)}", before))
    assert len(read.rig.sensors) == 1 and not mark.exists()


CONFIG = """\
import os
class GlobalConfig:
    camera_pos = [-1.5, 0.25, 2.0]
    twice = 1
    def __init__(self, **kwargs):
        self.camera_rot = [0.0, 0.0, -60.0]
        self.width: int = 640
        self.twice = 2
        self.lidar_pos = [float(x) for x in "123"]
        os.system("touch {mark}")
"""


def test_names_of_a_configuration_beside_the_agent_are_read_and_never_run(tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    entry = (CAMERA % ("self.config.camera_pos[0]", SIZE)).replace("'y': 0", "'y': config.camera_pos[1]")
    entry = entry.replace("'yaw': 0", "'yaw': self.config.camera_rot[-1]").replace("800", "self.config.width")
    left_out = (
        "self.config.lidar_pos[0]", "self.config.twice", "self.config.camera_pos[7]", "self.other.width",
        "self.config.camera_pos[True]", "self.config.width[0]", "self.config.nothing", "config",
    )  # fmt: skip
    others = [(CAMERA % (x, SIZE)).replace("'a'", f"'{number}'") for number, x in enumerate(left_out)]
    files = {**agent(", ".join([entry, *others])), "config.py": CONFIG.replace("{mark}", str(mark))}
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    read = read_rig(tmp_path / "agent.py")
    (camera,) = read.rig.sensors
    turned = Rotation.from_euler("z", 60.0, degrees=True)
    assert_same_pose(sensor_matrix(camera), transform(turned, (-1.5, -0.25, 2.0)))
    assert isinstance(camera, Camera) and camera.image == (640, 600) and not mark.exists()
    assert has(read.report, "read", "numbers of config.py") and has(read.report, "ignored", "left out: x")
    (tmp_path / "config.py").write_text("x = (\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"config\.py:1: not Python"):
        read_rig(tmp_path / "agent.py")


def test_literals_of_the_agent_itself_are_read_unless_they_are_changed() -> None:
    """As in agents of TransFuser: self.cam_config = {'width': 320, ...}."""
    before = """
class Base:
    def setup(self):
        self.cam = {'width': 320, 'size': [1, 2]}
        self.x, self.tall = 1, {'height': 7}
        self.tall['height'] = 8
        self.high: float = 2.5
        self.high += 1
        self.list[0] = 3
        width = 9
"""
    entry = (CAMERA % ("self.cam['size'][1]", SIZE)).replace("800", "self.cam['width']")
    left_out = (
        "self.x",
        "self.high",
        "self.tall['height']",
        "self.width",
        "self.cam",
        "self.cam['none']",
        "width",
    )
    others = [(CAMERA % (x, SIZE)).replace("'a'", f"'{number}'") for number, x in enumerate(left_out)]
    (camera,) = read_files(agent(", ".join([entry, *others]), before)).rig.sensors
    assert isinstance(camera, Camera) and camera.name == "a" and camera.position[0] == 2.0
    assert camera.image == (320, 600)


def test_a_radar_may_be_wider_than_high() -> None:
    radar = "{'type': 'sensor.other.radar', 'x': 2, 'y': -1.5, 'z': 0.5, %s, 'id': 'r'}"
    for fov, ends in (
        ("'horizontal_fov': 130, 'vertical_fov': 20", (65.0, 10.0)),
        ("'fov': 30", (15.0, 15.0)),
    ):
        (found,) = read_files(agent(radar % fov)).rig.sensors
        assert isinstance(found, Radar)
        (scan,) = found.scans
        assert (scan.azimuth_deg[1], scan.elevation_deg[1]) == ends


def test_of_several_agents_one_is_chosen() -> None:
    second = AGENT.replace("FirstAgent", "SecondAgent").replace("rgb_left", "rgb_right")
    files = {"agent.py": AGENT + second}
    assert read_files(files).rig.sensors[0].name == "rgb_left"
    assert read_files(files, options=ReadOptions(token="SecondAgent")).rig.sensors[0].name == "rgb_right"
    with pytest.raises(InputError, match=r"token: .*got 'Third'"):
        read_files(files, options=ReadOptions(token="Third"))


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("x = 'sensor.camera' +\n", ":1: not Python"),
        ("# sensor.camera\n", "at least one sensor$"),
        (
            agent(CAMERA % ("self.x", SIZE))["agent.py"],
            "one sensor; ignored: .*x would have to be computed .*[(]a[)]$",
        ),
        ("x = 'sensor.' + " + "(" * 300 + ")" * 300, "not Python"),
        ("x = 'sensor.' ; y = " + "-" * 5000 + "1", "not Python|no LiDAR"),
        (agent(CAMERA % ("1e999", SIZE))["agent.py"], "x: .*got inf"),
        (agent(CAMERA % ("'far'", SIZE))["agent.py"], "x: .*got far"),
        (agent(CAMERA % ("1", ""))["agent.py"], "width: missing"),
        (agent(CAMERA % ("1", SIZE.replace("800", "800000")))["agent.py"], "width: .*got 800000"),
        (agent(CAMERA % ("1", SIZE.replace("100", "400")))["agent.py"], "hfov_deg"),
    ],
)
def test_what_cannot_be_read_is_refused_in_one_line(text: str, complaint: str) -> None:
    with pytest.raises(InputError, match=complaint) as caught:
        read_files({"agent.py": text})
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 300


def test_python_says_nothing_about_its_style() -> None:
    """Python's parser warned on standard error; warnings fail the tests."""
    assert len(read_files(agent(CAMERA % ("1", SIZE), "x = 1or 2\ny = '\\d' is 1")).rig.sensors) == 1


def test_powers_are_not_computed() -> None:
    read = read_files(agent(f"{CAMERA % ('9**9**9', SIZE)}, {CAMERA % ('1', SIZE)}"))
    assert len(read.rig.sensors) == 1


def test_a_name_that_no_terminal_can_show_is_complained_about_in_one_that_it_can() -> None:
    with pytest.raises(InputError) as refused:
        read_files(agent((CAMERA % (0, SIZE)).replace("'a'", r"'\ud800'")))
    assert str(refused.value).isprintable()
