"""POG files (.npz, never pickled) and the cache of built POGs in the user's cache folder.

A file may come from anywhere. Kernels index by the words and the counts, so these have to fit the grid and each other;
sizes are known, and compared with the memory that is free, before any of it is taken.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import reprlib
import zipfile
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import IO, Annotated, Any

import numpy as np
import psutil
from numpy.typing import NDArray
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from riglens.core.cache_folder import cache_folder, keep
from riglens.core.errors import InputError
from riglens.core.files import atomic_write, open_regular
from riglens.core.geometry import triple
from riglens.core.plain import to_plain
from riglens.core.scene.boxes import CLASSES, BoxSource, DataReport, Progress
from riglens.core.scene.columns import VoxelIndex, words_in
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.limits import MAX_FRAMES, one_line, require_few_names
from riglens.core.scene.pog import Pog, build_pog
from riglens.core.scene.statistics import FLOWS, HEIGHT_STEPS, PLACES, SIZE_STEPS, BoxStatistics

FORMAT = 1
_KEPT = 4
"""Changes with what the cache must hold: POGs of before lack the statistics of their boxes."""
_ACCEPTED = "a POG written by 'riglens data build'"
MAX_HEADER_CHARS = 1 << 25
MAX_BOXES = 1 << 62
_PIECE_BYTES = 1 << 20
_SHOWN = 40


def _header(pog: Pog) -> dict[str, Any]:
    data = pog.data
    return {
        "riglens_pog": FORMAT,
        "voxel_m": pog.grid.voxel_m,
        "roi_m": list(pog.grid.roi_m),
        "source": data.source,
        "frames": data.frames,
        "boxes": data.boxes,
        "unmapped": dict(data.unmapped),
        "sha256": data.sha256,
        "notes": list(data.notes),
        "sequences": data.sequences,
        **({} if data.statistics is None else {"statistics": to_plain(data.statistics)}),
    }


def _digest(header: str, words: np.ndarray, counts: np.ndarray) -> str:
    digest = hashlib.sha256(header.encode())
    digest.update(np.ascontiguousarray(words).data)
    digest.update(np.ascontiguousarray(counts).data)
    return digest.hexdigest()


def save_pog(pog: Pog, path: Path | str) -> None:
    """Write a POG atomically; InputError when the place cannot be written."""
    with atomic_write(Path(path), "wb") as file:
        write_pog(pog, file)


def write_pog(pog: Pog, file: IO[bytes], level: int = 6) -> None:
    """Write a POG into an open file; `level` 1 to 9 sets the effort of compression."""
    header, counts = json.dumps(_header(pog), sort_keys=True), pog.counts
    digest = _digest(header, pog.index.words, counts)
    arrays = {
        "header": np.array(header),
        "digest": np.array(digest),
        "words": pog.index.words,
        "counts": counts,
    }
    # what numpy.savez_compressed does, which leaves no choice of the level; in memory, since an archive that is
    # interrupted ends itself when it is collected, and a file would be closed by then
    packed = BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=level) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, array, allow_pickle=False)
    file.write(packed.getbuffer())


def load_pog(path: Path | str) -> Pog:
    """Read a POG file; InputError when it is missing, damaged, or not a POG (nothing is ever unpickled)."""
    try:
        with open_regular(Path(path), _ACCEPTED) as file:
            try:
                return read_pog(file)
            except OSError:
                raise
            except Exception as error:  # of damaged bytes numpy, zipfile and zlib raise a dozen kinds
                reason = one_line(str(error)) or type(error).__name__
                raise InputError(f"{path}: not {_ACCEPTED}: {reason}") from error
    except FileNotFoundError as error:
        raise InputError(f"{path}: no such file (must be {_ACCEPTED})") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from error


def read_pog(file: IO[bytes], is_part: bool = False) -> Pog:
    """Return the POG in an open file; damaged bytes may raise any error. is_part: whether it may hold no frame."""
    if not zipfile.is_zipfile(file):
        raise ValueError("no archive of numpy")
    file.seek(0)
    with zipfile.ZipFile(file) as archive:
        header = _read_text(archive, "header", MAX_HEADER_CHARS)
        grid, data = _checked_header(json.loads(header), is_part)
        words = _read_array(archive, "words", (words_in(grid),), (np.uint64,))
        voxels = VoxelIndex.of(grid, words)
        counts = _read_array(archive, "counts", (voxels.count, len(CLASSES)), (np.uint16, np.uint32))
        digest = _read_text(archive, "digest", 64)
    if _digest(header, words, counts) != digest:
        raise ValueError("checksum differs")
    most = int(counts.max(initial=0))
    if most > data.frames:
        raise ValueError(f"counts must be at most {data.frames}, the number of frames (got {most})")
    return Pog.of(grid, data, voxels, counts)


def pog_key(content_hash: str, grid: VoxelGrid) -> str:
    """Return a name for the POG of boxes with this hash on this grid, which no others share."""
    key = json.dumps(
        [FORMAT, _KEPT, content_hash, grid.voxel_m.hex(), [side.hex() for side in map(float, grid.roi_m)]]
    )
    return f"pog-{hashlib.sha256(key.encode()).hexdigest()[:32]}"


def cached_pog(source: BoxSource, grid: VoxelGrid, progress: Progress | None = None) -> Pog:
    """Return the POG of a data set, from the cache when its content was seen before; rebuilt when damaged."""
    path = cache_folder() / f"{pog_key(source.content_hash, grid)}.npz"
    with contextlib.suppress(InputError):  # missing, unreadable or damaged: build it in any case
        pog = load_pog(path)
        if pog.grid != grid:
            raise InputError(f"{path}: holds another grid than its name says")
        return replace(pog, data=replace(pog.data, source=source.name))  # an equal copy may have been first
    pog = build_pog(source, grid, progress)
    keep(path, lambda place: save_pog(pog, place))
    return pog


# ---------------------------------------------------------------- members of a file


def _encodable(text: str) -> str:
    """Return a text that can be written: JSON can express halves of characters, which no file can hold."""
    text.encode()
    return text


_Text = Annotated[str, AfterValidator(_encodable)]
_Count = Annotated[int, Field(ge=0, le=MAX_FRAMES)]
_Tally = dict[_Text, Annotated[int, Field(ge=0, le=MAX_BOXES)]]
_Length = Annotated[float, Field(gt=0.0, le=1e9)]
_Place = Annotated[float, Field(ge=-1e9, le=1e9)]


_Flat = dict[str, Annotated[int, Field(ge=1, le=MAX_BOXES)]]
"""Numbers of boxes by flat index, which is a text in JSON."""


class _Statistics(BaseModel):
    """Statistics of boxes, which a survey looks up by index."""

    model_config = ConfigDict(strict=True)

    placed: _Flat
    sizes: _Flat
    bottoms: _Flat
    centres: _Flat = {}
    flows: _Flat = {}
    frames: _Count
    most: _Count
    repeated: _Count = 0
    yaw_rad: Annotated[float, Field(ge=0.0, le=1e300)] = 0.0
    origin_m: Annotated[list[_Place], Field(min_length=3, max_length=3)] | None
    is_origin_known: bool

    def read(self) -> BoxStatistics:
        """Return the statistics; ValueError for an index that is none."""
        return BoxStatistics(
            _indexed(self.placed, PLACES),
            _indexed(self.sizes, 3 * SIZE_STEPS),
            _indexed(self.bottoms, HEIGHT_STEPS),
            _indexed(self.centres, HEIGHT_STEPS),
            _indexed(self.flows, len(FLOWS)),
            self.frames,
            self.most,
            self.repeated,
            self.yaw_rad,
            None if self.origin_m is None else triple(self.origin_m),
            self.is_origin_known,
        )


def _indexed(tally: Mapping[str, int], of_class: int) -> Counter[int]:
    size = len(CLASSES) * of_class
    found = {int(name): count for name, count in tally.items() if name.isdecimal() and len(name) < 10}
    if len(found) < len(tally) or max(found, default=0) >= size:
        raise ValueError(f"statistics must have indices below {size}")
    return Counter(found)


class _Fields(BaseModel):
    """Fields of a header; files of before have no notes, sequences or statistics."""

    model_config = ConfigDict(strict=True)

    voxel_m: _Length
    roi_m: list[_Length] = Field(min_length=3, max_length=3)
    source: _Text
    frames: _Count
    boxes: _Tally
    unmapped: _Tally
    sha256: _Text
    notes: list[_Text] = []
    sequences: _Count = 1
    statistics: _Statistics | None = None


def _checked_header(fields: Any, is_part: bool) -> tuple[VoxelGrid, DataReport]:
    """Return what the header of a POG describes; raise ValueError that names the field."""
    found = fields.get("riglens_pog") if isinstance(fields, dict) else None
    if found != FORMAT:
        raise ValueError(f"header: format {_shown(found)} is not supported")
    try:
        read = _Fields.model_validate(fields)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        place = ascii(".".join(map(str, first["loc"])))[1:-1]
        got = "" if first["type"] == "missing" else f" (got {_shown(first['input'])})"
        raise ValueError(f"{place[:_SHOWN]} {first['msg'].replace('Input should', 'must')}{got}") from error
    if read.frames < 1 and not is_part:
        raise ValueError("frames must be at least 1 (got 0)")
    require_few_names(read.unmapped, "unmapped")
    length, width, height = read.roi_m
    data = DataReport(
        read.source,
        read.frames,
        {name: read.boxes.get(name, 0) for name in CLASSES},
        Counter(read.unmapped),
        read.sha256,
        tuple(read.notes),
        read.sequences,
        statistics=None if read.statistics is None else read.statistics.read(),
    )
    return VoxelGrid(read.voxel_m, (length, width, height)), data


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


def _shown(value: object) -> str:
    return one_line(reprlib.repr(value), _SHOWN)
