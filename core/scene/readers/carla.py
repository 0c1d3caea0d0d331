"""CARLA folders of the paper's published code: one .npy file of box corners per actor and frame.

Layout: {vehicle,pedestrian,cyclist}/<actor>_<frame>.npy, corners in the ego vehicle's CARLA frame (x forward,
y to the right, z up: left-handed). The published code keeps coordinates in rows, (3, 8), sometimes with a
fourth row of ones; (8, 3) and (8, 4) are read too. The corners may come in any order.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.files import open_regular
from riglens.core.scene.boxes import BoxBatch, Progress
from riglens.core.scene.limits import require_few_files
from riglens.core.scene.readers.classes import UNMAPPED
from riglens.core.scene.readers.common import (
    ACCEPTED_POSITION,
    MAX_POSITION_M,
    BoxOptions,
    FileBoxSource,
    ReadingTally,
    readable,
    require_boxes,
    whole_frames,
)

FOLDERS = ("vehicle", "pedestrian", "cyclist")
MAX_FILE_BYTES = 1 << 16
_TOLERANCE_M = 0.01
_SHAPES = ((3, 8), (4, 8), (8, 3), (8, 4))
_TRIPLES = np.array(list(itertools.combinations(range(1, 8), 3)))


class CarlaSource(FileBoxSource):
    """A CARLA folder; raw boxes have y flipped, so that the frame is right-handed."""

    def __init__(self, path: Path, options: BoxOptions) -> None:
        super().__init__(path, options)
        with readable(path):
            self._entries = _entries(path)
        if not self._entries:
            names = ", ".join(FOLDERS)
            raise InputError(f"{path}: must hold files <actor>_<frame>.npy in the folders {names}")

    def _files(self) -> list[Path]:
        return [self.path / name for _, name in self._entries]

    def _read(self, tally: ReadingTally, progress: Progress) -> Iterator[BoxBatch]:
        numbers = np.array([frame for frame, _ in self._entries], dtype=np.int64)
        steps = np.diff(np.unique(numbers))
        step = int(np.gcd.reduce(steps)) if steps.size else 1
        frames = (numbers - numbers[0]) // step
        tally.frames = int(frames[-1]) + 1
        tally.notes.append(
            f"frames {numbers[0]} to {numbers[-1]} in steps of {step}; those without a file are empty"
        )
        for run in whole_frames(frames):
            yield self._boxes(run, frames, tally)
            progress(run.stop / len(self._entries))

    def _boxes(self, rows: slice, frames: NDArray[np.int64], tally: ReadingTally) -> BoxBatch:
        """Return the mapped boxes of the files in `rows`; unmapped ones are counted without being opened."""
        names = [name for _, name in self._entries[rows]]
        folders = [name.partition("/")[0] for name in names]
        codes = np.asarray(self.options.classes.codes(folders), dtype=np.int64)
        tally.miss((name for name, code in zip(folders, codes, strict=True) if code == UNMAPPED), self.path)
        kept = np.flatnonzero(codes != UNMAPPED)
        corners = [read_corners(self.path / names[row]) for row in kept]
        flipped = np.asarray(corners, dtype=np.float64).reshape(-1, 8, 3) * [1.0, -1.0, 1.0]
        centre, size, rotation, sound = boxes_from_corners(flipped)
        if not sound.all():
            place = self.path / names[kept[int(np.argmin(sound))]]
            raise InputError(f"{place}: the 8 points must be the corners of a rectangular box")
        require_boxes(centre, size, lambda row, _: str(self.path / names[kept[row]]))
        return BoxBatch(frames[rows][kept], codes[kept].astype(np.uint8), centre, size, rotation)


def read_corners(path: Path) -> NDArray[np.float64]:
    """Return the corners (8, 3) of one file as stored; pickled objects are refused without being unpickled."""
    with open_regular(path, "a .npy file of numbers") as file:
        data = file.read(MAX_FILE_BYTES + 1)
    if len(data) > MAX_FILE_BYTES:
        raise InputError(
            f"{path}: too large for the 8 corners of one box (at most {MAX_FILE_BYTES >> 10} KiB)"
        )
    try:
        array = np.load(BytesIO(data), allow_pickle=False)
    except Exception as error:  # anything that numpy may raise for broken bytes
        reason = (
            "pickled objects" if b"|O" in data[:256] or data[:1] == b"\x80" else "a damaged or truncated file"
        )
        raise InputError(f"{path}: must be a .npy file of numbers (got {reason})") from error
    if not isinstance(array, np.ndarray) or array.dtype.kind not in "fiu":
        raise InputError(f"{path}: must be a .npy file of numbers, the 8 corners of one box")
    if array.shape not in _SHAPES:
        accepted = ", ".join(map(str, _SHAPES))
        raise InputError(f"{path}: shape must be one of {accepted} (got {array.shape})")
    corners = (array if array.shape[0] == 8 else array.T)[:, :3].astype(np.float64)
    if not (np.abs(corners) <= MAX_POSITION_M).all():
        raise InputError(f"{path}: corners must be {ACCEPTED_POSITION}")
    return corners


def boxes_from_corners(
    corners: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Return centres (n, 3), sizes (n, 3), rotations (n, 3, 3), and whether each corner set (n, 8, 3) is a box.

    The order of the corners does not matter: the edges from the first corner are the three vectors that are
    perpendicular to each other and add up to the space diagonal. Height is the edge nearest to vertical,
    length the longer one of the others; a box covers the same space whichever end is its front.
    """
    centre = corners.mean(axis=1)
    origin = corners[:, :1]
    vectors = corners - origin
    diagonal = 2 * (centre[:, None] - origin)
    candidates = vectors[:, _TRIPLES]
    misfit = np.linalg.norm(candidates.sum(axis=2) - diagonal, axis=2)
    gram = np.abs(candidates @ candidates.transpose(0, 1, 3, 2))
    skew = gram[:, :, 0, 1] + gram[:, :, 0, 2] + gram[:, :, 1, 2]
    scale = np.linalg.norm(diagonal, axis=2) + 1e-12
    best = np.argmin(misfit / scale + skew / scale**2, axis=1)
    edges = candidates[np.arange(len(corners)), best]
    sound = _spans_all_corners(edges, vectors) & (_skewness(edges) < _TOLERANCE_M)
    edges = _ordered(edges)
    size = np.linalg.norm(edges, axis=2)
    return centre, size, _orthonormal(edges), sound


def _entries(path: Path) -> list[tuple[int, str]]:
    """Return (frame, relative name) of every corner file, sorted; the last part of a name is its frame."""
    entries = []
    for folder in FOLDERS:
        for file in (path / folder).glob("*.npy"):
            frame = file.stem.rpartition("_")[2]
            if file.name.startswith("."):
                continue
            if not frame.isdecimal() or not frame.isascii() or len(frame) > 18:
                raise InputError(f"{file}: must be named <actor>_<frame>.npy")
            entries.append((int(frame), f"{folder}/{file.name}"))
            require_few_files(len(entries), path)
    return sorted(entries)


def _spans_all_corners(edges: NDArray[np.float64], vectors: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether every sum of some of the edges is one of the corners, seen from the first corner."""
    chosen = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
    expected = chosen @ edges
    gaps = np.linalg.norm(expected[:, :, None] - vectors[:, None], axis=3).min(axis=2)
    return np.asarray((gaps < _TOLERANCE_M).all(axis=1))


def _skewness(edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the deviation, in metres, of the edges (n, 3, 3) from being perpendicular."""
    length = np.linalg.norm(edges, axis=2) + 1e-12
    gram = np.abs(edges @ edges.transpose(0, 2, 1)) / np.maximum(length[:, :, None], length[:, None])
    return np.asarray(np.maximum(gram[:, 0, 1], np.maximum(gram[:, 0, 2], gram[:, 1, 2])))


def _ordered(edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return edges as length, width, height; height points up, length forward (or left when it has no x)."""
    rows = np.arange(len(edges))[:, None]
    length = np.linalg.norm(edges, axis=2) + 1e-12
    steepness = np.abs(edges[:, :, 2]) / length
    height = np.argmax(steepness, axis=1)
    key = length.copy()
    key[rows[:, 0], height] = -1.0
    order = np.argsort(-key, axis=1, kind="stable")
    ordered = edges[rows, order]
    up = np.where(ordered[:, 2, 2] < 0, -1.0, 1.0)
    ahead = np.where(ordered[:, 0, 0] + 1e-9 * ordered[:, 0, 1] < 0, -1.0, 1.0)
    ordered[:, 2] *= up[:, None]
    ordered[:, 0] *= ahead[:, None]
    return ordered


@np.errstate(over="ignore", invalid="ignore")  # of edges without a length, which are refused later
def _orthonormal(edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return rotations (n, 3, 3) with columns along length, to the left of it, and up, from ordered edges."""
    unit = edges / (np.linalg.norm(edges, axis=2, keepdims=True) + 1e-300)
    up = unit[:, 2]
    left = np.cross(up, unit[:, 0])
    left /= np.linalg.norm(left, axis=1, keepdims=True) + 1e-300
    return np.stack([np.cross(left, up), left, up], axis=2)
