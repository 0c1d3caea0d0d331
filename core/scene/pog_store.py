"""POG files (.npz, never pickled) and the cache of built POGs in the user's cache folder."""

from __future__ import annotations

import contextlib
import hashlib
import json
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import IO, Any

import numpy as np

from riglens.core.cache_folder import cache_folder, keep
from riglens.core.errors import InputError
from riglens.core.files import atomic_write, open_regular
from riglens.core.scene.boxes import BoxSource, Progress
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.limits import one_line
from riglens.core.scene.pog import Pog, build_pog
from riglens.core.scene.pog_checks import read_content

FORMAT = 1
_ACCEPTED = "a POG written by 'riglens data build'"


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
    header = json.dumps(_header(pog), sort_keys=True)
    digest = _digest(header, pog.index.words, pog.counts)
    arrays = {
        "header": np.array(header),
        "digest": np.array(digest),
        "words": pog.index.words,
        "counts": pog.counts,
    }
    # what numpy.savez_compressed does, which leaves no choice of the level
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=level) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, array, allow_pickle=False)


def load_pog(path: Path | str) -> Pog:
    """Read a POG file; InputError when it is missing, damaged, or not a POG (nothing is ever unpickled)."""
    try:
        with open_regular(Path(path), _ACCEPTED) as file:
            return _read_named(file, path)
    except FileNotFoundError as error:
        raise InputError(f"{path}: no such file (must be {_ACCEPTED})") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from error


def _read_named(file: IO[bytes], path: Path | str) -> Pog:
    try:
        return read_pog(file)
    except OSError:
        raise
    except Exception as error:  # damaged bytes make numpy, zipfile and zlib raise a dozen kinds of error
        reason = one_line(str(error)) or type(error).__name__
        raise InputError(f"{path}: not {_ACCEPTED}: {reason}") from error


def read_pog(file: IO[bytes], is_part: bool = False) -> Pog:
    """Return the POG in an open file; damaged bytes may raise any error. is_part: whether it may hold no frame."""
    if not zipfile.is_zipfile(file):
        raise ValueError("no archive of numpy")
    file.seek(0)
    with zipfile.ZipFile(file) as archive:
        content = read_content(archive, FORMAT, is_part)
    pog = content.pog
    if _digest(content.text, pog.index.words, pog.counts) != content.digest:
        raise ValueError("checksum differs")
    return pog


def pog_key(content_hash: str, grid: VoxelGrid) -> str:
    """Return a name for the POG of boxes with this hash on this grid, which no others share."""
    key = json.dumps(
        [FORMAT, content_hash, grid.voxel_m.hex(), [side.hex() for side in map(float, grid.roi_m)]]
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
