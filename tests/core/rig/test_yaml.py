"""Rig files: what is written reads back to the same bits, and what is not edited stays byte for byte."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.library import default_library
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt, Lidar, LinearAngles, Rig, Sensor
from riglens.core.rig.presets import preset
from riglens.core.rig.yaml import file, nodes
from riglens.core.rig.yaml.file import dumps, load_rig, loads, new_rig_file, rig_sha256, same_rig
from riglens.core.rig.yaml.text import ordered_fields
from tests.core.rig.cases import rigs

CONTRACT = """\
riglens: 1                      # format version; a newer one is refused with a clear message
name: wide-trapezoid
vehicle: {body: sedan, length: 4.6, width: 1.9, height: 1.45, rear_axle_x: -1.35}   # metres
sensors:
  - name: lidar_left            # unique
    kind: lidar
    model: generic-16           # optional: entry of the sensor library; fields below override it
    position: [-0.4, 0.2, 2.2]  # metres, vehicle frame
    rpy_deg: [0.0, 0.0, 0.0]    # roll, pitch, yaw
    elevations_deg: {from: -25, to: 25, count: 16}    # or a list
    azimuths_deg: {from: -180, to: 180, count: 360}
    range_m: [0.0, 100.0]       # optional
    enabled: true               # optional
  - name: CAM_FRONT
    kind: camera
    position: [0.5, 0.0, 1.8]
    rpy_deg: [0.0, 0.0, 0.0]
    image: [1600, 900]          # native pixels
    hfov_deg: 70                # or fx, fy, cx, cy in pixels
    cast: [352, 128]            # ray lattice
"""


def test_the_documented_example_means_what_it_says() -> None:
    rig = loads(CONTRACT).rig
    lidar, camera = rig.sensors
    assert isinstance(lidar, Lidar) and isinstance(camera, Camera)
    assert (rig.name, rig.vehicle.body, rig.vehicle.rear_axle_x) == ("wide-trapezoid", "sedan", -1.35)
    assert lidar.position == (-0.4, 0.2, 2.2) and lidar.range_m == (0.0, 100.0) and lidar.enabled
    assert lidar.elevations_deg == LinearAngles(from_=-25.0, to=25.0, count=16)
    assert (camera.image, camera.hfov_deg, camera.cast) == ((1600, 900), 70.0, (352, 128))


@settings(max_examples=40)
@given(rigs())
def test_any_rig_reads_back_bit_for_bit(rig: Rig) -> None:
    text = dumps(rig)
    again = loads(text).rig
    assert again == rig
    assert same_rig(again, rig)
    assert dumps(again) == text


def test_the_bits_that_are_easily_lost_survive() -> None:
    position = (-0.0, 1e-17, 0.1 + 0.2)
    lidar = Lidar(name="a", position=position, elevations_deg=(5e-324, -0.0), range_m=(0.5, math.inf))
    text = dumps(Rig(sensors=(lidar,)))
    (again,) = loads(text).rig.sensors
    assert again.position == position and math.copysign(1.0, again.position[0]) == -1.0
    assert "position: [-0.0, 1.0e-17, 0.30000000000000004]" in text and "range_m: [0.5, .inf]" in text


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
@pytest.mark.parametrize("last", ["", "\n", "\n\n# the end\n"])
@pytest.mark.parametrize("bom", [b"", b"\xef\xbb\xbf"])
def test_load_and_save_without_an_edit_gives_the_same_bytes(
    tmp_path: Path, ends: str, last: str, bom: bytes
) -> None:
    text = CONTRACT.replace("[-0.4, 0.2, 2.2]", "[ -4e-1,0.20 , +2.2 ]").replace("CAM_FRONT", "'CAM_FRONT'")
    content = bom + (text.rstrip() + last).replace("\n", ends).encode()
    source, target = tmp_path / "in.yaml", tmp_path / "out.yaml"
    source.write_bytes(content)
    file = load_rig(source)
    assert file.rig.sensors[0].position == (-0.4, 0.2, 2.2)
    saved = file.save(target, file.rig)
    assert target.read_bytes() == content and source.read_bytes() == content
    assert (saved.path, saved.rig) == (target, file.rig)


def test_a_loaded_file_has_its_path_and_a_new_one_none(tmp_path: Path) -> None:
    new = new_rig_file(preset("W+T"))
    assert new.path is None
    saved = new.save(tmp_path / "a.yaml")
    assert saved.path == tmp_path / "a.yaml" and load_rig(tmp_path / "a.yaml").rig == preset("W+T")


def test_a_rig_made_by_drags_is_checked_and_saved_as_plain_numbers(tmp_path: Path) -> None:
    rig = preset("Center")
    numpy_pose = Pose((np.float64(0.25), 1, 2.0), (0.0, 0.0, 0.0))  # type: ignore[arg-type]
    dragged = rig.with_sensor("LIDAR_1", rig.sensor("LIDAR_1").with_pose(numpy_pose))
    assert "position: [0.25, 1.0, 2.0]" in dumps(dragged)
    broken = rig.with_sensor("LIDAR_2", rig.sensor("LIDAR_2").with_pose(Pose((0.0, math.nan, 0.0))))
    target = tmp_path / "rig.yaml"
    file = new_rig_file(rig).save(target)
    with pytest.raises(
        InputError, match=r'^lidar "LIDAR_2": position\[1\] must be a finite number \(got \.nan\)$'
    ):
        file.save(target, broken)
    assert load_rig(target).rig == rig


@pytest.mark.parametrize(
    ("model", "complaint"),
    [
        ("nonsense", "unknown sensor model 'nonsense'"),
        ("paper-camera-70", "is a camera, but this sensor is a lidar"),
    ],
)
def test_a_rig_that_could_not_be_read_back_is_not_written(model: str, complaint: str) -> None:
    lidar = Lidar(name="a", model=model, position=(0.0, 0.0, 2.0), elevations_deg=(0.0,))
    with pytest.raises(InputError, match=complaint):
        dumps(Rig(sensors=(lidar,)))


def test_a_rig_too_large_to_be_read_is_not_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (file, nodes):
        monkeypatch.setattr(module, "MAX_BYTES", 10_000)
        monkeypatch.setattr(module, "MAX_VALUES", 1_000)
    path = tmp_path / "rig.yaml"
    path.write_text("old", encoding="utf-8")
    beams = tuple(angle / 4000.0 + 1e-9 for angle in range(200))
    sensors = [Lidar(name=f"L{n}", position=(0.0, 0.0, 2.0), elevations_deg=beams) for n in range(6)]
    with pytest.raises(InputError, match=r"rig\.yaml: would be larger than 0\.01 MB"):
        new_rig_file(Rig(name="many", sensors=tuple(sensors))).save(path)
    flat = tuple(float(angle % 90) for angle in range(200))
    sensors = [sensor.replace(elevations_deg=flat) for sensor in sensors]
    with pytest.raises(InputError, match=r"rig\.yaml:\d+: more than 1000 values"):
        new_rig_file(Rig(name="many", sensors=tuple(sensors))).save(path)
    assert path.read_text(encoding="utf-8") == "old"
    few = Rig(name="many", sensors=tuple(sensors[:4]))
    assert same_rig(load_rig(new_rig_file(few).save(path).path or "").rig, few)


def sensor_of(fields: str) -> Sensor:
    return loads(f"riglens: 1\nsensors:\n  - {{name: a, position: [0, 0, 2], {fields}}}").rig.sensors[0]


def test_a_library_model_supplies_what_the_file_leaves_out() -> None:
    lidar = sensor_of("kind: lidar, model: velodyne-vlp-32c")
    assert isinstance(lidar, Lidar)
    assert lidar.elevations_deg == default_library().entry("velodyne-vlp-32c").fields["elevations_deg"]
    assert lidar.range_m == (0.0, 200.0) and lidar.azimuths().size == 1800


def test_fields_of_the_file_override_the_library_model() -> None:
    lidar = sensor_of("kind: lidar, model: velodyne-vlp-32c, range_m: [1, 50], elevations_deg: [3]")
    assert lidar.range_m == (1.0, 50.0) and lidar.ray_count == 1800


def test_a_lens_in_the_file_replaces_the_lens_of_the_library_model() -> None:
    camera = sensor_of("kind: camera, model: paper-camera-70, fx: 900, fy: 900, cx: 800, cy: 450")
    assert isinstance(camera, Camera) and camera.intrinsics_px() == (900.0, 900.0, 800.0, 450.0)
    camera = sensor_of("kind: camera, model: pandaset-front, hfov_deg: 90")
    assert isinstance(camera, Camera) and camera.intrinsics_px()[0] == pytest.approx(960.0)
    camera = sensor_of("kind: camera, model: pandaset-front, fx: 1000")
    assert isinstance(camera, Camera) and camera.intrinsics_px() == (1000.0, 1970.0091, 970.0002, 483.2988)


def test_the_hash_depends_on_what_a_rig_says_and_not_on_how_it_is_written() -> None:
    rig = loads(CONTRACT).rig
    assert rig_sha256(rig) == rig_sha256(loads(dumps(rig)).rig)
    assert rig_sha256(rig) == "318a5330d16e611627543a3041df9c945037b072d9c618558919e5a595c201b1"
    hashes = {rig_sha256(preset(name)) for name in ("W+T", "W+C", "N+T", "Wide", "Line", "Line-roll")}
    assert len(hashes) == 6
    dragged = rig.with_sensor("CAM_FRONT", rig.sensor("CAM_FRONT").with_pose(Pose((0.5, -0.0, 1.8))))
    assert rig_sha256(dragged) != rig_sha256(rig)


BENT = """\
riglens: 1
sensors:
  - name: cam          # calibrated in May
    kind: camera
    position: [0, 0, 2]
    fx: 900
    fy: 900
    cx: 800
    cy: 450
    distortion: {model: brown_conrady, k1: -0.30, p1: 1e-3}  # rms 0.2 px
"""


def test_saving_changes_only_the_coefficient_that_changed() -> None:
    file = loads(BENT)
    camera = file.rig.sensor("cam")
    assert isinstance(camera, Camera) and camera.distortion == BrownConrady(k1=-0.3, p1=1e-3)
    assert file.updated(file.rig.replace(name="other")).text.endswith(BENT.partition("sensors:")[2])
    for lens, line in (
        (BrownConrady(k1=-0.25, p1=1e-3), "{model: brown_conrady, k1: -0.25, p1: 1e-3}  # rms 0.2 px"),
        (BrownConrady(k1=-0.3), "{model: brown_conrady, k1: -0.30, p1: 0.0}  # rms 0.2 px"),
        (
            BrownConrady(k1=-0.3, p1=1e-3, k6=2.0),
            "{model: brown_conrady, k1: -0.30, p1: 1e-3, k6: 2.0}  # rms 0.2 px",
        ),
        (
            KannalaBrandt(k1=0.5),
            "{model: kannala_brandt, k1: 0.5, k2: 0.0, k3: 0.0, k4: 0.0}  # rms 0.2 px",
        ),
    ):
        saved = file.updated(file.rig.with_sensor("cam", camera.replace(distortion=lens))).text
        assert saved == BENT.replace("{model: brown_conrady, k1: -0.30, p1: 1e-3}  # rms 0.2 px", line)
    without = file.updated(file.rig.with_sensor("cam", camera.replace(distortion=None))).text
    assert "distortion" not in without and "# calibrated in May" in without


def test_every_field_of_the_model_is_written() -> None:
    for sensor in loads(CONTRACT).rig.sensors:
        assert ordered_fields(sensor).keys() == type(sensor).model_fields.keys()


def test_how_a_mesh_is_placed_survives_a_save_and_is_only_said_where_it_matters() -> None:
    text = "riglens: 1\nvehicle: {body: car.glb, mesh: {scale: 0.001, offset: [0, 0, -0.1]}} # own car\n"
    file = loads(text)
    placement = file.rig.vehicle.mesh
    assert (placement.scale, placement.rpy_deg, placement.offset) == (0.001, (0, 0, 0), (0, 0, -0.1))
    assert loads(dumps(file.rig)).rig == file.rig
    turned = file.rig.replace(
        vehicle=file.rig.vehicle.replace(mesh=placement.replace(rpy_deg=(0.0, 0.0, 90.0)))
    )
    changed = file.updated(turned)
    assert loads(changed.text).rig == turned and "# own car" in changed.text
    assert "mesh" not in dumps(preset("W+T"))
    empty = loads("riglens: 1\nvehicle: {mesh: {}}\n")
    assert loads(empty.updated(turned).text).rig == turned


@pytest.mark.parametrize(
    ("mesh", "said"),
    [
        ("{size: 2}", r"vehicle\.mesh\.size is not a known field; known are scale, rpy_deg, offset"),
        ("{scale: 0}", r"vehicle\.mesh\.scale must be at least 0\.000001 \(got 0\)"),
        ("{rpy_deg: [0, 0]}", r"vehicle\.mesh\.rpy_deg\[2\] is missing"),
        ("null", r"vehicle\.mesh must be a mapping \(got nothing\)"),
    ],
)
def test_a_mesh_placed_wrongly_is_refused_with_its_field(mesh: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        loads(f"riglens: 1\nvehicle: {{mesh: {mesh}}}\n")


def test_the_rig_says_whether_its_body_stops_rays_and_keeps_it_when_edited_and_saved() -> None:
    plain = loads(CONTRACT)
    assert plain.rig.self_occlusion and "self_occlusion" not in dumps(plain.rig)
    for line in ("self_occlusion: false", "body: ignored"):
        file = loads(CONTRACT.replace("vehicle:", f"{line}\nvehicle:", 1))
        assert file.rig == plain.rig.replace(self_occlusion=False) and file.rig.body == "ignored"
        assert rig_sha256(file.rig) != rig_sha256(plain.rig)
        renamed = file.updated(file.rig.replace(name="other"))
        assert "self_occlusion: false\n" in renamed.text and "# native pixels" in renamed.text
        assert loads(file.updated(plain.rig).text).rig.body == "blocks"
    assert "self_occlusion: false\nvehicle:" in plain.updated(plain.rig.replace(self_occlusion=False)).text
    assert "self_occlusion: false" in dumps(preset("W+T"))


@pytest.mark.parametrize(
    ("lines", "where"),
    [
        ("body: solid", ":3: body must be ignored or blocks"),
        ("self_occlusion: ignored", ":3: self_occlusion must be true or false"),
        ("body: blocks\nself_occlusion: true", "specify only one of them"),
    ],
)
def test_a_wrong_body_is_refused(lines: str, where: str) -> None:
    with pytest.raises(InputError, match=where):
        loads(CONTRACT.replace("vehicle:", f"{lines}\nvehicle:", 1))


@pytest.mark.parametrize("name", ["\f", "a\x1cb", "\x85", "\u2028"])
def test_a_name_that_would_end_a_line_of_text_stays_whole(name: str, tmp_path: Path) -> None:
    rig = Rig(sensors=(Lidar(name=name, position=(0.0, 0.0, 2.0), elevations_deg=(0.0,)),))
    new_rig_file(rig).save(tmp_path / "rig.yaml")
    edited = rig.with_sensor(name, rig.sensors[0].replace(position=(0.0, 0.0, 2.5)))
    load_rig(tmp_path / "rig.yaml").save(tmp_path / "rig.yaml", edited)
    assert load_rig(tmp_path / "rig.yaml").rig == edited
