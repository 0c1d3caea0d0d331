"""The TOML of the published placement code: sets are alternatives in degrees, and what is written fits its programs."""

import tomllib
from pathlib import Path

import pytest

from riglens.core.errors import InputError
from riglens.core.formats.exchange import read_rig
from riglens.core.formats.mounts import ReadOptions
from tests.core.formats.cases import SMALL, lidar, read_files, rig_of, written
from tests.core.formats.test_reports import has

SETS = {
    "four.toml": """\
[lidar]
sets = 2
num = [1, 2]
GLOBAL_HEIGHT_POS = 1.8
channels = [[32.0], [16.0, 16.0]]
lower_fov = -25.0
upper_fov = [5.0, 2.0]
x = [[0.0], [0.5, -0.5]]
y = [[0.0], [0.3, -0.3]]
z = [[2.0], [1.8, 1.9]]
roll = [[0.0], [20.0, -20.0]]
pitch = [[0.0], [10.0, 0.0]]
"""
}


def test_one_set_is_read_and_roll_and_pitch_are_degrees() -> None:
    first = read_files(SETS)
    assert [(sensor.position, sensor.rpy_deg) for sensor in first.rig.sensors] == [
        ((0.0, 0.0, 2.0), (0.0, 0.0, 0.0))
    ]
    assert has(first.report, "read", "set 1 of 2", "token") and has(first.report, "read", "degrees")
    second = read_files(SETS, options=ReadOptions(token="2"))
    assert [(sensor.position, sensor.rpy_deg) for sensor in second.rig.sensors] == [
        ((0.5, -0.3, 1.8), (20.0, -10.0, 0.0)),
        ((-0.5, 0.3, 1.9), (-20.0, 0.0, 0.0)),
    ]
    assert [sensor.elevations().max() for sensor in second.rig.enabled_lidars()] == [2.0, 2.0]
    assert first.rig.name != second.rig.name


def test_a_set_holds_as_many_lidars_as_num_says(tmp_path: Path) -> None:
    fewer = {"four.toml": SETS["four.toml"].replace("num = [1, 2]", "num = [1, 1]")}
    assert len(read_files(fewer, options=ReadOptions(token="2")).rig.sensors) == 1
    (tmp_path / "a.toml").write_text(
        SETS["four.toml"].replace("num = [1, 2]", "num = [2, 2]"), encoding="utf-8"
    )
    with pytest.raises(InputError, match=r"lidar.num\[0\]: .*got 2"):
        read_rig(tmp_path / "a.toml")


def test_another_set_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(SETS["four.toml"], encoding="utf-8")
    for token in ("0", "3", "x"):
        with pytest.raises(InputError, match=f"token from 1 to 2 .*got set '{token}'"):
            read_rig(tmp_path / "a.toml", options=ReadOptions(token=token))


def test_flat_lists_stay_one_rig_in_radians() -> None:
    imported = read_files(SMALL["carla-toml"])
    assert len(imported.rig.enabled_lidars()) == 4 and has(imported.report, "read", "radians")
    assert imported.rig.sensor("lidar_3").rpy_deg[0] == pytest.approx(16.0428, abs=1e-3)


def test_one_rig_is_written_as_one_set() -> None:
    one, other = ((0.5, 0.25, 1.75), (10.0, 5.0, 0.0)), ((-0.5, 0.25, 1.85), (0.0, 0.0, 0.0))
    (text,) = written("carla-toml", rig_of(lidar("a", one), lidar("b", other))).values()
    table = tomllib.loads(text)["lidar"]
    assert (table["sets"], table["num"], table["GLOBAL_HEIGHT_POS"]) == (1, [2], 1.75)
    assert table["x"] == [[0.5, -0.5]] and table["roll"] == [[10.0, 0.0]] and table["pitch"] == [[-5.0, 0.0]]
    for key in (
        "channels",
        "lower_fov",
        "upper_fov",
        "lidar_range_in_meters",
        "rotation_frequency",
        "points_per_channel",
    ):
        assert [len(row) for row in table[key]] == table["num"]
