"""The content of a POG file, checked before anything computes with it: a file may come from anywhere.

Kernels index by the words and the counts, so these have to fit the grid and each other; sizes are known, and
compared with the memory that is free, before any of it is taken.
"""

from __future__ import annotations

import json
import math
import reprlib
import zipfile
from collections import Counter
from collections.abc import Collection
from typing import Any, NamedTuple

import numpy as np
import psutil
from numpy.typing import NDArray

from riglens.core.geometry import Vec3
from riglens.core.scene.boxes import CLASSES, DataReport
from riglens.core.scene.columns import VoxelIndex, words_in
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.limits import MAX_FRAMES, require_few_names
from riglens.core.scene.pog import Counts, Pog

MAX_HEADER_CHARS = 1 << 25
MAX_BOXES = 1 << 62
_PIECE_BYTES = 1 << 20
_SHOWN = 40


class Header(NamedTuple):
    """Description of the arrays in a POG file."""

    grid: VoxelGrid
    data: DataReport


class Content(NamedTuple):
    """The members of a POG file; `text` is the header as written, `voxels` numbers those in its words."""

    text: str
    header: Header
    voxels: VoxelIndex
    counts: Counts
    digest: str

    def pog(self) -> Pog:
        """Return the POG; raise ValueError when a voxel is occupied in more frames than there are."""
        most = int(self.counts.max(initial=0))
        if most > self.header.data.frames:
            raise ValueError(
                f"counts must be at most {self.header.data.frames}, the number of frames (got {most})"
            )
        return Pog(self.header.grid, self.header.data, self.voxels, self.counts)


def read_content(archive: zipfile.ZipFile, version: int, is_part: bool) -> Content:
    """Return the members of an archive, each of the size that those before it imply.

    Raise ValueError that names the field otherwise. is_part: whether it may hold no frame.
    """
    text = _read_text(archive, "header", MAX_HEADER_CHARS)
    header = checked_header(json.loads(text), version, is_part)
    words = _read_array(archive, "words", (words_in(header.grid),), (np.uint64,))
    voxels = VoxelIndex.of(header.grid, words)
    counts = _read_array(archive, "counts", (voxels.count, len(CLASSES)), (np.uint16, np.uint32))
    return Content(text, header, voxels, counts, _read_text(archive, "digest", 64))


def checked_header(fields: Any, version: int, is_part: bool = False) -> Header:
    """Return the header of a POG; raise ValueError that names the field."""
    _require(isinstance(fields, dict), "header", fields, "a JSON object")
    found = fields.get("riglens_pog")
    if found != version:
        raise ValueError(f"format {_shown(found)} is not supported")
    grid = VoxelGrid(_length("voxel_m", fields.get("voxel_m")), _roi(fields.get("roi_m")))
    boxes = _tallies(fields, "boxes")
    unmapped = Counter(_tallies(fields, "unmapped"))
    require_few_names(unmapped, "unmapped")
    notes = fields.get("notes", [])
    _require(isinstance(notes, list), "notes", notes, "a list of texts")
    data = DataReport(
        _text("source", fields.get("source")),
        _whole("frames", fields.get("frames"), 0 if is_part else 1, MAX_FRAMES),
        {name: boxes.get(name, 0) for name in CLASSES},
        unmapped,
        _text("sha256", fields.get("sha256")),
        tuple(_text("notes", note) for note in notes),
        _whole("sequences", fields.get("sequences", 1), 0, MAX_FRAMES),
    )
    return Header(grid, data)


def _read_text(archive: zipfile.ZipFile, name: str, most_chars: int) -> str:
    with archive.open(_member(archive, name)) as stream:
        shape, _, dtype = _npy_header(stream)
        if shape != () or dtype.kind != "U" or not 0 < dtype.itemsize <= 4 * most_chars:
            raise ValueError(f"{name} must be a text of at most {most_chars} characters")
        return str(_filled(stream, name, np.empty((), dtype)))


def _read_array(archive: zipfile.ZipFile, name: str, shape: tuple[int, ...], dtypes: Collection[Any]) -> Any:
    """Return an array of one of these types and this shape; memory is taken only after both are known to fit."""
    with archive.open(_member(archive, name)) as stream:
        found, is_fortran, dtype = _npy_header(stream)
        if dtype not in dtypes or is_fortran or found != shape:
            raise ValueError(f"{name} must be {shape}, by the grid and its voxels (got {dtype} {found})")
        needed, free = math.prod(shape) * dtype.itemsize, psutil.virtual_memory().available
        if needed > free:
            raise ValueError(f"{name}: needs {needed / 1e9:.1f} GB of memory, {free / 1e9:.1f} GB are free")
        return _filled(stream, name, np.empty(shape, dtype))


def _member(archive: zipfile.ZipFile, name: str) -> zipfile.ZipInfo:
    """Return a member; only plain and deflated ones, which take no memory of their own."""
    try:
        member = archive.getinfo(f"{name}.npy")
    except KeyError:
        raise ValueError(f"{name}: missing") from None
    if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError(f"{name}: compressed in another way than POG files are")
    return member


def _npy_header(stream: Any) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    readers = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
    version = np.lib.format.read_magic(stream)
    if version not in readers:
        raise ValueError(f"arrays of version {version}")
    shape, is_fortran, dtype = readers[version](stream)
    return shape, is_fortran and len(shape) > 1, dtype


def _filled(stream: Any, name: str, array: NDArray[Any]) -> NDArray[Any]:
    """Fill an array with the rest of the stream, whose length must be exactly that of the array."""
    flat, done = array.reshape(-1).view(np.uint8), 0
    while done < flat.size:
        piece = stream.read(min(_PIECE_BYTES, flat.size - done))
        if not piece:
            raise ValueError(f"{name}: cut off")
        flat[done : done + len(piece)] = np.frombuffer(piece, np.uint8)
        done += len(piece)
    if stream.read(1):  # at its end the stream compares its checksum, too
        raise ValueError(f"{name}: longer than its shape")
    return array


def _tallies(fields: dict[str, Any], name: str) -> dict[str, int]:
    """Return a field that maps names to how often they were found."""
    value: Any = fields.get(name)
    _require(isinstance(value, dict), name, value, "a JSON object of names and numbers")
    return {_text(name, key): _whole(f"{name}.{key}", number, 0, MAX_BOXES) for key, number in value.items()}


def _roi(value: Any) -> Vec3:
    _require(isinstance(value, list) and len(value) == 3, "roi_m", value, "a list of three lengths in metres")
    length, width, height = (_length("roi_m", side) for side in value)
    return length, width, height


def _length(name: str, value: Any) -> float:
    fits = isinstance(value, int | float) and not isinstance(value, bool) and 0 < value <= 1e9
    _require(fits, name, value, "a positive length in metres")
    return float(value)


def _whole(name: str, value: Any, low: int, high: int) -> int:
    fits = isinstance(value, int) and not isinstance(value, bool) and low <= value <= high
    _require(fits, name, value, f"an integer from {low} to {high}")
    return int(value)


def _text(name: str, value: Any) -> str:
    """Return a text that can be written: JSON can express halves of characters, which no file can hold."""
    fits = isinstance(value, str) and not any("\ud800" <= letter <= "\udfff" for letter in value)
    _require(fits, name, value, "a text")
    return str(value)


def _require(fits: bool, name: str, found: Any, accepted: str) -> None:
    if not fits:
        raise ValueError(f"{_clean(name)} must be {accepted} (got {_shown(found)})")


def _shown(value: Any) -> str:
    if isinstance(value, int) and abs(value) > MAX_BOXES:
        return "a very large number" if value > 0 else "a very large negative number"
    return _clean("nothing" if value is None else reprlib.repr(value))


def _clean(text: str) -> str:
    short = text if len(text) <= _SHOWN else text[:_SHOWN] + "…"
    return short if short.isprintable() else ascii(short)
