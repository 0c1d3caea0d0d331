"""Every field of a foreign file is accounted for: what may matter and is not used is named with its value."""

import json

import pytest

from riglens.core.errors import InputError
from riglens.core.formats.exchange import readable
from tests.core.formats.cases import PLACES, SMALL, WITH_COLUMNS, WITHOUT_NAMES, Files, read_files

FIELDS: dict[str, tuple[str, object]] = {
    "pose": ("mount_offset", [0.125, 0.0, 0.25]),
    "lens": ("distCoefs", [-0.375, 0.125, 0.0, 0.0]),
    "region": ("crop_window", [0, 0, 64, 48]),
    "rate": ("frameRate", 12.5),
    "unit": ("angle_unit", "degrees"),
    "kind": ("sensor_kind", "thermal"),
}


def with_field(case: str, key: str, value: object) -> Files:
    """Return the small files of a format with one more field in the record of a sensor."""
    name, marker, template = PLACES[case]
    assert marker in SMALL[case][name]
    text = value if case in ("urdf", "sdf") and isinstance(value, str) else json.dumps(value)
    field = template.replace("{key}", key).replace("{value}", str(text))
    return {**SMALL[case], name: SMALL[case][name].replace(marker, field + marker, 1)}


def test_all_formats_are_tried() -> None:
    tried = {name.removesuffix("-raw") for name in PLACES}
    assert tried | WITHOUT_NAMES | WITH_COLUMNS | {"riglens"} == set(readable())


@pytest.mark.parametrize("kind", FIELDS)
@pytest.mark.parametrize("case", PLACES)
def test_a_field_that_may_matter_is_named_with_its_value(case: str, kind: str) -> None:
    key, value = FIELDS[kind]
    read = read_files(with_field(case, key, value))
    (line,) = [line for line in read.report.lines() if f"'{key}'" in line]
    parts = value if isinstance(value, list) else [value]
    assert line.startswith("ignored") and all(
        f"{part:g}" if isinstance(part, float) else str(part) in line for part in parts
    )
    assert read.rig == read_files(SMALL[case]).rig


@pytest.mark.parametrize("case", PLACES)
def test_a_field_that_is_used_is_not_named(case: str) -> None:
    assert not any("is not used" in line for line in read_files(SMALL[case]).report.lines())


@pytest.mark.parametrize("case", PLACES)
def test_other_fields_are_named(case: str) -> None:
    lines = read_files(with_field(case, "mood", "calm")).report.lines()
    assert any("not used" in line and "mood" in line and "calm" not in line for line in lines)


def test_files_of_numbers_that_are_not_used_are_named() -> None:
    more = {**SMALL["boreas"], "T_imu_lidar.txt": "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"}
    lines = read_files(more).report.lines()
    assert any("not used" in line and "T_imu_lidar.txt" in line for line in lines)


def test_fields_without_end_are_listed_shortly() -> None:
    more = "".join(f"pose_{number}: {number}\n" for number in range(500))
    report = read_files({"front.yaml": SMALL["opencv"]["front.yaml"] + more}).report
    assert len(report.lines()) < 50 and "440 more" in report.text()


def test_our_own_files_refuse_unknown_fields() -> None:
    with pytest.raises(InputError, match="mount_offset"):
        read_files({"rig.yaml": "riglens: 1\nname: a\nmount_offset: 1\nsensors: []\n"})
