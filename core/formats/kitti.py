"""KITTI: calibration of tracking, object and odometry benchmarks (one .txt) and of raw drives (calib_*.txt) (import).

Rectified camera 0 has optical axes. P0..P3 (3, 4) project its points into the four cameras: camera i stands at
-K^-1 P[:, 3] and looks the same way. R0_rect and Tr_velo_to_cam lead from the Velodyne (x forward, y left, z up) to
it. Raw drives say the unrectified cameras: p_i = R_i p_0 + T_i, and K, D and image size S of each.
The Velodyne stands 1.73 m above the ground (Geiger et al., IJRR 2013) and is put 0.4 m before the body centre.
View of Delft has one camera, written as P0 to P3, and a second such file for its radar in radar/training/calib.
Source: view-of-delft-dataset, docs/SENSORS_AND_DATA.md and its example set.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from riglens.core.errors import InputError
from riglens.core.formats.base import Format
from riglens.core.formats.frames import Matrix, from_optical, inverse, se3
from riglens.core.formats.lenses import brown_conrady, pinhole
from riglens.core.formats.matrices import projected, quoted_numbers, rigid_of, rotation_of
from riglens.core.formats.mounts import Mounting, Origin
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Source, Value
from riglens.core.geometry import Vec3
from riglens.core.rig.model import Rig, Vehicle
from riglens.core.rig.yaml.nodes import shortened

VELODYNE_M: Vec3 = (0.4, 0.0, 1.73)
PASSAT = Vehicle(body="sedan", length=4.77, width=1.82, height=1.52, rear_axle_x=-1.35)
PASSAT_WORDS = "size of a VW Passat, the car of KITTI"
RECTIFIED_IMAGE = (1242, 375)
_DELFT_IMAGE = (1936, 1216)
CAM_TO_CAM, VELO_TO_CAM = "calib_cam_to_cam.txt", "calib_velo_to_cam.txt"
_VELO, _RECT = ("Tr_velo_to_cam", "Tr_velo_cam", "Tr"), ("R0_rect", "R_rect")
"""`Tr` of odometry and SemanticKITTI leads from the Velodyne to rectified camera 0; they have no R0_rect."""
UNUSED = "(R|P|S)_rect_0[0-9]|corner_dist|delta_[fc]|calib_time"
"""Lines of raw drives: the rectified cameras beside the real ones, and how good the calibration is."""
_MAX_LINES = 500
Lines = dict[str, Value]


def recognises(source: Source) -> bool:
    """Return whether this is a folder with calib_cam_to_cam.txt, or a .txt file with the lines of a calibration."""
    if source.is_folder:
        return source.sibling(CAM_TO_CAM) is not None
    if source.path.name in (CAM_TO_CAM, VELO_TO_CAM):
        return True
    return any(line.startswith(("P2:", "P_rect_02:")) for line in source.text[:100_000].splitlines())


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the four cameras and the Velodyne."""
    is_raw = source.is_folder or source.path.name in (CAM_TO_CAM, VELO_TO_CAM)
    table = {} if is_raw else table_of(source)
    if _has_one_camera(table):
        _read_delft(source, table, mounting)
    else:
        if is_raw:
            _read_raw(source, mounting)
        else:
            _read_benchmark(table, mounting)
        mounting.add("lidar", "velodyne", np.eye(4), said="Velodyne HDL-64E")
    mounting.notes.converted(
        "cameras from optical axes, through the calibration, to the axes of the Velodyne"
    )
    return mounting.rig(f"KITTI {source.name}")


def table_of(source: Source) -> Lines:
    """Return the numbers of every line `name: numbers` or `name numbers`, at least of one; other lines are left out."""
    lines = source.text.splitlines()
    if len(lines) > _MAX_LINES:
        raise InputError(f"{source.where}: must be at most {_MAX_LINES} lines (got {len(lines)})")
    table: dict[str, list[str]] = {}
    for line in lines:
        name, *words = line.replace(":", " ", 1).split()[:50] or [""]
        if name in table:
            raise InputError(f"{source.where}: {shortened(name)}: given twice")
        if name and len(line) < 5_000:
            table[name] = words
    if not table:
        raise InputError(f"{source.where}: must have lines such as 'R: 1 0 0 0 1 0 0 0 1' (got none)")
    return dict(source.value(table).items())


def table_matrix(table: Lines, names: tuple[str, ...], rows: int, columns: int) -> tuple[Value, Matrix]:
    """Return the matrix under one of the names, row by row."""
    value = next((table[name] for name in names if name in table), None)
    if value is None:
        where = next(iter(table.values())).place[0]
        raise InputError(f"{where}: {names[0]}: missing")
    return value, quoted_numbers(value, rows, columns)


def _has_one_camera(table: Lines) -> bool:
    """Return whether P0 to P3 are the same matrix, so that they are one camera."""
    found = [table[f"P{index}"].raw for index in range(4) if f"P{index}" in table]
    return len(found) == 4 and all(one == found[0] for one in found)


def _read_delft(source: Source, table: Lines, mounting: Mounting) -> None:
    """Read the one camera, the LiDAR, and the radar where its file is at its place in the data set."""
    notes, files = mounting.notes, _delft_files(source)
    tables = {kind: table_of(file) for kind, file in files.items()} or {"lidar": table}
    root, *others = tables
    root_SE3_camera = inverse(_rectified_SE3_velo(tables[root], notes))
    notes.converted("P0 to P3 are the same: one camera", "cam0")
    _add_projection(tables[root]["P0"], 0, root_SE3_camera, _DELFT_IMAGE if files else None, mounting)
    for kind in others:
        _add_delft(kind, root_SE3_camera @ _rectified_SE3_velo(tables[kind], notes), mounting)
    _add_delft(root, np.eye(4), mounting)
    if root == "radar":
        mounting.origin = Origin("the radar", lambda car: (car.length / 2.0, 0.0, 0.5))


def _delft_files(source: Source) -> dict[str, Source]:
    """Return the files of a frame in lidar/training/calib and radar/training/calib, those that are there."""
    *_, kind, split, last = ("", "", "", *source.folder.resolve().parts)
    if kind not in ("lidar", "radar") or last != "calib":
        return {}
    top = source.folder.resolve().parents[2]
    places = {one: top / one / split / last / source.path.name for one in ("lidar", "radar")}
    return {one: source.another(path) for one, path in places.items() if path.is_file()}


def _add_delft(kind: str, root_SE3_sensor: Matrix, mounting: Mounting) -> None:
    if kind == "lidar":
        mounting.add("lidar", "velodyne", root_SE3_sensor, said="Velodyne HDL-64E")
    else:
        mounting.add("radar", "radar", root_SE3_sensor, said="ZF FRGen21")


def _rectified_SE3_velo(table: Lines, notes: Notes) -> Matrix:
    """Return the transform from the Velodyne, or the sensor of the file, to rectified camera 0."""
    camera_SE3_velo = rigid_of(*table_matrix(table, _VELO, 3, 4), notes)
    if _VELO[-1] in table and table.keys().isdisjoint((*_VELO[:-1], *_RECT)):
        return camera_SE3_velo
    return rigid_of(*table_matrix(table, _RECT, 3, 3), notes) @ camera_SE3_velo


def _read_benchmark(table: Lines, mounting: Mounting) -> None:
    """Read the rectified cameras of the tracking and object benchmarks."""
    notes = mounting.notes
    velo_SE3_rectified = inverse(_rectified_SE3_velo(table, notes))
    for index in range(4):
        if f"P{index}" in table:
            _add_projection(table[f"P{index}"], index, velo_SE3_rectified, None, mounting)
    if imus := [name for name in table if name.startswith("Tr_imu")]:
        notes.ignored("IMU", *imus)


def _add_projection(
    value: Value, index: int, velo_SE3_rectified: Matrix, image: tuple[int, int] | None, mounting: Mounting
) -> None:
    name = f"cam{index}"
    projection = np.array([word.number(quoted=True) for word in value.elements(12)]).reshape(3, 4)
    pose = velo_SE3_rectified @ projected(value, projection)
    lens: dict[str, Any] = pinhole(projection)
    lens["image"] = image or mounting.unknown_image(name, RECTIFIED_IMAGE, lens)
    mounting.add("camera", name, from_optical(pose), **lens)


def _read_raw(source: Source, mounting: Mounting) -> None:
    """Read the unrectified cameras of a raw drive, through camera 0."""
    cameras, velo = (source.sibling(name) for name in (CAM_TO_CAM, VELO_TO_CAM))
    if cameras is None or velo is None:
        raise InputError(f"{source.where}: a raw drive needs {CAM_TO_CAM} and {VELO_TO_CAM} in one folder")
    table, notes = table_of(cameras), mounting.notes
    velo_table = table_of(velo)
    value, rotation = table_matrix(velo_table, ("R",), 3, 3)
    _, position = table_matrix(velo_table, ("T",), 3, 1)
    velo_SE3_camera0 = inverse(se3(rotation_of(value, rotation, notes), position[:, 0]))
    for index in range(4):
        number = f"{index:02d}"
        if f"K_{number}" in table:
            _add_raw(table, number, velo_SE3_camera0, mounting)
        elif f"P_rect_{number}" in table:
            _add_rectified(table, number, velo_SE3_camera0, mounting)
    if not mounting.sensors:
        notes.ignored("no camera in it: neither K_00 to K_03 nor P_rect_00 to P_rect_03", CAM_TO_CAM)
    if source.sibling("calib_imu_to_velo.txt"):
        notes.ignored("IMU", "calib_imu_to_velo.txt")


def _add_rectified(table: Lines, number: str, velo_SE3_camera0: Matrix, mounting: Mounting) -> None:
    """Add a camera for which a raw drive has only the rectified projection."""
    name, notes = f"cam{int(number)}", mounting.notes
    rectify = rigid_of(*table_matrix(table, ("R_rect_00", "R_rect_0"), 3, 3), notes)
    velo_SE3_rectified = velo_SE3_camera0 @ inverse(rectify)
    notes.approximated(f"K_{number} not in the file: the rectified camera of P_rect_{number}", name)
    image = image_size(table, f"S_rect_{number}") if f"S_rect_{number}" in table else None
    _add_projection(table[f"P_rect_{number}"], int(number), velo_SE3_rectified, image, mounting)


def _add_raw(table: Lines, number: str, velo_SE3_camera0: Matrix, mounting: Mounting) -> None:
    name, notes = f"cam{int(number)}", mounting.notes
    value, rotation = table_matrix(table, (f"R_{number}",), 3, 3)
    _, position = table_matrix(table, (f"T_{number}",), 3, 1)
    camera_SE3_camera0 = se3(rotation_of(value, rotation, notes), position[:, 0])
    pose = velo_SE3_camera0 @ inverse(camera_SE3_camera0)
    mounting.add("camera", name, from_optical(pose), **raw_lens(table, number, name, notes))


def raw_lens(table: Lines, number: str, name: str, notes: Notes) -> dict[str, Any]:
    """Return image and lens of an unrectified camera: S, K and D of that number."""
    _, k = table_matrix(table, (f"K_{number}",), 3, 3)
    lens: dict[str, Any] = {"image": image_size(table, f"S_{number}"), **pinhole(k)}
    if f"D_{number}" in table:
        d_value, d = table_matrix(table, (f"D_{number}",), 1, 5)
        lens |= brown_conrady(d_value, [float(k) for k in d[0]], name, notes)
    return lens


def image_size(table: Lines, name: str) -> tuple[int, int]:
    """Return width and height in pixels, which a line holds as floating-point numbers."""
    value, ((width, height),) = table_matrix(table, (name,), 1, 2)
    return Value({"width": float(width), "height": float(height)}, *value.place).image()


KITTI = Format(
    "kitti", "KITTI calibration", (".txt",), recognises, read, has_folders=True, vehicle=PASSAT, car=PASSAT_WORDS,
    origin=Origin("the Velodyne", lambda _: VELODYNE_M), harmless=UNUSED,
)  # fmt: skip
