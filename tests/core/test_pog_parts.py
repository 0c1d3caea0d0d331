"""A POG built part by part is the one built in one go, to the last bit, and an interrupted build goes on."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.errors import InputError
from riglens.core.pieces.folder import count_kept
from riglens.core.pieces.processes import worker_processes
from riglens.core.pieces.work import OwnProcess, Workers
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog, build_pog
from riglens.core.scene.pog_parts import _piece, build_in_parts, group_file, groups_of, part_folder
from riglens.core.scene.readers import open_boxes
from riglens.core.scene.readers.collection import BoxCollection
from riglens.core.scene.readers.opening import Source

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
        paths[-1].write_text(HEADER + "".join(map(sequence, numbers)), encoding="utf-8")
    return paths


def assert_same(found: Pog, expected: Pog) -> None:
    assert np.array_equal(found.index.words, expected.index.words)
    assert found.counts.dtype == expected.counts.dtype
    assert np.array_equal(found.counts, expected.counts)
    for name in ("frames", "boxes", "unmapped", "notes", "sequences", "statistics"):
        assert getattr(found.data, name) == getattr(expected.data, name)


@dataclass(frozen=True)
class Build:
    """A build in parts on the small grid."""

    source: Source
    groups: list[BoxCollection]
    folder: Path

    @classmethod
    def of(cls, source: Source, folder: Path) -> "Build":
        return cls(source, groups_of(source), folder)

    def on(
        self, workers: Workers, progress: Callable[[float], None] | None = None, grid: VoxelGrid = GRID
    ) -> Pog:
        return build_in_parts(self.source, self.groups, grid, part_folder(self.folder), workers, progress)

    @property
    def kept(self) -> int:
        return count_kept(self.folder)


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
    assert_same(Build.of(open_boxes(paths), folder / "parts").on(OwnProcess()), whole)


@pytest.fixture
def paths(tmp_path: Path) -> list[Path]:
    return tables(tmp_path / "data", [[number] for number in range(8)])


def test_parts_of_other_data_or_another_grid_are_not_taken(paths: list[Path], tmp_path: Path) -> None:
    parts = tmp_path / "parts"
    Build.of(open_boxes(paths), parts).on(OwnProcess())
    paths[2].write_text(HEADER + sequence(99), encoding="utf-8")
    Build.of(open_boxes(paths), parts).on(OwnProcess())
    assert count_kept(parts) == 8 + 1
    Build.of(open_boxes(paths), parts).on(OwnProcess(), grid=VoxelGrid(1.0, GRID.roi_m))
    assert count_kept(parts) == 8 + 1 + 8
    Build.of(open_boxes(paths, origin_m=(0.0, 0.0, 0.1)), parts).on(OwnProcess())
    assert count_kept(parts) == 8 + 1 + 8 + 8


def test_two_tables_of_equal_content_count_twice(paths: list[Path], tmp_path: Path) -> None:
    paths[1].write_bytes(paths[0].read_bytes())
    build = Build.of(open_boxes(paths), tmp_path / "parts")
    for _ in range(2):
        assert_same(build.on(OwnProcess()), build_pog(open_boxes(paths), GRID))


def test_many_parts_are_grouped_in_order(paths: list[Path]) -> None:
    source = open_boxes(paths)
    for at_most in (1, 3, 8, 20):
        groups = groups_of(source, at_most)
        assert len(groups) == min(at_most, 8)
        names = [part.name for group in groups for part in group.parts()]
        assert names == [str(path) for path in paths]


def test_what_is_wrong_in_one_part_is_said_and_the_others_are_kept(paths: list[Path], tmp_path: Path) -> None:
    paths[4].write_text(HEADER + "s,0,car,abc,0,0,1,1,1,0\n", encoding="utf-8")
    build = Build.of(open_boxes(paths), tmp_path / "parts")
    with pytest.raises(InputError, match=r"004\.csv:2: column 'x': .*got 'abc'"):
        build.on(OwnProcess())
    assert build.kept == 4


@pytest.mark.parametrize("harm", ["cut", "another grid", "other data"])
def test_a_part_that_a_worker_sent_is_checked_before_it_is_kept(
    paths: list[Path], tmp_path: Path, harm: str
) -> None:
    one, other = groups_of(open_boxes(paths))[:2]
    key = _piece(one, GRID, None).key
    sent = {
        "cut": group_file(one, GRID)[:-300],
        "another grid": group_file(one, VoxelGrid(1.0, GRID.roi_m)),
        "other data": group_file(other, GRID),
    }
    with pytest.raises(ChildProcessError, match="an unexpected result"):
        part_folder(tmp_path).keep(key, sent[harm])
    assert count_kept(tmp_path) == 0


def test_frames_of_the_whole_are_counted_once(paths: list[Path], tmp_path: Path) -> None:
    found = Build.of(open_boxes(paths, frames=70_000), tmp_path / "parts").on(OwnProcess())
    expected = build_pog(open_boxes(paths, frames=70_000), GRID)
    assert found.data == expected.data
    assert_same(found, expected)
    assert found.counts.dtype == np.uint32


def test_processes_give_the_same_bits(whole: Pog, paths: list[Path], tmp_path: Path) -> None:
    with worker_processes(2) as workers:
        assert_same(Build.of(open_boxes(paths), tmp_path / "parts").on(workers), whole)
