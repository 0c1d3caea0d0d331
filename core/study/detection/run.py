"""Makes the pieces of a study that are not there yet."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass
from pathlib import Path

from riglens.core.pieces.work import Piece, Workers, results
from riglens.core.study.detection.making import make
from riglens.core.study.detection.pieces import Job, Pieces, Study, jobs

_SWEEPS, _NET, _FOUND = 1.0, 8.0, 0.3
"""Approximate durations of pieces, relative to each other; for progress only."""


@dataclass(frozen=True)
class StudyProgress:
    """Progress of a study: share of the work, pieces done and in all, and the one that was just made."""

    share: float
    done: int
    pieces: int
    finished: Job | None = None


def run(study: Study, folder: Path, workers: Workers, tell: Callable[[StudyProgress], None]) -> Pieces:
    """Make the missing pieces; `tell` is called at the start and after each piece, and may raise to stop."""
    pieces = Pieces(study, folder.resolve())
    every = {job.key(study): job for job in jobs(study)}
    done = _superseded(pieces)
    done |= {key for key in every if key not in done and pieces.store.load(key) is not None}
    tell(_told(study, every, done))
    missing = [_piece(pieces, key, job) for key, job in every.items() if key not in done]
    for piece, _ in results(missing, pieces.store, workers):
        job = every[piece.key]
        done.add(piece.key)
        if job.is_pass and job.epoch > 1:
            pieces.store.remove(Job(job.net, None, job.epoch - 1).key(study))
        tell(_told(study, every, done, job))
    return pieces


def _superseded(pieces: Pieces) -> set[str]:
    """Return the passes of trainings that later ones, which are kept, went on from."""
    study, found = pieces.study, set[str]()
    for net in study.nets:
        keys = [Job(net, None, epoch).key(study) for epoch in range(1, study.protocol.epochs + 1)]
        kept = [place for place, key in enumerate(keys) if pieces.store.load(key) is not None]
        found |= set(keys[: max(kept, default=0)])
    return found


def _piece(pieces: Pieces, key: str, job: Job) -> Piece:
    before = job.after(pieces.study)

    def arguments() -> tuple[object, ...]:
        state = pieces.of(before[-1]) if before and before[-1].is_pass else None
        return pieces.study, job, pieces.folder, state

    return Piece(key, make, arguments, tuple(one.key(pieces.study) for one in before))


def _told(
    study: Study, every: Mapping[str, Job], done: Set[str], finished: Job | None = None
) -> StudyProgress:
    weights = {key: _weight(study, job) for key, job in every.items()}
    share = sum(weights[key] for key in done) / sum(weights.values())
    return StudyProgress(share, len(done), len(every), finished)


def _weight(study: Study, job: Job) -> float:
    if job.is_pass:
        return _NET / study.protocol.epochs
    return _SWEEPS if job.net is None else _FOUND
