"""Saving an edited rig: what changed is rewritten, every other character of the file stays."""

import difflib
from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.geometry import Pose
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import Lidar, LinearAngles, Rig, Sensor
from riglens.core.rig.yaml.edit import edited_text
from riglens.core.rig.yaml.file import loads, same_rig
from riglens.core.rig.yaml.nodes import value_text
from riglens.core.rig.yaml.text import plain_fields, rig_text, written_fields
from tests.core.rig.cases import rigs

FILE = """\
# Rig of the yellow van, measured in March
riglens: 1
name: "yellow van"   # painted
vehicle:
  body: van
  length: 5.30       # with bumper

sensors:
  # ---- LiDARs ----

  # the old one
  - name: left       # needs cleaning
    kind: lidar
    model: generic-16
    position: [ 1.50,  +0.8 , 2e0 ]   # tape measure
    # range_m: [0, 80]

  - name: right
    kind: lidar
    position:
      - 1.50
      - -0.80        # mirrored
      - 2.0
    elevations_deg: {from: -25,   to: 25, count: 16}

  # ---- cameras ----

  # behind the mirror
  - {name: cam, kind: camera, position: [0.5, 0, 1.8], hfov_deg: 70, cast: [352, 128]}  # new

# end of file
"""
RIG = loads(FILE).rig
LEFT, RIGHT, CAM = RIG.sensors


def saved(rig: Rig, text: str = FILE) -> str:
    """The text of the file after a save; it must say the rig without falling back to a fresh layout."""
    file = loads(text)
    edited = edited_text(text, file.rig, rig)
    assert same_rig(loads(edited).rig, rig)
    assert file.updated(rig).text == edited
    return edited


def changes(rig: Rig, text: str = FILE) -> list[str]:
    """The lines that went and came by a save."""
    lines = difflib.ndiff(text.splitlines(), saved(rig, text).splitlines())
    return [line for line in lines if line[0] in "+-"]


def with_sensor(which: str, **fields: object) -> Rig:
    return RIG.with_sensor(which, RIG.sensor(which).replace(**fields))


def with_sensors(*sensors: Sensor) -> Rig:
    return RIG.replace(sensors=sensors)


def test_one_number_changes_only_its_own_characters() -> None:
    rig = with_sensor("left", position=(1.5, 0.8, 2.25))
    assert saved(rig) == FILE.replace("2e0 ]", "2.25 ]")
    rig = with_sensor("right", position=(1.5, -0.7, 2.0))
    assert saved(rig) == FILE.replace("-0.80        # mirrored", "-0.7        # mirrored")
    rig = with_sensor("right", elevations_deg=LinearAngles(from_=-25.0, to=15.0, count=16))
    assert saved(rig) == FILE.replace("to: 25,", "to: 15.0,")
    rig = with_sensor("cam", hfov_deg=110.0)
    assert saved(rig) == FILE.replace("hfov_deg: 70,", "hfov_deg: 110.0,")
    assert saved(RIG.replace(name="green van")) == FILE.replace('"yellow van"', "green van")
    assert saved(RIG.replace(vehicle=RIG.vehicle.replace(length=5.0))) == FILE.replace("5.30 ", "5.0 ")


def test_the_last_field_in_braces_goes_alone() -> None:
    assert saved(with_sensor("cam", cast=None)) == FILE.replace(", cast: [352, 128]", "")


def test_the_sign_of_zero_is_a_change() -> None:
    rig = with_sensor("cam", position=(0.5, -0.0, 1.8))
    assert saved(rig) == FILE.replace("[0.5, 0, 1.8]", "[0.5, -0.0, 1.8]")


def test_a_field_that_was_not_there_is_added_at_its_place() -> None:
    rig = with_sensor("left", rpy_deg=(0.0, 5.0, 0.0))
    assert changes(rig) == ["+     rpy_deg: [0.0, 5.0, 0.0]"]
    assert "# tape measure\n    rpy_deg: [0.0, 5.0, 0.0]\n    # range_m" in saved(rig)
    assert changes(with_sensor("right", enabled=False)) == ["+     enabled: false"]
    rig = with_sensor("cam", rpy_deg=(0.0, 0.0, 5.0))
    assert saved(rig) == FILE.replace("[0.5, 0, 1.8],", "[0.5, 0, 1.8], rpy_deg: [0.0, 0.0, 5.0],")
    rig = RIG.replace(vehicle=RIG.vehicle.replace(rear_axle_x=-1.6))
    assert changes(rig) == ["+   rear_axle_x: -1.6"]


def test_what_the_library_model_supplies_is_not_written_into_the_file() -> None:
    assert (
        "elevations_deg" not in saved(with_sensor("left", position=(0.0, 0.0, 3.0))).split("name: right")[0]
    )
    other = sensor_from_model("ouster-os1-128", "left", LEFT.pose)
    assert saved(RIG.with_sensor("left", other)) == FILE.replace("model: generic-16", "model: ouster-os1-128")
    rig = with_sensor("left", elevations_deg=(1.0, 2.0))
    assert changes(rig) == ["+     elevations_deg: [1.0, 2.0]"]


def test_a_lens_said_in_another_way_replaces_the_old_way() -> None:
    rig = with_sensor("cam", hfov_deg=None, fx=900.0, fy=901.0, cx=800.0, cy=450.0)
    matrix = "fx: 900.0, fy: 901.0, cx: 800.0, cy: 450.0"
    assert saved(rig) == FILE.replace("hfov_deg: 70, ", "").replace("1.8], cast", f"1.8], {matrix}, cast")
    assert loads(saved(rig)).updated(RIG).rig == RIG


def test_leaving_the_library_writes_out_what_it_supplied() -> None:
    removed, *added = changes(with_sensor("left", model=None))
    assert removed == "-     model: generic-16"
    assert added == [
        "+     elevations_deg: {from: -25.0, to: 25.0, count: 16}",
        "+     range_m: [0.0, 100.0]",
    ]


def test_angles_may_change_their_shape() -> None:
    rig = with_sensor("right", elevations_deg=(-1.0, 0.0, 1.0))
    assert saved(rig) == FILE.replace("{from: -25,   to: 25, count: 16}", "[-1.0, 0.0, 1.0]")
    listed = FILE.replace("{from: -25,   to: 25, count: 16}", "\n    - 1\n    - 2   # two")
    rig = loads(listed).rig.with_sensor("right", RIGHT)
    assert saved(rig, listed) == FILE.replace("-25,   to: 25,", "-25.0, to: 25.0,").replace(
        "16}", "16}   # two"
    )


def test_a_renamed_sensor_keeps_its_comments() -> None:
    assert saved(with_sensor("left", name="front")) == FILE.replace("name: left ", "name: front ")


def test_a_deleted_sensor_takes_only_its_own_comments_with_it() -> None:
    own = FILE[FILE.index("  # the old one") : FILE.index("  - name: right")]
    assert saved(with_sensors(RIGHT, CAM)) == FILE.replace(own, "")
    own = FILE[FILE.index("  - name: right") : FILE.index("  # ---- cameras")]
    assert saved(with_sensors(LEFT, CAM)) == FILE.replace(own, "")
    own = FILE[FILE.index("  # behind") : FILE.index("\n# end")]
    assert saved(with_sensors(LEFT, RIGHT)) == FILE.replace(own, "")


def test_an_added_sensor_goes_where_it_stands_in_the_rig() -> None:
    new = Lidar(name="top", position=(0.0, 0.0, 3.0), elevations_deg=(0.0, 1.0))
    text = saved(with_sensors(LEFT, RIGHT, CAM, new))
    added = "  - name: top\n    kind: lidar\n    position: [0.0, 0.0, 3.0]\n    rpy_deg: [0.0, 0.0, 0.0]\n"
    added += "    elevations_deg: [0.0, 1.0]\n    azimuths_deg: {from: -180.0, to: 180.0, count: 360}\n"
    assert text == FILE.replace("# new\n", f"# new\n\n{added}") or text == FILE.replace(
        "# new\n", f"# new\n{added}"
    )
    for place in range(4):
        sensors = list(RIG.sensors)
        sensors.insert(place, new)
        assert all(change[0] == "+" for change in changes(with_sensors(*sensors)))


def test_a_duplicated_sensor_adds_lines_and_changes_none() -> None:
    for sensor in RIG.sensors:
        copy = sensor.replace(name=f"{sensor.name} copy")
        rig = with_sensors(*RIG.sensors, copy)
        assert all(change[0] == "+" for change in changes(rig))


def test_reordered_sensors_take_their_comments_along() -> None:
    text = saved(with_sensors(RIGHT, LEFT, CAM))
    assert sorted(text.splitlines()) == sorted(FILE.splitlines())
    assert "  # the old one\n  - name: left       # needs cleaning" in text
    assert "    # range_m: [0, 80]\n\n  # ---- cameras ----\n" in text
    assert saved(RIG, text) == FILE


def test_all_sensors_may_go_and_come_back() -> None:
    empty = saved(with_sensors())
    assert "sensors: []\n" in empty and "# ---- cameras ----" in empty and "# end of file" in empty
    again = saved(RIG, empty)
    assert "# end of file" in again and "# Rig of the yellow van" in again


@pytest.mark.parametrize(
    "text", ["riglens: 1", "riglens: 1\nsensors: []", "{riglens: 1}", "{riglens: 1, sensors: []}"]
)
def test_a_file_without_sensors_gets_its_first(text: str) -> None:
    rig = Rig(sensors=(LEFT, CAM))
    assert saved(rig, text).startswith(text[:11].rstrip("}"))
    assert saved(rig, f"{text}   # comment\n").count("# comment\n") == 1


def block_layout(rig: Rig) -> str:
    """Lists and mappings in block style, without indentation of lists where YAML allows it."""
    lines = ["riglens: 1", f"name: {value_text(rig.name)}", "vehicle:"]
    lines += [f"    {key}: {value_text(value)}" for key, value in plain_fields(rig.vehicle).items()]
    lines.append("sensors:" if rig.sensors else "sensors: []  # none")
    for index, sensor in enumerate(rig.sensors):
        lines += ["", f"# own comment {index}", "-"]
        for key, value in written_fields(sensor).items():
            if isinstance(value, tuple):
                lines += [f"   {key}:", *(f"   - {value_text(item)}  # {key}" for item in value)]
            elif isinstance(value, dict):
                lines += [
                    f"   {key}:",
                    *(f"      {name}: {value_text(item)}" for name, item in value.items()),
                ]
            else:
                lines.append(f"   {key}: {value_text(value)}   # {key}")
    return "\n".join(lines)


def flow_layout(rig: Rig) -> str:
    """Everything in braces and brackets over several lines."""
    sensors = ",\n   ".join(value_text(written_fields(sensor)) for sensor in rig.sensors)
    vehicle = value_text(plain_fields(rig.vehicle))
    return (
        f"{{riglens: 1,\n name: {value_text(rig.name)}, vehicle: {vehicle},\n sensors: [{sensors}]}} # all\n"
    )


LAYOUTS: list[Callable[[Rig], str]] = [
    rig_text,
    block_layout,
    flow_layout,
    lambda rig: rig_text(rig).replace("\n", "\r\n"),
    lambda rig: rig_text(rig).replace("\n", "   # note\n\n"),
]
FEW_NAMES = st.sampled_from(["a", "b", "c", "d", "e"])


@settings(max_examples=15)
@given(rigs(FEW_NAMES), rigs(FEW_NAMES), st.sampled_from(LAYOUTS), st.data())
def test_any_file_can_be_edited_into_any_rig(
    old: Rig, new: Rig, layout: Callable[[Rig], str], data: st.DataObject
) -> None:
    common = {sensor.name for sensor in old.sensors} & {sensor.name for sensor in new.sensors}
    kept = tuple(
        old.sensor(sensor.name) if sensor.name in common and data.draw(st.booleans()) else sensor
        for sensor in new.sensors
    )
    saved(new.replace(sensors=kept), layout(old))


@settings(max_examples=15)
@given(rigs(FEW_NAMES), st.sampled_from(LAYOUTS), st.data())
def test_reordering_and_moving_back_restores_the_text(
    rig: Rig, layout: Callable[[Rig], str], data: st.DataObject
) -> None:
    text = layout(rig)
    shuffled = rig.replace(sensors=tuple(data.draw(st.permutations(rig.sensors))))
    assert saved(rig, saved(shuffled, text)) == text


def test_a_drag_leaves_all_other_text_alone() -> None:
    moved = RIG.with_sensor("cam", CAM.with_pose(Pose((0.5, 0.1, 1.8), CAM.rpy_deg)))
    assert saved(moved) == FILE.replace("[0.5, 0, 1.8]", "[0.5, 0.1, 1.8]")
