"""Building the POG of a large data set part by part: in parallel, and so that an interrupted build goes on.

The parts of a data set (logs, sequences, tables) are put together into at most MAX_GROUPS groups. The POG of each
group is an ordinary POG file, kept until the whole is done, under a name that follows from its content and the grid;
what exists already is not built again.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from io import BytesIO
from itertools import islice, pairwise
from pathlib import Path
from typing import Protocol

from riglens.core.errors import InputError
from riglens.core.files import atomic_write
from riglens.core.scene.boxes import DataReport, Progress
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog, PogSum, build_part
from riglens.core.scene.pog_store import load_pog, pog_file_name, read_pog, write_pog
from riglens.core.scene.readers.collection import BoxCollection
from riglens.core.scene.readers.opening import Source

MAX_GROUPS = 256
_ONE_BUILD_PER_PROCESS = threading.Lock()
"""A Dask worker runs tasks in several threads, but the parallel kernels may run in only one at a time."""


class Workers(Protocol):
    """Where groups are built; `ahead` is how many to hand in before waiting for the first result."""

    ahead: int

    def submit(self, group: BoxCollection, grid: VoxelGrid) -> Future[bytes]:
        """Begin to build one group; the result is the content of its POG file."""

    def wait(self, waiting: Collection[Future[bytes]]) -> Collection[Future[bytes]]:
        """Wait for one of the futures at least, and return those that are done."""


class OwnProcess:
    """Builds in the calling process, one group after another."""

    ahead = 1

    def submit(self, group: BoxCollection, grid: VoxelGrid) -> Future[bytes]:
        """Build now."""
        return self.call(group_file, group, grid)

    def call(self, work: Callable[..., bytes], *arguments: object) -> Future[bytes]:
        """Call a function now."""
        done: Future[bytes] = Future()
        done.set_result(work(*arguments))
        return done

    def wait(self, waiting: Collection[Future[bytes]]) -> Collection[Future[bytes]]:
        """Return them all: they were done before they were handed out."""
        return list(waiting)


class PartStore:
    """The finished groups, as files in a folder that exists while there are any."""

    def __init__(self, folder: Path, grid: VoxelGrid) -> None:
        self.folder, self._grid = folder, grid

    def load(self, group: BoxCollection) -> Pog | None:
        """A group that was finished before; None when it was not, or its file is damaged."""
        with contextlib.suppress(InputError):
            part = load_pog(self._file(group), is_part=True)
            return part if part.grid == self._grid else None
        return None

    def save(self, group: BoxCollection, content: bytes) -> None:
        """Keep a finished group; InputError when it cannot be written."""
        with contextlib.suppress(FileExistsError):
            self.folder.mkdir()
        with atomic_write(self._file(group), "wb") as file:
            file.write(content)

    def count(self) -> int:
        """How many groups are kept."""
        return len(list(self.folder.glob("pog-*.npz")))

    def clear(self) -> None:
        """Remove the files, and the folder when nothing else is in it."""
        for file in (*self.folder.glob("pog-*.npz"), *self.folder.glob(".pog-*.tmp")):
            with contextlib.suppress(OSError):
                file.unlink()
        with contextlib.suppress(OSError):
            self.folder.rmdir()

    def _file(self, group: BoxCollection) -> Path:
        return self.folder / pog_file_name(group, self._grid)


@dataclass(frozen=True)
class PartsPlan:
    """A data set in groups, and which of them an earlier build has finished."""

    source: Source
    groups: Sequence[BoxCollection]
    store: PartStore

    @classmethod
    def of(cls, source: Source, grid: VoxelGrid, folder: Path) -> PartsPlan:
        """Group the parts of a data set; finished groups are kept in `folder`."""
        return cls(source, groups_of(source), PartStore(folder, grid))


def groups_of(source: Source, at_most: int = MAX_GROUPS) -> list[BoxCollection]:
    """The parts of a data set in their order, in groups of about as many parts each."""
    parts = source.parts()
    count = min(len(parts), at_most)
    cuts = [len(parts) * place // count for place in range(count + 1)]
    return [BoxCollection(source.name, parts[start:end], is_part=True) for start, end in pairwise(cuts)]


def build_in_parts(
    plan: PartsPlan, grid: VoxelGrid, workers: Workers, progress: Progress | None = None
) -> Pog:
    """The POG of a data set from those of its groups, the same to the last bit as built in one go.

    Finished groups stay in the plan's store when the build is interrupted. Raises InputError on bad input or
    when the grid does not fit in memory.
    """
    total, reports = PogSum(grid), dict[int, DataReport]()

    def take(place: int, part: Pog) -> None:
        total.add(part)
        reports[place] = part.data
        if progress is not None:
            progress(len(reports) / len(plan.groups))

    missing = []
    for place, group in enumerate(plan.groups):
        part = plan.store.load(group)
        if part is None:
            missing.append(place)
        else:
            take(place, part)
    for place, content in _results(plan.groups, missing, grid, workers):
        part = _received(content, plan.groups[place], grid)
        plan.store.save(plan.groups[place], content)
        take(place, part)
    return total.pog(plan.source.merged([reports[place] for place in range(len(plan.groups))]))


def group_file(group: BoxCollection, grid: VoxelGrid, threads: int | None = None) -> bytes:
    """The content of a group's POG file: what a worker computes. InputError on bad input."""
    stream = BytesIO()
    with _ONE_BUILD_PER_PROCESS:
        write_pog(build_part(group, grid, threads=threads), stream, level=1)
    return stream.getvalue()


def _received(content: bytes, group: BoxCollection, grid: VoxelGrid) -> Pog:
    """The POG that a worker sent; ChildProcessError when it is damaged or not that of the group."""
    try:
        part = read_pog(BytesIO(content), is_part=True)
    except Exception as error:  # damaged bytes make numpy, zipfile and zlib raise a dozen kinds of error
        raise ChildProcessError("a worker sent a damaged part; what is finished is kept") from error
    if part.grid != grid or part.data.sha256 != group.content_hash:
        raise ChildProcessError(
            "a worker sent a part of other data or of another grid: its files differ from those here; what is "
            "finished is kept"
        )
    return part


def _results(
    groups: Sequence[BoxCollection], places: Iterable[int], grid: VoxelGrid, workers: Workers
) -> Iterator[tuple[int, bytes]]:
    """Finished groups as they come, with never more than `ahead` handed in, so that memory stays flat.

    A group that failed is told after those that are done by then: they are kept.
    """
    waiting = dict[Future[bytes], int]()
    rest = iter(places)
    while True:
        for place in islice(rest, workers.ahead - len(waiting)):
            waiting[workers.submit(groups[place], grid)] = place
        if not waiting:
            return
        done = sorted(
            workers.wait(waiting), key=lambda future: (future.exception() is not None, waiting[future])
        )
        for future in done:
            yield waiting.pop(future), future.result()
