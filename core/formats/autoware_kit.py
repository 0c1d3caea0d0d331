"""Read the files next to an Autoware kit's calibration: the xacro that chains the sensors, and the vehicle's size.

Xacro is read as the XML that it is: calls such as <xacro:VLP-16 name="velodyne_top" .../> tell the macro of a frame.
Nothing is expanded, included or computed. vehicle_info.param.yaml gives lengths in metres; base_link is its rear axle.
Source: Autoware documentation, "Creating sensor and vehicle models", "Vehicle dimensions".
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from riglens.core.errors import InputError
from riglens.core.formats.frames import SensorKind, kind_of
from riglens.core.formats.mounts import find_model
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Source, Value
from riglens.core.formats.xml_tree import Element
from riglens.core.rig.model import Vehicle
from riglens.core.rig.yaml.nodes import shortened, shown_path, value_text

VEHICLE_INFO = "vehicle_info.param.yaml"
_CALL = "xacro:"
_OWN_TAGS = frozenset(
    f"{_CALL}{word}"
    for word in (
        "macro",
        "include",
        "arg",
        "property",
        "if",
        "unless",
        "insert_block",
        "call",
        "element",
        "attribute",
    )
)
_ROW = re.compile(r"\['([^'\[\]]{1,200})'\]\['x'\]")
_FRAME_ENDINGS = ("", "_base_link", "_link")
_PLAIN_FOLDERS = ("config", "default", "urdf", "param", "params", "calibration")
_INFO_PLACES = ("", "config/", "../", "../config/")
_INFO_PACKAGES = ("../*vehicle_description/config/", "../../*vehicle_description/config/")
_LENGTHS = ("wheel_base", "wheel_tread", "front_overhang", "rear_overhang", "left_overhang", "right_overhang")
_MOST_FILES = 64
_MOST_CALLS = 10_000


def kit_name(source: Source) -> str:
    """Return the name of the kit: its folder, with the vehicle's where several vehicles have the same kit."""
    folder = source.folder.resolve()
    while folder.name.lower() in _PLAIN_FOLDERS and folder.parent != folder:
        folder = folder.parent
    kit = folder.name.removesuffix("_description") or folder.name
    vehicle = folder.parent.name
    is_of_vehicle = folder.parent.parent.name == "config" and vehicle not in _PLAIN_FOLDERS
    return shortened(f"{kit} {vehicle}" if is_of_vehicle else kit, 100)


def find_macros(source: Source, notes: Notes, kit: Path | None = None) -> dict[str, str]:
    """Return the macro that the kit's xacro calls for a frame, by the frame's possible names.

    `kit` is the folder of its description, where the xacro does not lie beside the calibration.
    """
    macros: dict[str, str] = {}
    files = _xacro_files(kit or source.folder)
    if kit is not None and not files:
        raise InputError(
            f"must be a folder with xacro files, or one whose urdf/ has some (got {shown_path(kit)})", "kit"
        )
    for path in files:
        try:
            calls = list(_calls(source.another(path).xml))[:_MOST_CALLS]
        except InputError:
            notes.ignored("xacro that cannot be read as XML", path.name)
            continue
        macros |= dict(calls)
    if macros:
        notes.read("kinds of sensors from the kit's xacro, which is not expanded")
    return macros


def _xacro_files(folder: Path) -> list[Path]:
    """Return the xacro files next to the calibration, or in the urdf/ of its package."""
    places = (folder, folder / "urdf", folder.parent / "urdf")
    found = [path for place in places if place.is_dir() for path in sorted(place.glob("*.xacro"))]
    return [path for path in found if path.is_file()][:_MOST_FILES]


def _calls(root: Element) -> Iterator[tuple[str, str]]:
    """Yield frame and macro of every call: frames by its name, and those whose row of the calibration it takes."""
    for element in root.walk():
        name = element.attributes.get("name", "")
        if not element.tag.startswith(_CALL) or element.tag in _OWN_TAGS or not name:
            continue
        macro = element.tag.removeprefix(_CALL)
        if "$" not in name:
            yield from ((f"{name}{ending}", macro) for ending in _FRAME_ENDINGS)
        values = [
            *element.attributes.values(),
            *(v for child in element.children for v in child.attributes.values()),
        ]
        yield from ((frame, macro) for value in values for frame in _ROW.findall(value))


def kind_of_macro(macro: str) -> SensorKind | None:
    """Return the kind of sensor that a macro makes, None for any other macro."""
    return kind_of(macro) or ("lidar" if find_model(macro) is not None else None)


def find_vehicle(source: Source, notes: Notes) -> Vehicle | None:
    """Return the vehicle of vehicle_info.param.yaml next to the kit, in its config/ or in the one vehicle package."""
    paths = [source.folder / place / VEHICLE_INFO for place in _INFO_PLACES]
    found = [path for path in paths if path.is_file()][:1]
    if not found:
        found = [path for place in _INFO_PACKAGES for path in source.folder.glob(place + VEHICLE_INFO)]
    if len(found) > 1:
        notes.ignored(f"{len(found)} files of that name next to the kit: none is used", VEHICLE_INFO)
    return _vehicle(source.another(found[0]), notes) if len(found) == 1 else None


def _vehicle(info: Source, notes: Notes) -> Vehicle | None:
    """Return the vehicle; None, and a remark, when the file lacks a length."""
    value: Value | None = info.yaml
    for key in ("/**", "ros__parameters"):
        inner = value.get(key) if value is not None and value.is_mapping else None
        value = inner if inner is not None else value
    if value is None or not all(key in value for key in (*_LENGTHS, "vehicle_height")):
        notes.ignored(f"a length is missing among {', '.join(_LENGTHS)}, vehicle_height", VEHICLE_INFO)
        return None
    base, tread, front, rear, left, right = (value.item(key).number(0.0, 50.0) for key in _LENGTHS)
    height = value.item("vehicle_height").number(0.1, 50.0)
    length, width = round(front + base + rear, 9), round(left + tread + right, 9)
    if not (0.1 <= length <= 100.0 and 0.1 <= width <= 100.0):
        value.refuse("lengths of a vehicle from 0.1 to 100 m", f"{length:g} x {width:g} m")
    rear_axle_x = round(rear - length / 2.0, 9)
    notes.read(
        f"{VEHICLE_INFO}: {length:g} x {width:g} x {height:g} m, rear axle at x = {rear_axle_x:g} m from the middle"
    )
    return Vehicle(length=length, width=width, height=height, rear_axle_x=rear_axle_x)


_SIDE = 0.08
"""Share of the width beyond the middle of the tyres on each side: our choice."""


def vehicle_files(vehicle: Vehicle, notes: Notes) -> dict[str, str]:
    """Return vehicle_info.param.yaml, which keeps the rear axle, or none if the axle is off the vehicle."""
    rear = vehicle.length / 2.0 + vehicle.rear_axle_x
    front = min(rear, (vehicle.length - rear) / 2.0)
    if rear < 0.0 or front < 0.0:
        notes.ignored("vehicle: its rear axle is not between its ends", VEHICLE_INFO)
        return {}
    side = _SIDE * vehicle.width
    lengths = (vehicle.length - rear - front, vehicle.width - 2.0 * side, front, rear, side, side)
    numbers = dict(zip((*_LENGTHS, "vehicle_height"), (*lengths, vehicle.height), strict=True))
    notes.written(f"{VEHICLE_INFO}: size and rear axle of the vehicle")
    notes.approximated(
        "wheel base and tread are not in the rig: the front overhangs like the rear", VEHICLE_INFO
    )
    lines = [f"    {name}: {value_text(round(number, 9))}" for name, number in numbers.items()]
    return {VEHICLE_INFO: "\n".join(["/**:", "  ros__parameters:", *lines, ""])}
