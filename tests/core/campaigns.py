"""Tests of the engine by the ten thousand, in blocks that are kept: a run may be stopped and gone on with.

`python -m tests.core.campaigns poses --count 20000`, and the same with `edits --count 100000`: see `tests.core.poses`
and `tests.core.edits`. A line per block goes into out/campaigns.txt; blocks that were tried with other sources are
tried again.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import sys
from collections import Counter
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from threading import Lock
from typing import NamedTuple

REPOSITORY = Path(__file__).resolve().parents[2]
SOURCES = ("core/engine", "core/kernels", "core/sensing", "core/scene", "core/metric", "core/rig")
OF_THE_TESTS = ("every_ray.py", "poses.py", "edits.py", "rooms.py", "builders.py")


class Block(NamedTuple):
    """Numbers first to first + count - 1 of a campaign, tried together."""

    what: str
    first: int
    size: int


class Outcome(NamedTuple):
    """What a block gave: how many of each kind, and what was wrong."""

    kinds: Counter[str]
    wrong: tuple[str, ...]


def poses(block: Block) -> Outcome:
    """Try poses by number."""
    from tests.core.poses import try_pose

    every = [try_pose(seed) for seed in range(block.first, block.first + block.size)]
    return Outcome(Counter(way for way, _ in every), tuple(told for _, told in every if told))


def edits(block: Block) -> Outcome:
    """Try one chain of edits, whose number is that of its first edit."""
    from tests.core.edits import try_edits

    told = try_edits(block.first, block.size)
    return Outcome(Counter(edits=block.size), (told,) if told else ())


CAMPAIGNS: dict[str, tuple[Callable[[Block], Outcome], int]] = {"poses": (poses, 50), "edits": (edits, 250)}
"""What is tried, and how many of them in a block."""


def state_of_sources() -> str:
    """What the outcomes depend on."""
    digest = hashlib.sha256()
    files = [path for folder in SOURCES for path in sorted((REPOSITORY / folder).rglob("*.py"))]
    files += [REPOSITORY / "tests" / "core" / name for name in OF_THE_TESTS]
    for path in (*files, REPOSITORY / "assets" / "library.yaml"):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


MakePool = Callable[[int], Executor]


class Log:
    """Outcomes of blocks that were tried with the present sources, and a file that holds those of others too."""

    def __init__(self, path: Path, state: str) -> None:
        self._path, self._state, self._lock = path, state, Lock()
        self.outcomes: dict[Block, Outcome] = {}
        for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else []:
            tried_with, what, first, count, kinds, *wrong = line.split("\t")
            if tried_with == state:
                known = Counter({name: int(n) for name, n in (kind.split("=") for kind in kinds.split())})
                self.outcomes[Block(what, int(first), int(count))] = Outcome(known, tuple(wrong))

    def add(self, block: Block, outcome: Outcome) -> None:
        """Keep the outcome of a block."""
        kinds = " ".join(f"{name}={n}" for name, n in sorted(outcome.kinds.items()))
        words = (self._state, block.what, str(block.first), str(block.size), kinds, *outcome.wrong)
        with self._lock:
            self.outcomes[block] = outcome
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with self._path.open("a", encoding="utf-8") as stream:
                stream.write("\t".join(words) + "\n")


def blocks_of(what: str, count: int, seed: int) -> list[Block]:
    """Cut a campaign into blocks; the last may be smaller."""
    size = CAMPAIGNS[what][1]
    return [Block(what, seed + done, min(size, count - done)) for done in range(0, count, size)]


def _go_through(blocks: Iterable[Block], log: Log, make_pool: MakePool, tell: Callable[[str], None]) -> None:
    """Try blocks in a process of their own, and in a new one after a block that ends it."""
    pool = make_pool(1)
    try:
        for block in blocks:
            try:
                outcome = pool.submit(CAMPAIGNS[block.what][0], block).result()
            except BrokenProcessPool:
                pool = make_pool(1)
                outcome = Outcome(
                    Counter(), (f"{block.what} from {block.first}, {block.size}: ended the process",)
                )
            log.add(block, outcome)
            tell("\n".join((f"{len(log.outcomes)} blocks", *outcome.wrong)))
    finally:
        pool.shutdown(cancel_futures=True)


def run(
    blocks: list[Block],
    log: Log,
    jobs: int = 1,
    tell: Callable[[str], None] = print,
    make_pool: MakePool = ProcessPoolExecutor,
) -> Outcome:
    """Try the blocks that are not in the log; return what all of them gave together."""
    left = [block for block in blocks if block not in log.outcomes]
    with ThreadPoolExecutor(jobs) as threads:
        parts = [left[start::jobs] for start in range(jobs)]
        for done in [threads.submit(_go_through, part, log, make_pool, tell) for part in parts if part]:
            done.result()
    every = [log.outcomes[block] for block in blocks]
    kinds: Counter[str] = Counter()
    for outcome in every:
        kinds.update(outcome.kinds)
    return Outcome(kinds, tuple(told for outcome in every for told in outcome.wrong))


def main() -> int:
    """Run a campaign as the command line says; exit code 1 when something is wrong."""
    words = argparse.ArgumentParser(prog="python -m tests.core.campaigns", description=__doc__)
    words.add_argument("what", choices=sorted(CAMPAIGNS))
    words.add_argument("--count", type=int, default=1_000)
    words.add_argument(
        "--seed", type=int, default=1, help="the first number; the next campaign begins where this one ends"
    )
    words.add_argument("--jobs", type=int, default=1, help="processes at a time, of one thread each")
    words.add_argument("--log", type=Path, default=REPOSITORY / "out" / "campaigns.txt")
    said = words.parse_args()
    os.environ["NUMBA_NUM_THREADS"] = "1"  # of the processes that are started here
    log = Log(said.log, state_of_sources())
    found = run(blocks_of(said.what, said.count, said.seed), log, said.jobs)
    kinds = ", ".join(f"{name} {n:,}" for name, n in found.kinds.most_common())
    print(
        f"{found.kinds.total():,} {said.what} from {said.seed} ({kinds}): {len(found.wrong)} wrong",
        *found.wrong,
        sep="\n",
    )
    return 1 if found.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
