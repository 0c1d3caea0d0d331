"""Files made to do harm are refused in one line: bombs, loops, entities, pickles, wrong encodings, endless numbers."""

import gzip
import io
import json
import os
import pickle
import re
import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from riglens.core.errors import InputError
from riglens.core.formats import source
from riglens.core.formats.exchange import FORMATS, detect, read_rig, readable
from riglens.core.formats.source import (
    MAX_DOTS,
    MAX_JSON_BYTES,
    MAX_TEXT_BYTES,
    MAX_TOML_BYTES,
    MAX_YAML_BYTES,
    Source,
)
from tests.core.formats.cases import SMALL, read_files, write_files


def refusal(path: Path, name: str | None = None) -> str:
    """The one line with which a file is refused."""
    with pytest.raises(InputError) as caught:
        read_rig(path, name)
    line = str(caught.value)
    assert line.isprintable() and len(line) < 700
    return line


def test_yaml_anchors_tags_and_merge_keys_are_refused(tmp_path: Path) -> None:
    bomb = "a: &a [x, x]\nb: &b [*a, *a]\ncam0: {intrinsics: *b}\n"
    for number, text in enumerate((bomb, "cam0: !!python/object/apply:os.system [ls]\n", "cam0: {<<: *x}\n")):
        path = tmp_path / f"{number}.yaml"
        path.write_text(text, encoding="utf-8")
        assert "not accepted" in refusal(path, "kalibr")


@pytest.mark.parametrize("case", SMALL)
def test_a_file_without_content_is_named_where_it_is_refused(tmp_path: Path, case: str) -> None:
    for number, name in enumerate(SMALL[case]):
        folder = write_files(tmp_path / str(number) / "rig", SMALL[case] | {name: ""})
        path = folder / name if len(SMALL[case]) == 1 else folder
        try:
            read_rig(path, case.removesuffix("-raw"))
        except InputError as error:
            assert Path(name).name in str(error) or f"{path.name}:" in str(error), name


@pytest.mark.parametrize(
    "text",
    [
        '<!DOCTYPE robot [<!ENTITY a "b">]><robot name="&a;"/>',
        '<!DOCTYPE robot [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]><robot>&b;</robot>',
        '<!DOCTYPE robot SYSTEM "file:///etc/passwd"><robot/>',
        '<!DOCTYPE robot [<!ENTITY % p SYSTEM "http://x/y">%p;]><robot/>',
    ],
)
def test_document_types_and_entities_are_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.urdf"
    path.write_text(text, encoding="utf-8")
    assert "document types are not accepted" in refusal(path)


def test_deep_nesting_is_refused(tmp_path: Path) -> None:
    deep = {
        "a.json": '{"rig": ' + "[" * 100_000 + "]" * 100_000 + "}",
        "b.json": '{"a":' * 100_000 + "1" + "}" * 100_000,
        "c.urdf": "<robot>" + "<a>" * 10_000 + "</a>" * 10_000 + "</robot>",
        "d.toml": "a = " + "[" * 10_000 + "]" * 10_000,
        "e.yaml": "cam0: " + "[" * 90_000,
        "f.yaml": "\n".join(" " * depth + "a:" for depth in range(400)),
    }
    write_files(tmp_path, deep)
    for name in deep:
        assert "nested" in refusal(tmp_path / name, "kalibr" if name.endswith("yaml") else None)


def test_large_files_are_refused_before_they_are_parsed(tmp_path: Path) -> None:
    sizes = {
        "a.json": MAX_JSON_BYTES,
        "b.yaml": MAX_YAML_BYTES,
        "c.urdf": MAX_TEXT_BYTES,
        "d.toml": MAX_TOML_BYTES,
        "e.txt": MAX_TEXT_BYTES,
    }
    for name, limit in sizes.items():
        (tmp_path / name).write_bytes(b" " * (limit + 1))
        assert "too large" in refusal(tmp_path / name, "kalibr" if name.endswith("yaml") else None)
    (tmp_path / "calibrated_sensor.json.gz").write_bytes(gzip.compress(b" " * (MAX_JSON_BYTES + 1)))
    assert "too large" in refusal(tmp_path / "calibrated_sensor.json.gz")


def test_keys_of_very_many_parts_are_refused_unparsed(tmp_path: Path) -> None:
    """The parser's time grows with their square: 80 kB took 18 s."""
    (tmp_path / "a.toml").write_text("b = 1\na" + ".a" * 40_000 + " = 1\n", encoding="utf-8")
    assert "a.toml:2: too many dots" in refusal(tmp_path / "a.toml")
    numbers = ", ".join(["0.5"] * MAX_DOTS)
    (tmp_path / "b.toml").write_text(f"a = [{numbers}]\n", encoding="utf-8")
    assert Source(tmp_path / "b.toml").toml.item("a").numbers() == [0.5] * MAX_DOTS
    (tmp_path / "b.toml").write_text(f"a = [{numbers}, 0.5]\n", encoding="utf-8")
    assert "too many dots" in refusal(tmp_path / "b.toml")


def test_json_of_very_many_values_is_refused_unparsed(tmp_path: Path) -> None:
    """Empty lists take thirty times as much memory as text."""
    (tmp_path / "a.json").write_text("[" + "[]," * 1_000_000 + "[]]", encoding="utf-8")
    assert "at most 2000000" in refusal(tmp_path / "a.json")


def test_json_at_the_limit_of_values_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.json").write_text('{"x": [[1, 2], [3]]}', encoding="utf-8")  # five commas and brackets
    monkeypatch.setattr(source, "MAX_JSON_VALUES", 6)
    assert Source(tmp_path / "a.json").json.item("x").elements(2)
    monkeypatch.setattr(source, "MAX_JSON_VALUES", 5)
    assert "at most 5" in refusal(tmp_path / "a.json")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize("name", ["a.yaml", "a.json", "a.toml", "a.urdf", "calib.txt", "a.json.gz"])
def test_pipes_and_devices_are_refused_without_waiting(tmp_path: Path, name: str) -> None:
    os.mkfifo(tmp_path / name)
    assert "(got a pipe)" in refusal(tmp_path / name, "kitti" if name == "calib.txt" else None)
    (tmp_path / name).unlink()
    (tmp_path / name).symlink_to("/dev/zero")
    assert "(got a device)" in refusal(tmp_path / name, "kitti" if name == "calib.txt" else None)


def test_many_elements_are_refused(tmp_path: Path) -> None:
    for inner in (49_999, 50_000):
        (tmp_path / "a.urdf").write_text("<robot>" + "<a/>" * inner + "</robot>", encoding="utf-8")
        assert ("more than 50000 elements" in refusal(tmp_path / "a.urdf")) == (inner == 50_000)
    sensor = {"type": "sensor.lidar.ray_cast", "id": "l"}
    vehicle = {"type": "vehicle.a", "id": "ego", "sensors": [sensor] * 300}
    (tmp_path / "a.json").write_text(json.dumps({"objects": [vehicle]}), encoding="utf-8")
    assert "too many sensors (at most 255)" in refusal(tmp_path / "a.json")


@pytest.mark.parametrize("ending", [".json", ".yaml", ".toml", ".urdf", ".txt", ".json.gz"])
def test_pickles_and_wrong_encodings_are_refused(tmp_path: Path, ending: str) -> None:
    contents = (pickle.dumps({"rig": 1}), "{}".encode("utf-16"), b"\xff\xfe\x00", b"a\x00b", b"\x80abc", b"")
    for number, content in enumerate(contents):
        path = tmp_path / f"{number}{ending}"
        path.write_bytes(content)
        refusal(path)


def test_broken_gzip_is_refused(tmp_path: Path) -> None:
    whole = gzip.compress(SMALL["nuscenes"]["calibrated_sensor.json"].encode())
    for content in (whole[:40], b"no gzip", whole[:-9] + b"123456789"):
        (tmp_path / "calibrated_sensor.json.gz").write_bytes(content)
        assert "not a complete gzip file" in refusal(tmp_path / "calibrated_sensor.json.gz")


@pytest.mark.parametrize(
    ("case", "old", "new", "complaint"),
    [
        ("nuscenes", "[1.7, 0.0, 1.5]", "[1.7, NaN, 1.5]", r"numbers must be finite \(got NaN\)"),
        ("nuscenes", "[1.7, 0.0, 1.5]", "[1.7, 1e999, 1.5]", r"translation\[1\]: .*got inf"),
        ("nuscenes", "[1.7, 0.0, 1.5]", f"[1.7, {'9' * 4000}, 1.5]", r"translation\[1\]: .*got a very large number"),
        ("nuscenes", "[1.7, 0.0, 1.5]", f"[1.7, {'9' * 9000}, 1.5]", r"calibrated_sensor\.json: "),
        ("nuscenes", "[1.7, 0.0, 1.5]", '[1.7, "0", 1.5]', r"translation\[1\]: .*got 0"),
        ("nuscenes", "[1.7, 0.0, 1.5]", "[1.7, true, 1.5]", r"translation\[1\]: .*got True"),
        ("nuscenes", "[1.7, 0.0, 1.5]", "[1.7, 0.0]", "translation: .*got a list of 2"),
        ("nuscenes", "[0.5, -0.5, 0.5, -0.5]", "[0, 0, 0, 0]", "rotation: .*got length 0"),
        ("nuscenes", '"token": "a1"', '"token": "a1", "token": "a2"', "key 'token' is given twice"),
        ("nuscenes", '"s1", "translation"', '"s9", "translation"', "sensor_token: .*got s9"),
        ("autoware", "roll: -0.025", "roll: .nan", r"camera0/camera_link\.roll: .*got nan"),
        ("autoware", "gnss_link", "sensor_kit_base_link", "frame 'sensor_kit_base_link' has two parents"),
        ("autoware", "gnss_link: {x", "gnss_link: {X", r"gnss_link\.x: missing"),
        ("urdf", 'xyz="1 0 2"', 'xyz="1 0 nan"', "<origin>: .*got '1 0 nan'"),
        ("urdf", 'xyz="1 0 2"', 'xyz="1 0"', "<origin>: .*got '1 0'"),
        ("urdf", '<child link="mount"/>', '<child link="base_link"/>', "frame 'base_link' has two parents"),
        ("urdf", '<parent link="base_link"/>', '<parent link="puck"/>', "is its own ancestor"),
        ("urdf", '<child link="mount"/>', "", r"a joint needs <parent link=\.\.\.> and <child link=\.\.\.>"),
        ("urdf", "<samples>4</samples>", "<samples>1e9</samples>", "<samples>: .*got '1e9'"),
        ("urdf", "</robot>", "", r"rig\.urdf:32: not valid XML: no element found"),
        ("carla", '"channels": 32', '"channels": 0', "channels: .*got 0"),
        ("carla", '"fov": 90.0', '"fov": 180.0', r"sensor 'view': hfov_deg must be at most 179\.9 \(got 180\.0\)"),
        ("carla", '"points_per_second": 320000', '"points_per_second": 1e300', r"points_per_second: .*got 1e\+300"),
        ("carla-toml", "x = [-0.2, 0.4, -0.2, -0.2]", "x = [0]", r"lidar\.y: .*got a list of 4"),
        ("carla-toml", "channels = 16", "channels = 1.5", r"channels: .*got 1\.5"),
        ("carla-toml", "z = [2.2", "z = [inf", r"lidar\.z\[0\]: .*got inf"),
        ("carla-toml", "num = 4", "num = 4\nnum = 5", "Cannot overwrite a value"),
        ("driveworks", "[0.1, 0.4, 0.2]", "[0.1, 0.4]", "roll-pitch-yaw: .*got a list of 2"),
        ("driveworks", "0.000545421498827636", "-0.0005", "a lens whose image grows"),
        ("driveworks", "lidar:top", "lidar:\\ud800", "name: .*got 'lidar:.*ud800'"),
        ("driveworks", '"protocol": "lidar', '"\\ud800": "lidar', "a key is not UTF-8 text"),
        ("driveworks", '"width": "1920"', '"width": "1e9"', "width: .*got 1e9"),
        ("osi", '"x": 3.1', '"x": NaN', r"numbers must be finite \(got NaN\)"),
        ("osi", '"value": "7"', '"value": "7.5"', "value: must be an integer"),
        ("osi", '"fieldOfViewHorizontal": 1.0', '"fieldOfViewHorizontal": 7.0', r"fieldOfViewHorizontal: .*got 7\.0"),
        ("osi", '"fieldOfViewHorizontal": 1.0', '"fieldOfViewHorizontal": 0.0', "above 0 and at most 360 deg"),
        ("osi", '"numberOfRaysVertical": 32', '"numberOfRaysVertical": 1e9', "numberOfRaysVertical: .*got 1"),
        ("osi", '"range": 150.0', '"range": -1', "range: .*got -1"),
        ("kalibr", "[1.0, 0.0, 0.0, 0.3]", "[9.0, 0.0, 0.0, 0.3]", r"cam0\.T_cam_imu: .*got another matrix"),
        ("kalibr", "[0.0, 0.0, -1.0, 0.2]", "[0.0, 0.0, 1.0, 0.2]", "a rotation matrix, orthonormal and right-handed"),
        ("kalibr", "[752, 480]", "[752]", r"cam0\.resolution: .*got a list of 1"),
        ("kitti", "P2: 700", "P2: -700", "P2: .*got another matrix"),
        ("kitti", "P2: 700", "P2: 1e-320", "P2: .*got another matrix"),
        ("kitti", "R0_rect: 1 0", "R0_rect: 1", "R0_rect: .*got a list of 8"),
        ("kitti", "P3:", "P2:", "P2: given twice"),
        ("euroc", "[752, 480]", "[752]", r"resolution: .*got a list of 1"),
        ("euroc", "[0, 0, 1, 0.3", "[0, 0, 2, 0.3", "a rotation matrix, orthonormal and right-handed"),
        ("euroc-raw", "sensor_id: b0", "sensor_id: c0", "frame 'c0' has two parents"),
        ("euroc-raw", "cols: 4, data", "cols: 3, data", r"T_B_C\.cols: .*got 3"),
        ("euroc-raw", "image_width: 752", "image_width: .nan", r"image_width: .*got nan"),
        ("fast-livo", "[0.04, 0.02, -0.03]", "[0.04, 0.02]", r"extrinsic_T: .*got a list of 2"),
        ("fast-livo", "Rcl: [0, -1", "Rcl: [0, 1", r"Rcl: .*got another matrix"),
        ("apollo", "frame_id: novatel", "frame_id: front_6mm", "is its own ancestor"),
        ("apollo", "z: 0.7071067811865476", "z: 9", r"rotation: .*got length"),
        ("boreas", "0 0 0 1\n", "0 0 0\n", ".*got a list of 15"),
        ("boreas", "1475.6 0.0", "inf 0.0", ".*got inf"),
        ("kitti-360", "xi: 2.2", "xi: -9", "a lens whose image grows"),
        ("kitti-360", "gamma1: 1336.3", "gamma1: 0", "a lens with focal lengths in pixels"),
        ("kitti-360", "image_02: 1 0", "image_02: 1", r"image_02: .*got a list of 11"),
        ("airsim", '"FOV_Degrees": 100', '"FOV_Degrees": 400', "hfov_deg must be at most"),
        ("airsim", '"NumberOfChannels": 16', '"NumberOfChannels": 0.5', r"NumberOfChannels: .*got 0\.5"),
        ("airsim", '"Yaw": 30.0', '"Yaw": NaN', r"numbers must be finite \(got NaN\)"),
        ("mmdet3d", "[1266.4, 0.0, 816.3]", "[0.0, 0.0, 816.3]", r"cam2img: .*got another"),
        ("mmdet3d", "[1266.4, 0.0, 816.3]", "[1e-320, 0.0, 816.3]", r"cam2img: .*got another"),
        ("vlcal", "810.3829, ", "", "intrinsics: must be 4 numbers or more"),
        ("mmdet3d", "[0.0, 1266.4, 491.5]", "[1266.4, 1266.4, 491.5]", r"cam2img: .*got another"),
        ("mmdet3d", '"images": {', '"images": [], "x": {', r"images: .*got a list of 0"),
        ("opencv", "image_width: 1280", "image_width: 0", "image_width"),
        ("opencv", "[1000.5, 0,", "[1000.5,", "camera_matrix|a camera matrix of 9 numbers"),
        ("opencv", "1000.5", ".nan", "camera_matrix"),
        ("opencv", "-0.3, 0.1", "-0.3, x", "distortion_coefficients"),
        ("opencv", "image_height: 720\n", "", "image_height: missing"),
    ],
)  # fmt: skip
def test_wrong_values_are_refused_with_their_place(case: str, old: str, new: str, complaint: str) -> None:
    files = SMALL[case]
    name = next(name for name, text in files.items() if old in text)
    with pytest.raises(InputError) as caught:
        read_files({**files, name: files[name].replace(old, new, 1)})
    line = str(caught.value)
    assert re.search(complaint, line) and line.isprintable() and len(line) < 400


def test_a_long_chain_of_frames_is_followed_without_recursion(tmp_path: Path) -> None:
    count = sys.getrecursionlimit() + 500
    links = "".join(f'<link name="f{n}"/>' for n in range(count)) + '<link name="lidar"/>'
    ends = [*(f"f{n}" for n in range(count)), "lidar"]
    joints = "".join(
        f'<joint name="j{n}" type="fixed"><parent link="{one}"/><child link="{other}"/>'
        '<origin xyz="0 0 0.001"/></joint>'
        for n, (one, other) in enumerate(pairwise(ends))
    )
    (tmp_path / "a.urdf").write_text(f"<robot>{links}{joints}</robot>", encoding="utf-8")
    (lidar,) = read_rig(tmp_path / "a.urdf").rig.sensors
    assert lidar.position[2] == pytest.approx(count / 1000)


def recording(real: Callable[..., Any], opened: list[str]) -> Callable[..., Any]:
    """The same function, which notes the names of the files it is asked for."""

    def record(path: object, *arguments: object, **options: object) -> object:
        if not isinstance(path, int):  # a file that is open already
            opened.append(Path(str(path)).name)
        return real(path, *arguments, **options)

    return record


def test_files_that_a_urdf_names_are_not_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    path = write_files(tmp_path, SMALL["urdf"]) / "rig.urdf"
    monkeypatch.setattr(os, "open", recording(os.open, opened))
    monkeypatch.setattr(io, "open", recording(io.open, opened))  # Path.open calls this one
    imported = read_rig(path)
    assert set(opened) == {"rig.urdf"}
    assert "ignored: 1 meshes: they are not opened" in imported.report.lines()


def test_a_link_to_a_device_or_a_folder_of_another_kind_is_no_rig(tmp_path: Path) -> None:
    (tmp_path / "loop.json").symlink_to(tmp_path / "loop.json")
    (tmp_path / "folder.yaml").mkdir()
    for path in (tmp_path / "loop.json", tmp_path / "folder.yaml", tmp_path / "no.urdf"):
        refusal(path)


@pytest.mark.parametrize("format_", readable())
@pytest.mark.parametrize("content", ["- 1\n- 2\n", "5\n", "null\n"])
def test_yaml_that_is_not_a_mapping_is_refused_by_every_format(
    tmp_path: Path, format_: str, content: str
) -> None:
    (tmp_path / "rig.yaml").write_text(content, encoding="utf-8")
    with pytest.raises(InputError):
        read_rig(tmp_path / "rig.yaml", format_)


@pytest.mark.parametrize("case", SMALL)
def test_every_small_file_is_told_by_itself(case: str, tmp_path: Path) -> None:
    folder = write_files(tmp_path / "rig", SMALL[case])
    told = FORMATS[case.removesuffix("-raw")]
    if len(SMALL[case]) > 1:
        assert detect(Source(folder)) is told
    for name in SMALL[case]:
        is_camera = name in ("front_6mm_intrinsics.yaml", "image_02.yaml")  # a rig of its own, of one camera
        assert detect(Source(folder / name)) is (FORMATS["opencv"] if is_camera else told)
