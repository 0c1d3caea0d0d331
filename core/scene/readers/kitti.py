"""KITTI label folders: boxes of the rectified camera 0 into the Velodyne frame, through the calibration.

Tracking: label_02/<sequence>.txt with calib/<sequence>.txt; the frames of a sequence are 0 to its last one.
Object: label_2/<frame>.txt with calib/<frame>.txt; one frame per file, whether it holds boxes or not.
Source of the format: the development kits of the KITTI object and tracking benchmarks.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.files import open_regular
from riglens.core.geometry import Vec3, is_rotation
from riglens.core.scene.boxes import BoxBatch, Progress
from riglens.core.scene.limits import MAX_NAME_CHARS, require_few_files
from riglens.core.scene.readers.classes import UNMAPPED
from riglens.core.scene.readers.common import (
    ACCEPTED_POSITION,
    MAX_POSITION_M,
    NUMBERS,
    BoxOptions,
    FileBoxSource,
    ReadingTally,
    join,
    readable,
    require_boxes,
    shown,
)

VELODYNE_M: Vec3 = (0.4, 0.0, 1.73)
"""Place of the Velodyne in the vehicle frame of the KITTI car, about."""

MAX_FILE_BYTES = 1 << 26
MAX_LINE_BYTES = 4096
MAX_LINES = 500_000
_NUMBER = re.compile("[0-9]{1,18}")
_TEXT_FILE = "a KITTI text file"
_FILES_PER_BATCH = 256
_FRAME_DIGITS = 6
"""Digits in the file names of a KITTI drive; the last frame gives the length of a sequence."""
_BOX_FIELDS = ("height", "width", "length", "x", "y", "z", "rotation_y")
_CALIBRATION = {"R_rect": ("R0_rect", 9), "Tr_velo_cam": ("Tr_velo_to_cam", 12)}
"""Lines of a calibration: their other name, and how many numbers they hold."""


@dataclass(frozen=True)
class LabelLayout:
    """Differences between the two kinds of KITTI folders: name of the label folder, two more fields when tracking."""

    folder: str
    tracking: bool

    @property
    def type_field(self) -> int:
        """Index of the field with the object's type; a line has 15 fields from there on, 16 with a score."""
        return 2 if self.tracking else 0


TRACKING = LabelLayout("label_02", tracking=True)
OBJECT = LabelLayout("label_2", tracking=False)


@dataclass(frozen=True)
class Labels:
    """The lines of one label file: frame (n,), type names, boxes (n, 7) as in _BOX_FIELDS, line numbers."""

    frame: NDArray[np.int64]
    names: list[str]
    boxes: NDArray[np.float64]
    lines: list[int]


class KittiSource(FileBoxSource):
    """A KITTI tracking or object folder; raw boxes are in the frame of the Velodyne."""

    def __init__(
        self, path: Path, layout: LabelLayout, options: BoxOptions, labels: Sequence[Path] | None = None
    ) -> None:
        """Read the label files in `labels`, or all of them."""
        super().__init__(path, options)
        self._layout = layout
        with readable(path):
            self._labels = _label_files(path / layout.folder) if labels is None else list(labels)
        if not self._labels:
            raise InputError(f"{path / layout.folder}: must hold label files named *.txt")
        for label in self._labels:
            if not self._calib(label).is_file():
                raise InputError(f"{self._calib(label)}: missing: each label file needs a calibration file")

    def parts(self) -> Sequence[KittiSource]:
        """Return one source per tracking sequence, or per some hundred object frames."""
        step = 1 if self._layout.tracking else _FILES_PER_BATCH
        options = replace(self.options, frames=None, is_part=True)
        starts = range(0, len(self._labels), step)
        return [KittiSource(self.path, self._layout, options, self._labels[at : at + step]) for at in starts]

    def _calib(self, label: Path) -> Path:
        return self.path / "calib" / label.name

    def _files(self) -> list[Path]:
        return [*self._labels, *map(self._calib, self._labels)]

    def _read(self, tally: ReadingTally, progress: Progress) -> Iterator[BoxBatch]:
        tally.sequences = len(self._labels)
        pending: list[BoxBatch] = []
        for done, label in enumerate(self._labels, start=1):
            pending.append(self._boxes(label, tally))
            if done % _FILES_PER_BATCH == 0 or self._layout.tracking or done == len(self._labels):
                yield join(pending)
                pending = []
            progress(done / len(self._labels))
        numbers = [label.stem for label in self._labels]
        if not self._layout.tracking and all(_NUMBER.fullmatch(number) for number in numbers):
            tally.name_frames(self.path.name, np.array(numbers, np.int64))

    def _boxes(self, label: Path, tally: ReadingTally) -> BoxBatch:
        """Return the mapped boxes of one label file, with frames numbered after those of the previous files."""
        labels = read_labels(label, self._layout)
        codes = np.asarray(self.options.classes.codes(labels.names), dtype=np.int64)
        unmapped = (name for name, code in zip(labels.names, codes, strict=True) if code == UNMAPPED)
        tally.miss(unmapped, label)
        rows = np.flatnonzero(codes != UNMAPPED)
        rows = rows[np.argsort(labels.frame[rows], kind="stable")]
        first_frame = tally.frames
        frames = int(labels.frame.max(initial=-1)) + 1 if self._layout.tracking else 1
        tally.frames += frames
        if self._layout.tracking and frames <= MAX_LINES:
            tally.name_frames(label.stem, np.arange(frames))
        boxes = labels.boxes[rows]
        require_boxes(
            boxes[:, 3:6],
            boxes[:, [2, 1, 0]],
            lambda row, column: f"{label}:{labels.lines[rows[row]]}: {NUMBERS[column]}",
        )
        centre, size, rotation = camera_boxes_to_velodyne(boxes, read_calibration(self._calib(label)))
        return BoxBatch(
            first_frame + labels.frame[rows], codes[rows].astype(np.uint8), centre, size, rotation
        )


def camera_boxes_to_velodyne(
    boxes: NDArray[np.float64], camera_SE3_velodyne: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return centres (n, 3), sizes (n, 3) and rotations (n, 3, 3) in the Velodyne frame.

    boxes (n, 7): height, width, length, x, y, z of the middle of the bottom, rotation_y about the y axis of
    the camera (x right, y down, z forward); camera_SE3_velodyne (4, 4): Velodyne to rectified camera 0.
    """
    height, width, length = boxes[:, 0], boxes[:, 1], boxes[:, 2]
    centre_camera = boxes[:, 3:6] - np.column_stack([0 * height, height / 2, 0 * height])
    sin, cos, zero = np.sin(boxes[:, 6]), np.cos(boxes[:, 6]), np.zeros(len(boxes))
    forward = np.column_stack([cos, zero, -sin])
    up = np.tile([0.0, -1.0, 0.0], (len(boxes), 1))
    camera_R_box = np.stack([forward, np.cross(up, forward), up], axis=2)
    velodyne_SE3_camera = np.linalg.inv(camera_SE3_velodyne).astype(np.float64)
    centre = centre_camera @ velodyne_SE3_camera[:3, :3].T + velodyne_SE3_camera[:3, 3]
    rotation = _nearest_rotation(velodyne_SE3_camera[:3, :3]) @ camera_R_box
    return centre, np.column_stack([length, width, height]), rotation


def read_calibration(path: Path) -> NDArray[np.float64]:
    """Return Velodyne to rectified camera 0, (4, 4): R_rect times Tr_velo_cam; both spellings of either are read."""
    found: dict[str, NDArray[np.float64]] = {}
    for number, line in _text_lines(path):
        name, *fields = line.replace(":", " ", 1).split() or [""]
        for key, (other, count) in _CALIBRATION.items():
            if name in (key, other):
                place = f"{path}:{number}: {name}"
                if len(fields) != count:
                    raise InputError(f"{place}: must be {count} numbers (got {len(fields)})")
                found[key] = np.asarray([_number(place, text) for text in fields])
    for key, (other, _) in _CALIBRATION.items():
        if key not in found:
            raise InputError(f"{path}: a KITTI calibration file needs a line {key} or {other}")
    rectify, camera_SE3_velodyne = np.eye(4), np.eye(4)
    rectify[:3, :3] = found["R_rect"].reshape(3, 3)
    camera_SE3_velodyne[:3] = found["Tr_velo_cam"].reshape(3, 4)
    for key, matrix in (("R_rect", rectify), ("Tr_velo_cam", camera_SE3_velodyne)):
        if not is_rotation(matrix[:3, :3]):
            raise InputError(f"{path}: {key}: must be a rotation without scale or shear")
    if not (np.abs(camera_SE3_velodyne[:3, 3]) <= MAX_POSITION_M).all():
        raise InputError(f"{path}: Tr_velo_cam: the shift must be {ACCEPTED_POSITION}")
    return rectify @ camera_SE3_velodyne


def read_labels(path: Path, layout: LabelLayout) -> Labels:
    """Return all lines of a label file; raise InputError with the line number where one is malformed."""
    frames, names, rows, lines = [], [], [], []
    for number, line in _text_lines(path):
        fields = line.split()
        first = layout.type_field
        if len(fields) - first not in (15, 16):
            accepted = f"{first + 15} or {first + 16}"
            raise InputError(f"{path}:{number}: must be {accepted} values (got {len(fields)})")
        place = f"{path}:{number}"
        if len(fields[first]) > MAX_NAME_CHARS:
            raise InputError(
                f"{place}: type: must be at most {MAX_NAME_CHARS} characters (got {len(fields[first])})"
            )
        frames.append(_frame(place, fields[0]) if layout.tracking else 0)
        names.append(fields[first])
        values = fields[first + 8 : first + 15]
        rows.append(
            [_number(f"{place}: {name}", text) for name, text in zip(_BOX_FIELDS, values, strict=True)]
        )
        lines.append(number)
    boxes = np.asarray(rows, dtype=np.float64).reshape(len(rows), len(_BOX_FIELDS))
    return Labels(np.asarray(frames, dtype=np.int64), names, boxes, lines)


def _label_files(folder: Path) -> list[Path]:
    files = []
    for file in folder.glob("*.txt"):
        if not file.name.startswith("."):
            files.append(file)
            require_few_files(len(files), folder)
    return sorted(files)


def _text_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the numbered lines of a small text file that are not blank."""
    with open_regular(path, _TEXT_FILE) as file:
        if os.fstat(file.fileno()).st_size > MAX_FILE_BYTES:
            raise InputError(f"{path}: too large for {_TEXT_FILE} (at most {MAX_FILE_BYTES >> 20} MiB)")
        for number, line in enumerate(iter(lambda: file.readline(MAX_LINE_BYTES + 1), b""), start=1):
            if len(line) > MAX_LINE_BYTES:
                raise InputError(
                    f"{path}:{number}: line too long for {_TEXT_FILE} (at most {MAX_LINE_BYTES} bytes)"
                )
            if number > MAX_LINES:
                raise InputError(f"{path}: too many lines for {_TEXT_FILE} (at most {MAX_LINES})")
            if line.strip():
                try:
                    yield number, line.decode("ascii")
                except UnicodeDecodeError as error:
                    raise InputError(f"{path}:{number}: must be ASCII text") from error


def _frame(place: str, text: str) -> int:
    if not text.isdecimal() or len(text) > _FRAME_DIGITS:
        accepted = f"an integer ≥ 0 of at most {_FRAME_DIGITS} digits"
        raise InputError(f"{place}: frame: must be {accepted} (got {shown(text)})")
    return int(text)


def _number(place: str, text: str) -> float:
    """Return a finite number; `place` is file, line and field."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or "_" in text:
        raise InputError(f"{place}: must be a finite number (got {shown(text)})")
    return value


def _nearest_rotation(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation nearest to a matrix that rounding has distorted a little."""
    left, _, right = np.linalg.svd(matrix)
    rotation: NDArray[np.float64] = left @ right
    return rotation
