"""A POG built part by part is the one built in one go, to the last bit, and an interrupted build goes on."""

import os
import signal
from collections.abc import Collection
from concurrent.futures import Future
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.errors import InputError
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog, build_pog
from riglens.core.scene.pog_parts import OwnProcess, PartsPlan, build_in_parts, groups_of
from riglens.core.scene.pog_processes import worker_processes
from riglens.core.scene.readers import open_boxes
from riglens.core.scene.readers.collection import BoxCollection

GRID = VoxelGrid(0.5, (20.0, 16.0, 4.0))
HEADER = "seq,frame,cls,x,y,z,length,width,height,yaw\n"
CLASSES = ("car", "bicycle", "pedestrian", "cow")


def sequence(number: int, frames: int = 5) -> str:
    """The rows of one sequence of its own."""
    random = np.random.default_rng(number)
    rows = []
    for frame in range(frames):
        for _ in range(6):
            x, y, z = random.uniform([-9, -7, 0], [9, 7, 2])
            size = ",".join(f"{edge:.3f}" for edge in random.uniform(0.5, 5, 3))
            name = CLASSES[random.integers(4)]
            rows.append(
                f"s{number},{frame},{name},{x:.3f},{y:.3f},{z:.3f},{size},{random.uniform(-3, 3):.3f}\n"
            )
    return "".join(rows)


def tables(folder: Path, split: list[list[int]]) -> list[Path]:
    """One table for each list of sequences."""
    folder.mkdir(exist_ok=True)
    paths = []
    for place, numbers in enumerate(split):
        paths.append(folder / f"{place:03d}.csv")
        paths[-1].write_text(HEADER + "".join(map(sequence, numbers)))
    return paths


def assert_same(found: Pog, expected: Pog) -> None:
    assert np.array_equal(found.index.words, expected.index.words)
    assert found.counts.dtype == expected.counts.dtype
    assert np.array_equal(found.counts, expected.counts)
    for name in ("frames", "boxes", "unmapped", "notes", "sequences"):
        assert getattr(found.data, name) == getattr(expected.data, name)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Pog:
    """Eight sequences in one table, built in one go."""
    return build_pog(open_boxes(tables(tmp_path_factory.mktemp("whole"), [list(range(8))])), GRID)


@settings(max_examples=30)
@given(
    order=st.permutations(range(8)),
    cuts=st.sets(st.integers(1, 7)),
    turns=st.randoms(use_true_random=False),
)
def test_splits_and_orders_of_parts_change_no_bit(
    whole: Pog, tmp_path_factory: pytest.TempPathFactory, order: list[int], cuts: set[int], turns: object
) -> None:
    borders = [0, *sorted(cuts), 8]
    split = [order[a:b] for a, b in pairwise(borders)]
    folder = tmp_path_factory.mktemp("split")
    paths = tables(folder, split)
    turns.shuffle(paths)  # type: ignore[attr-defined]
    plan = PartsPlan.of(open_boxes(paths), GRID, folder / "parts")
    assert_same(build_in_parts(plan, GRID, OwnProcess()), whole)


class Counted(OwnProcess):
    """Builds here, and stops as if by Ctrl-C after some groups."""

    def __init__(self, stop_after: int = 1000) -> None:
        self.built = 0
        self._left = stop_after

    def submit(self, group: BoxCollection, grid: VoxelGrid) -> Future[bytes]:
        if self._left == 0:
            raise KeyboardInterrupt
        self._left -= 1
        self.built += 1
        return super().submit(group, grid)


@pytest.fixture
def paths(tmp_path: Path) -> list[Path]:
    return tables(tmp_path / "data", [[number] for number in range(8)])


def test_an_interrupted_build_goes_on_where_it_was(whole: Pog, paths: list[Path], tmp_path: Path) -> None:
    store = tmp_path / "parts"
    with pytest.raises(KeyboardInterrupt):
        build_in_parts(PartsPlan.of(open_boxes(paths), GRID, store), GRID, Counted(3))
    plan, second = PartsPlan.of(open_boxes(paths), GRID, store), Counted()
    assert plan.store.count() == 3
    heard: list[float] = []
    assert_same(build_in_parts(plan, GRID, second, heard.append), whole)
    assert second.built == 5
    assert heard == [(n + 1) / 8 for n in range(8)]
    plan.store.clear()
    assert not store.exists()


def test_parts_of_other_data_or_another_grid_are_not_taken(paths: list[Path], tmp_path: Path) -> None:
    store = tmp_path / "parts"
    build_in_parts(PartsPlan.of(open_boxes(paths), GRID, store), GRID, OwnProcess())
    paths[2].write_text(HEADER + sequence(99))
    third = Counted()
    build_in_parts(PartsPlan.of(open_boxes(paths), GRID, store), GRID, third)
    assert third.built == 1
    coarse, fourth = VoxelGrid(1.0, GRID.roi_m), Counted()
    build_in_parts(PartsPlan.of(open_boxes(paths), coarse, store), coarse, fourth)
    assert fourth.built == 8
    moved, fifth = open_boxes(paths, origin_m=(0.0, 0.0, 0.1)), Counted()
    build_in_parts(PartsPlan.of(moved, GRID, store), GRID, fifth)
    assert fifth.built == 8


def test_a_damaged_part_is_built_again(whole: Pog, paths: list[Path], tmp_path: Path) -> None:
    plan = PartsPlan.of(open_boxes(paths), GRID, tmp_path / "parts")
    build_in_parts(plan, GRID, OwnProcess())
    victim = sorted(plan.store.folder.iterdir())[1]
    victim.write_bytes(victim.read_bytes()[:-300])
    again = Counted()
    assert_same(build_in_parts(plan, GRID, again), whole)
    assert again.built == 1


def test_many_parts_are_grouped_in_order(paths: list[Path]) -> None:
    source = open_boxes(paths)
    for at_most in (1, 3, 8, 20):
        groups = groups_of(source, at_most)
        assert len(groups) == min(at_most, 8)
        names = [part.name for group in groups for part in group.parts()]
        assert names == [str(path) for path in paths]


def test_what_is_wrong_in_one_part_is_said_and_the_others_are_kept(paths: list[Path], tmp_path: Path) -> None:
    paths[4].write_text(HEADER + "s,0,car,abc,0,0,1,1,1,0\n")
    plan = PartsPlan.of(open_boxes(paths), GRID, tmp_path / "parts")
    with pytest.raises(InputError, match=r"004\.csv:2: column 'x': found 'abc'"):
        build_in_parts(plan, GRID, OwnProcess())
    assert plan.store.count() == 4


class Late(OwnProcess):
    """Hands in all groups at once, and the first of them fails."""

    ahead = 8

    def submit(self, group: BoxCollection, grid: VoxelGrid) -> Future[bytes]:
        if "000.csv" not in group.parts()[0].name:
            return super().submit(group, grid)
        failed = Future[bytes]()
        failed.set_exception(ChildProcessError("lost"))
        return failed


def test_groups_that_are_done_when_another_fails_are_kept(paths: list[Path], tmp_path: Path) -> None:
    plan = PartsPlan.of(open_boxes(paths), GRID, tmp_path / "parts")
    with pytest.raises(ChildProcessError, match="lost"):
        build_in_parts(plan, GRID, Late())
    assert plan.store.count() == 7


@pytest.mark.parametrize("harm", ["cut", "of another grid", "of other data"])
def test_a_part_that_a_worker_sent_is_checked_before_it_is_kept(
    paths: list[Path], tmp_path: Path, harm: str
) -> None:
    plan = PartsPlan.of(open_boxes(paths), GRID, tmp_path / "parts")

    class Spoiling(OwnProcess):
        def submit(self, group: BoxCollection, grid: VoxelGrid) -> Future[bytes]:
            if harm == "of other data":
                return super().submit(plan.groups[7], grid)
            return super().submit(group, grid if harm == "cut" else VoxelGrid(1.0, grid.roi_m))

        def wait(self, waiting: Collection[Future[bytes]]) -> Collection[Future[bytes]]:
            for future in waiting if harm == "cut" else ():
                future._result = future.result()[:-300]
            return list(waiting)

    with pytest.raises(ChildProcessError, match=r"a worker sent a (damaged part|part of other data)"):
        build_in_parts(plan, GRID, Spoiling())
    assert plan.store.count() == 0


def test_frames_of_the_whole_are_counted_once(paths: list[Path], tmp_path: Path) -> None:
    plan = PartsPlan.of(open_boxes(paths, frames=70_000), GRID, tmp_path / "parts")
    found = build_in_parts(plan, GRID, OwnProcess())
    expected = build_pog(open_boxes(paths, frames=70_000), GRID)
    assert found.data == expected.data
    assert_same(found, expected)
    assert found.counts.dtype == np.uint32


def test_ctrl_c_never_reaches_a_worker_not_even_one_that_is_starting(paths: list[Path]) -> None:
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    with worker_processes(1) as workers:
        workers.submit(groups_of(open_boxes(paths))[0], GRID).result()
        blocked = workers._pool.submit(signal.pthread_sigmask, signal.SIG_BLOCK, ()).result()
    assert signal.SIGINT in blocked
    assert signal.pthread_sigmask(signal.SIG_BLOCK, ()) == before


def test_processes_give_the_same_bits(whole: Pog, paths: list[Path], tmp_path: Path) -> None:
    plan = PartsPlan.of(open_boxes(paths), GRID, tmp_path / "parts")
    with worker_processes(2) as workers:
        assert_same(build_in_parts(plan, GRID, workers), whole)


def test_a_killed_process_ends_the_build_with_one_line(paths: list[Path], tmp_path: Path) -> None:
    import multiprocessing

    plan = PartsPlan.of(open_boxes(paths), GRID, tmp_path / "parts")

    def kill_one(fraction: float) -> None:
        for process in multiprocessing.active_children():
            assert process.pid
            os.kill(process.pid, signal.SIGKILL)

    with pytest.raises(ChildProcessError, match="a worker process ended"), worker_processes(1) as workers:
        build_in_parts(plan, GRID, workers, kill_one)
    assert plan.store.count() >= 1
    assert not multiprocessing.active_children()
