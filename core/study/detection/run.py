"""Makes the pieces of a study that are not there yet, in processes of one thread each."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from multiprocessing import get_context, parent_process
from multiprocessing.queues import Queue
from multiprocessing.synchronize import Event
from pathlib import Path
from queue import Empty
from typing import Any

from riglens.core.detect.net import use_one_thread
from riglens.core.simulate.world import Worlds
from riglens.core.study.detection.pieces import Net, Pieces, Study, Tell
from riglens.core.study.detection.protocol import Entrant

_TELL_EVERY = 0.2
_WEIGHT = {"sweeps": 1.0, "net": 8.0, "found": 0.3}
"""About how long pieces take beside each other; for the progress alone."""


@dataclass(frozen=True)
class Job:
    """One piece to make: sweeps of a rig, a net, or what a net finds for a rig."""

    net: Net | None
    rig: Entrant | None

    @property
    def kind(self) -> str:
        """Which piece it makes."""
        return "sweeps" if self.net is None else "net" if self.rig is None else "found"

    @property
    def title(self) -> str:
        """What is done, for a person."""
        if self.net is None:
            assert self.rig is not None
            return f"sweeps of {self.rig.name}"
        of = f"seed {self.net.seed + 1}"
        if self.rig is not None:
            return f"{self.rig.name}, {of}"
        return f"net of {of}" if len(self.net.judges) > 1 else f"net of {self.net.judges[0].name}, {of}"


@dataclass(frozen=True)
class Told:
    """How far a study is: share of the work, pieces done and in all, and what is under way."""

    share: float
    done: int
    pieces: int
    doing: tuple[str, ...]
    finished: Job | None = None


class Stopped(Exception):
    """Somebody cancelled; what is done so far is kept."""


def jobs(study: Study) -> list[Job]:
    """All pieces of a study, in an order in which they can be made."""
    sweeps = [Job(None, one) for one in study.trained_on]
    nets = [Job(net, None) for net in study.nets]
    return [*sweeps, *nets, *(Job(net, one) for net in study.nets for one in net.judges)]


def is_made(pieces: Pieces, job: Job) -> bool:
    """Whether a piece is there."""
    if job.net is None:
        assert job.rig is not None
        return pieces.has_sweeps(job.rig)
    return pieces.has_net(job.net) if job.rig is None else pieces.has_found(job.net, job.rig)


def make(pieces: Pieces, job: Job, worlds: Worlds, tell: Tell) -> None:
    """Make a piece, whose own pieces are there."""
    if job.net is None:
        assert job.rig is not None
        pieces.make_sweeps(job.rig, worlds, tell)
    elif job.rig is None:
        pieces.make_net(job.net, tell)
    else:
        pieces.make_found(job.net, job.rig, tell)


def run(study: Study, folder: Path, workers: int, tell: Callable[[Told], None]) -> Pieces:
    """Make what is not there; `tell` hears of it several times a second, and may raise to stop.

    Raise what a piece raised, after the others were stopped; what was made is kept in the folder.
    """
    folder.mkdir(parents=True, exist_ok=True)
    pieces = Pieces(study, folder)
    todo = Todo(pieces, jobs(study))
    tell(todo.told({}))
    if not todo.waiting:
        return pieces
    with _pool(pieces, min(workers, len(todo.waiting))) as (pool, heard, stop):
        try:
            _work_off(todo, pool, heard, tell)
        except BaseException:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return pieces


class Todo:
    """What is still to be made, and what can be begun."""

    def __init__(self, pieces: Pieces, every: list[Job]) -> None:
        self.every = every
        self.made = {number for number, job in enumerate(every) if is_made(pieces, job)}
        self.waiting = [number for number in range(len(every)) if number not in self.made]
        self._needs = {number: self._needed(every[number]) for number in self.waiting}
        self._total = sum(_WEIGHT[job.kind] for job in every)

    def ready(self) -> list[int]:
        """What can be begun now, taken off the waiting list."""
        ready = [number for number in self.waiting if self._needs[number] <= self.made]
        self.waiting = [number for number in self.waiting if number not in ready]
        return ready

    def _needed(self, job: Job) -> set[int]:
        if job.net is None:
            return set()
        rigs = {one.key for one in (job.net.trains if job.rig is None else (job.rig,))}
        needed = set()
        for number, other in enumerate(self.every):
            if other.net is None and other.rig is not None and other.rig.key in rigs:
                needed.add(number)
            if job.rig is not None and other.net is job.net and other.rig is None:
                needed.add(number)
        return needed

    def told(self, under_way: dict[int, float], finished: int | None = None) -> Told:
        """How far it is, with the shares done of what is under way."""
        done = sum(_WEIGHT[self.every[number].kind] for number in self.made)
        done += sum(_WEIGHT[self.every[number].kind] * share for number, share in under_way.items())
        doing = tuple(self.every[number].title for number in sorted(under_way))
        job = None if finished is None else self.every[finished]
        return Told(done / self._total, len(self.made), len(self.every), doing, job)


def _work_off(todo: Todo, pool: ProcessPoolExecutor, heard: Queue[Any], tell: Callable[[Told], None]) -> None:
    running: dict[Future[int], int] = {}
    shares: dict[int, float] = {}
    while todo.waiting or running:
        running |= {pool.submit(_make, number, todo.every[number]): number for number in todo.ready()}
        done, _ = wait(running, timeout=_TELL_EVERY, return_when=FIRST_COMPLETED)
        for number, share in _said(heard):
            if number not in todo.made:
                shares[number] = share
        for future in done:
            number = running.pop(future)
            future.result()
            todo.made.add(number)
            shares.pop(number, None)
            tell(todo.told(shares, number))
        tell(todo.told(shares))


def _said(heard: Queue[Any]) -> Iterator[tuple[int, float]]:
    while True:
        try:
            yield heard.get_nowait()
        except Empty:
            return


@contextmanager
def _pool(pieces: Pieces, workers: int) -> Iterator[tuple[ProcessPoolExecutor, Queue[Any], Event]]:
    context = get_context("spawn")  # a forked child would inherit the threads of kernels and of the window
    heard, stop = context.Queue(), context.Event()
    with ProcessPoolExecutor(workers, context, _begin, (pieces, heard, stop)) as pool:
        yield pool, heard, stop


# ---------------------------------------------------------------- in a process of its own


class _Worker:
    """What a process knows of the study, and whom it tells."""

    def __init__(self, pieces: Pieces, heard: Queue[Any], stop: Event) -> None:
        self.pieces, self.heard, self.stop = pieces, heard, stop

    @cached_property
    def worlds(self) -> Worlds:
        """The frames as the study's settings make them."""
        return Worlds(self.pieces.study.traffic, self.pieces.study.protocol.simulation)

    def make(self, number: int, job: Job) -> None:
        """Make a piece."""

        def tell(share: float) -> None:
            if self.stop.is_set():
                raise Stopped
            self.heard.put((number, share))

        make(self.pieces, job, self.worlds, tell)


_here: list[_Worker] = []
"""Of a process that works for the pool: set once, before its first piece."""


def _begin(pieces: Pieces, heard: Queue[Any], stop: Event) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the owner's, who stops its processes
    threading.Thread(target=_end_with_parent, daemon=True).start()
    use_one_thread()
    _here.append(_Worker(pieces, heard, stop))


def _end_with_parent() -> None:
    """A pool whose owner was killed would wait for ever."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _make(number: int, job: Job) -> int:
    _here[0].make(number, job)
    return number
