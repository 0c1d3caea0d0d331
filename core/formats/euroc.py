"""EuRoC's sensor.yaml, Kimera-VIO's camera files and maplab's sensors, with rovioli's ncamera (import).

All give each camera's place by a matrix from its optical axes to a body, which is the IMU: T_BS of EuRoC and Kimera,
T_B_C of maplab, there chained with T_B_S of the sensor that the camera belongs to. Metres. The files know neither the
vehicle nor how the IMU is mounted in it.
Source: EuRoC MAV dataset (Burri et al., IJRR 2016); Kimera-VIO, params; maplab wiki, "Sensor calibration format".
"""

from __future__ import annotations

from typing import Any

import numpy as np

from riglens.core.formats.base import Format
from riglens.core.formats.frames import FrameTree, Matrix
from riglens.core.formats.lenses import kalibr_lens, named_lens
from riglens.core.formats.matrices import add_by_imu, rigid
from riglens.core.formats.mounts import Mounting
from riglens.core.formats.report import Notes
from riglens.core.formats.source import YAML, Source, Value
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.nodes import shortened

_PLACES = ("cam[0-9]*/sensor.yaml", "mav0/cam[0-9]*/sensor.yaml", "*CameraParams.yaml")
_MODELS = {"unified-projection": "omni"}
"""Names of Kalibr's models in maplab, where they differ."""
_Cameras = dict[str, tuple[Matrix, dict[str, Any]]]


def recognises(source: Source) -> bool:
    """Return whether this is such a file, or a folder with files of cameras."""
    if source.is_folder:
        return any("T_BS" in file.yaml for file in _files(source)[:1])
    root = source.yaml
    entries = root.raw.get("sensors" if "extrinsics" in root else "cameras", ()) if root.is_mapping else ()
    is_list = isinstance(entries, (list, tuple)) and bool(entries)
    return "T_BS" in root or (
        is_list and all(isinstance(entry, dict) and _KEYS & entry.keys() for entry in entries)
    )


_KEYS = frozenset(("sensor_type", "camera"))


def _files(source: Source) -> list[Source]:
    return (
        next((found for place in _PLACES if (found := source.siblings(place))), [])
        if source.is_folder
        else [source]
    )


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the cameras, and maplab's LiDARs."""
    cameras: _Cameras = {}
    notes = mounting.notes
    lidars: dict[str, Matrix] = {}
    for file in _files(source):
        root = file.yaml
        if "T_BS" in root:
            _add_plain(root, file, cameras, notes)
        elif "sensors" in root:
            _add_sensors(root, source, cameras, lidars, notes)
        else:
            cameras |= _ncamera(root.item("cameras"), np.eye(4), notes)
    turn = add_by_imu(cameras, mounting)
    for name, pose in lidars.items():
        mounting.add("lidar", name, turn @ pose)
    notes.converted("cameras from optical axes")
    return mounting.rig(source.name)


def _add_plain(root: Value, file: Source, cameras: _Cameras, notes: Notes) -> None:
    """Add the one camera of a file of EuRoC or Kimera-VIO, named by itself or by its folder."""
    name = root.item("camera_id", "").text() or (
        file.path.resolve().parent.name if file.name == "sensor" else file.name
    )
    if "intrinsics" not in root:
        notes.ignored("no camera: a T_BS without intrinsics", name)
        return
    lens = kalibr_lens(root, "distortion_coefficients", name, notes)
    cameras[_free(name, cameras)] = rigid(root.item("T_BS"), name, notes), lens


def _add_sensors(
    root: Value, source: Source, cameras: _Cameras, lidars: dict[str, Matrix], notes: Notes
) -> None:
    """Add the cameras and LiDARs of a maplab file, by the extrinsics that name their ids."""
    tree = FrameTree(source.where)
    for entry in root.item("extrinsics").elements():
        sensor, base = (entry.item(key).text() for key in ("sensor_id", "base_sensor_id"))
        pose = rigid(entry.item("T_B_S"), sensor, notes)
        if sensor != base:
            tree.add(base, sensor, pose)
    for entry in root.item("sensors").elements():
        kind, sensor = entry.item("sensor_type").text(), entry.item("id").text()
        if kind == "NCAMERA":
            cameras |= _ncamera(entry.item("cameras"), tree.root_SE3(sensor), notes)
        elif kind == "LIDAR":
            lidars[_free(_name(entry), lidars)] = tree.root_SE3(sensor)
        else:
            notes.ignored(f"neither camera nor LiDAR: {shortened(kind, 40)}", _name(entry))


def _ncamera(listed: Value, base_SE3_body: Matrix, notes: Notes) -> _Cameras:
    """Return the cameras of a list of maplab."""
    found: _Cameras = {}
    for entry in listed.elements():
        camera = entry.item("camera")
        name = _name(camera)
        pose = base_SE3_body @ rigid(entry.item("T_B_C"), name, notes)
        found[_free(name, found)] = pose, _lens(camera, name, notes)
    return found


def _lens(camera: Value, name: str, notes: Notes) -> dict[str, Any]:
    model, size = camera.item("type").text(), camera.image("image_width", "image_height")
    distortion = camera.item("distortion", {"type": "none"})
    kind, parameters = distortion.item("type").text(), distortion.get("parameters")
    bend = None if parameters is None else parameters.item("data")
    numbers = camera.item("intrinsics").item("data")
    return named_lens(_MODELS.get(model, model), numbers, kind, bend, size, name, notes)


def _name(entry: Value) -> str:
    """Return the first word of a topic, else a label, else the id."""
    for key in ("topic", "label", "id"):
        words = [word for word in entry.item(key).text().split("/") if word] if key in entry else []
        if words:
            return words[0]
    return "sensor"


def _free(name: str, taken: dict[str, Any]) -> str:
    """Return a name that is not taken: those of one file may be equal."""
    return next(new for number in range(len(taken) + 1) if (new := name + "_" * number) not in taken)


EUROC = Format("euroc", "EuRoC, Kimera-VIO or maplab calibration", YAML, recognises, read, has_folders=True)
