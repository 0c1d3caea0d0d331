"""Build the POG of a large data set part by part: in parallel, and resumable after an interruption.

The parts of a data set (logs, sequences, tables) are put together into at most MAX_GROUPS groups. The POG of each
group is kept until the whole is done, under a name that follows from its content and the grid; what exists already is
not built again.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from io import BytesIO
from itertools import pairwise
from pathlib import Path

from riglens.core.pieces.folder import PieceFolder
from riglens.core.pieces.work import Piece, Workers, results
from riglens.core.scene.boxes import DataReport, Progress
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog, PogSum, build_part
from riglens.core.scene.pog_store import pog_key, read_pog, write_pog
from riglens.core.scene.readers.collection import BoxCollection
from riglens.core.scene.readers.opening import Source

MAX_GROUPS = 256
_ONE_BUILD_PER_PROCESS = threading.Lock()
"""A Dask worker runs tasks in several threads, but the parallel kernels may run in only one at a time."""


def part_folder(folder: Path) -> PieceFolder[Pog]:
    """Return the store of finished groups in a folder."""
    return PieceFolder(folder, _read_part)


def groups_of(source: Source, at_most: int = MAX_GROUPS) -> list[BoxCollection]:
    """Return the parts of a data set in their order, in groups of about as many parts each."""
    parts = source.parts()
    count = min(len(parts), at_most)
    cuts = [len(parts) * place // count for place in range(count + 1)]
    return [BoxCollection(source.name, parts[start:end], is_part=True) for start, end in pairwise(cuts)]


def build_in_parts(
    source: Source,
    groups: Sequence[BoxCollection],
    grid: VoxelGrid,
    store: PieceFolder[Pog],
    workers: Workers,
    progress: Progress | None = None,
) -> Pog:
    """Return the POG of a data set from those of its groups, the same to the last bit as built in one go.

    Finished groups stay in the store when the build is interrupted. Raises InputError on bad input or when the grid
    does not fit in memory.
    """
    total, reports = PogSum(grid), dict[Piece, DataReport]()
    pieces = [_piece(group, grid, workers.threads) for group in groups]
    for done, (piece, part) in enumerate(results(pieces, store, workers), 1):
        total.add(part)
        reports[piece] = part.data
        if progress is not None:
            progress(done / len(pieces))
    return total.pog(source.merged([reports[piece] for piece in pieces]))


def _piece(group: BoxCollection, grid: VoxelGrid, threads: int | None) -> Piece:
    return Piece(pog_key(group.content_hash, grid), group_file, lambda: (group, grid, threads))


def group_file(group: BoxCollection, grid: VoxelGrid, threads: int | None = None) -> bytes:
    """Return the content of a group's POG file; InputError on bad input.

    The content hash of the data is computed again, so that other files under the same paths on a worker are noticed.
    """
    stream = BytesIO()
    group.forget_hashes()
    with _ONE_BUILD_PER_PROCESS:
        write_pog(build_part(group, grid, threads=threads), stream, level=1)
    return stream.getvalue()


def _read_part(key: str, content: bytes) -> Pog:
    """Return the POG of a group; ValueError when it is that of other data or of another grid."""
    part = read_pog(BytesIO(content), is_part=True)
    if pog_key(part.data.sha256, part.grid) != key:
        raise ValueError(
            "a part of other data or of another grid: do the files there differ from those here?"
        )
    return part
