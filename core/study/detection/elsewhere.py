"""Makes the pieces of a study on workers that share no folder with us, such as those of a Dask cluster.

A worker is sent the study and the net that a piece goes on from; sweeps it simulates itself, the very same ones, and
keeps them for its next piece. What comes back is a file.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from riglens.core.detect.net import machine, use_one_thread
from riglens.core.errors import InputError
from riglens.core.files import write_files
from riglens.core.simulate.dataset import Workers
from riglens.core.simulate.world import Worlds
from riglens.core.study.detection.pieces import Pieces, Study
from riglens.core.study.detection.run import Job, Todo, Told, is_made, jobs, make

Files = dict[str, bytes]


def run_elsewhere(study: Study, folder: Path, workers: Workers, tell: Callable[[Told], None]) -> Pieces:
    """As `riglens.core.study.detection.run.run`, on such workers, with never more pieces handed in than needed."""
    folder.mkdir(parents=True, exist_ok=True)
    pieces = Pieces(study, folder)
    todo, ready, running = Todo(pieces, jobs(study)), deque[int](), dict[Future[bytes], int]()
    tell(todo.told({}))
    while todo.waiting or ready or running:
        ready.extend(todo.ready())
        while ready and len(running) < workers.ahead:
            number = ready.popleft()
            job = todo.every[number]
            running[workers.call(make_there, study, job, _sent_with(pieces, job))] = number
        for future in workers.wait(running):
            number = running.pop(future)
            write_files(folder, {_file(pieces, todo.every[number]).name: future.result()})
            todo.made.add(number)
            tell(todo.told({}, number))
    return pieces


def _file(pieces: Pieces, job: Job) -> Path:
    """Where a piece is kept."""
    if job.net is None:
        assert job.rig is not None
        return pieces.sweeps_file(job.rig)
    return pieces.net_file(job.net) if job.rig is None else pieces.found_file(job.net, job.rig)


def _sent_with(pieces: Pieces, job: Job) -> Files:
    """The net that is asked, or that the training of goes on."""
    if job.net is None or not pieces.net_file(job.net).exists():
        return {}
    path = pieces.net_file(job.net)
    return {path.name: path.read_bytes()}


# ---------------------------------------------------------------- on a worker


def make_there(study: Study, job: Job, sent: Mapping[str, bytes]) -> bytes:
    """Make a piece in this process, and return its file; InputError where PyTorch is another one than was asked for."""
    use_one_thread()
    here = machine(study.machine.device)
    if here != study.machine:
        raise InputError(f"found {here}, accepted is {study.machine}: figures of both are not mixed")
    with _folder() as folder:
        pieces = Pieces(study, folder)
        write_files(folder, sent)
        worlds = Worlds(study.traffic, study.protocol.simulation)
        for needed in [*_sweeps_for(job), job]:
            if not is_made(pieces, needed):
                make(pieces, needed, worlds, lambda _: None)
        return _file(pieces, job).read_bytes()


def _sweeps_for(job: Job) -> list[Job]:
    if job.net is None:
        return []
    return [Job(None, one) for one in (job.net.trains if job.rig is None else (job.rig,))]


@contextmanager
def _folder() -> Iterator[Path]:
    """The folder of this Dask worker, which goes when it ends; a folder for the while where this is none."""
    try:
        from distributed import get_worker

        there = Path(get_worker().local_directory) / "riglens-pieces"
    except (ImportError, ValueError):
        with TemporaryDirectory() as name:
            yield Path(name)
        return
    there.mkdir(parents=True, exist_ok=True)
    yield there
