"""Sweeps from options: the data loaded once in each process, and all rows computed in pieces."""

from __future__ import annotations

import hashlib
import json
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from riglens.core.errors import InputError
from riglens.core.pieces.folder import PieceFolder
from riglens.core.pieces.work import Piece, Workers, results
from riglens.core.rig.library import user_library_files
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import identity_of
from riglens.core.scene.boxes import DataReport, Progress
from riglens.core.sweep.design import Sweep
from riglens.core.sweep.rows import Sweeper, SweepFigures
from riglens.core.sweep.table import joined, packed, unpacked
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.scenario import load_scenario
from riglens.evaluation.traffic import load_traffic
from riglens.version import installed_version

if TYPE_CHECKING:
    from pyarrow import Table

PIECE_RIGS, MOST_PIECES = 100, 4096
"""Fewest rigs of a piece, for which starting it costs nothing that counts; and the most pieces."""


@dataclass(frozen=True)
class SweepOptions:
    """Inputs of the rows of a sweep: data by its options, figures, and the rig that changes are measured against.

    Workers on other machines load the data by themselves.
    """

    scene: SceneOptions
    within_m: float
    figures: SweepFigures
    reference: Rig


class _Loaded(NamedTuple):
    """Data of options, and the sweeper on them."""

    options: SweepOptions
    threads: int | None
    data: tuple[DataReport, ...]
    hashes: tuple[str, ...]
    sweeper: Sweeper


class LoadedSweep:
    """A sweep with its data loaded: the header of its table, and its pieces. InputError on bad input."""

    def __init__(self, sweep: Sweep, options: SweepOptions, kind: str, threads: int | None = None) -> None:
        self.sweep, self.options, self._kind, self._threads = sweep, options, kind, threads
        self._loaded = _loaded(options, threads)

    @property
    def data(self) -> tuple[DataReport, ...]:
        """The data of scene and objects, as far as they are used."""
        return self._loaded.data

    @cached_property
    def header(self) -> dict[str, Any]:
        """Return data, settings, rigs and design as plain data; this compiles every kernel, too."""
        inputs = self._loaded.sweeper.inputs()
        self._loaded.sweeper.row(self.sweep.rig(0))
        values = self.sweep.base.tobytes() + self.sweep.values.tobytes()
        return {
            "riglens": 1,
            "version": installed_version(),
            **inputs,
            "noise_floor": self._loaded.sweeper.noise_floor(self.sweep.rigs),
            "blind_m": self.options.figures.blind_m,
            "rigs": [identity_of(rig) for rig in self.sweep.rigs],
            "design": {
                "kind": self._kind,
                "fields": {field.name: field.unit for field in self.sweep.fields},
                "rows": len(self.sweep),
                "sha256": hashlib.sha256(values).hexdigest(),
            },
        }

    @cached_property
    def _digest(self) -> str:
        return hashlib.sha256(json.dumps(self.header, sort_keys=True).encode()).hexdigest()

    def spans(self, piece_rigs: int | None = None) -> list[range]:
        """Return the rows of each piece."""
        rows = len(self.sweep)
        count = max(1, min(rows // (piece_rigs or PIECE_RIGS), MOST_PIECES))
        return [range(*pair) for pair in pairwise(rows * place // count for place in range(count + 1))]

    def key(self, span: range) -> str:
        """Return the key of a piece: a digest of everything in it."""
        text = f"{self._digest} {self._loaded.hashes} {span.start} {span.stop}"
        return f"rows-{hashlib.sha256(text.encode()).hexdigest()[:32]}"

    def table(
        self,
        store: PieceFolder[Table],
        workers: Workers,
        spans: Sequence[range],
        threads: int | None = None,
        progress: Progress = lambda _: None,
    ) -> Table:
        """Compute all rows, `threads` for each piece; raise InputError for a rig that cannot be evaluated."""
        header = self.header  # compiles every kernel before workers need them
        pieces = [self._piece(span, self._threads or threads or workers.threads) for span in spans]
        found: dict[str, Table] = {}
        for piece, table in results(pieces, store, workers):
            found[piece.key] = table
            progress(len(found) / len(pieces))
        return joined([found[piece.key] for piece in pieces], header)

    def _piece(self, span: range, threads: int | None) -> Piece:
        key, hashes = self.key(span), self._loaded.hashes
        return Piece(key, computed, lambda: (key, self.options, hashes, self.sweep.part(span), threads))


def piece_folder(folder: Path) -> PieceFolder[Table]:
    """Return the store of finished pieces in a folder."""
    return PieceFolder(folder, unpacked)


_ONE_SWEEP_PER_PROCESS = threading.Lock()
"""A Dask worker runs tasks in several threads, but the parallel kernels may run in only one at a time."""
_last: list[_Loaded] = []
"""Data of the last piece, which the next one needs too."""


def computed(
    key: str, options: SweepOptions, hashes: tuple[str, ...], part: Sweep, threads: int | None
) -> bytes:
    """Return the rows of a piece; InputError when the data here are others than those of the command."""
    with _ONE_SWEEP_PER_PROCESS:
        loaded = _loaded(options, threads, hashes)
        if loaded.hashes != hashes:
            raise InputError("has other data or sensor models than the machine of the command")
        return packed(loaded.sweeper.rows(part), key)


def _loaded(options: SweepOptions, threads: int | None, hashes: tuple[str, ...] = ()) -> _Loaded:
    """Load data; those of the last piece are used again if they have these hashes."""
    for known in _last:
        if (known.options, known.threads, known.hashes) == (options, threads, hashes):
            return known
    _last.clear()
    figures = options.figures
    field = None if figures.metric is None else load_scenario(options.scene).field
    traffic = None if figures.targets is None else load_traffic(options.scene, options.within_m)
    data = tuple(one.data for one in (field, traffic) if one is not None)
    hashes = (
        *(one.sha256 for one in data),
        "" if traffic is None else traffic.surroundings_sha256,
        hashlib.sha256(b"".join(path.read_bytes() for path in user_library_files())).hexdigest(),
    )
    sweeper = Sweeper(figures, options.reference, field, traffic, threads)
    _last.append(_Loaded(options, threads, data, hashes, sweeper))
    return _last[0]
