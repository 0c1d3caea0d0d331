"""Campaigns try what they say, notice what is wrong, and go on where they were stopped."""

from __future__ import annotations

from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from riglens.core.rig.model import Lidar
from tests.core import campaigns, edits, poses
from tests.core.builders import evaluate, grid_of, random_sensor, rig_of
from tests.core.campaigns import Block, Log, Outcome, blocks_of, run
from tests.core.every_ray import every_ray, is_hit
from tests.core.oracle import exact_cover
from tests.core.rooms import SMALL

# ---------------------------------------------------------------- following every ray


def test_following_rays_gives_what_fractions_give() -> None:
    rng = np.random.default_rng(3)
    for grid in (grid_of(9, 7, 5), grid_of(6, 1, 20, 0.1), SMALL):
        sensor = random_sensor(grid, rng, rays=20)
        on_a_corner = np.array(grid.origin_m) + rng.integers(0, grid.shape) * grid.voxel_m
        level = sensor.replace(position=tuple(map(float, on_a_corner)), rpy_deg=(0.0, 0.0, 90.0))
        for one in (sensor, level):
            assert np.array_equal(every_ray(grid, one)[0], exact_cover(grid, [one]))


def test_rays_through_corners_and_in_faces_are_decided_by_fractions() -> None:
    grid = grid_of(6, 6, 6)
    level = {"elevations_deg": (0.0,), "azimuths_deg": (45.0, 135.0, 0.0, 90.0, 26.565051177077994)}
    total = 0
    for position in ((-2.0, -2.0, 1.0), (0.5, 0.5, 2.0), (-4.0, -4.0, 3.0), (-2.5, -3.0, 0.0)):
        for range_m in ((0.0, float("inf")), (1.0, 3.0)):
            lidar = Lidar(name="L", position=position, range_m=range_m, **level)
            seen, decided = every_ray(grid, lidar)
            assert np.array_equal(seen, exact_cover(grid, [lidar]))
            total += decided
    assert total > 100


def test_a_ray_hits_a_voxel_over_a_length_only() -> None:
    assert is_hit((0.5, 0.5, 0.5), (1.0, 0.0, 0.0), 0.0, 9.0, (2, 0, 0))
    assert not is_hit((0.5, 0.5, 0.5), (1.0, 0.0, 0.0), 0.0, 1.5, (2, 0, 0))
    assert is_hit((0.5, 1.0, 0.5), (1.0, 0.0, 0.0), 0.0, 9.0, (2, 1, 0))
    assert not is_hit((0.5, 1.0, 0.5), (1.0, 0.0, 0.0), 0.0, 9.0, (2, 0, 0))
    assert not is_hit((0.0, 0.0, 0.0), (1.0, 1.0, 0.0), 0.0, 9.0, (1, 0, 0))


# ---------------------------------------------------------------- what is tried


def test_the_models_of_the_library_are_cast_right_in_random_poses() -> None:
    tried = [poses.try_pose(seed) for seed in range(20)]
    assert [told for _, told in tried if told] == []
    assert {"fan", "sheets", "rays"} <= {way for way, _ in tried}


@pytest.mark.slow
@pytest.mark.parametrize("block", blocks_of("poses", 2_000, 1_000_000))
def test_thousands_of_poses(block: Block) -> None:
    assert campaigns.poses(block).wrong == ()


def test_one_voxel_too_few_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    class Forgetful(poses.Watched):
        def mark(self, *args: Any, **more: Any) -> bool:
            done = super().mark(*args, **more)
            marks, informative = args[3], self.field.index.words
            for word in np.flatnonzero(marks & informative)[:1]:
                marks[word] &= ~np.uint64(1 << (int(marks[word] & informative[word]).bit_length() - 1))
            return done

    monkeypatch.setattr(poses, "Watched", Forgetful)
    assert "the engine misses" in poses.try_pose(4)[1]


def test_edits_of_rigs_of_library_models_have_the_bits_of_an_evaluation_from_scratch() -> None:
    assert edits.try_edits(0, 60) == ""


@pytest.mark.slow
@pytest.mark.parametrize("block", blocks_of("edits", 5_000, 1_000_000))
def test_thousands_of_edits(block: Block) -> None:
    assert campaigns.edits(block).wrong == ()


def test_scores_and_voxels_that_are_not_those_of_the_rig_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        edits, "evaluate", lambda field, rig, settings: evaluate(field, rig_of(*rig.sensors[1:]), settings)
    )
    assert "differs from an evaluation from scratch" in edits.try_edits(2, 60)


# ---------------------------------------------------------------- the log


def counted(monkeypatch: pytest.MonkeyPatch) -> list[Block]:
    """Replace what is tried by a list of what was asked."""
    asked: list[Block] = []

    def tried(block: Block) -> Outcome:
        asked.append(block)
        return Outcome(Counter(fan=block.size), ("pose 60 is wrong",) if block.first == 51 else ())

    monkeypatch.setitem(campaigns.CAMPAIGNS, "poses", (tried, 50))
    return asked


def test_a_campaign_goes_on_where_it_was_stopped_and_anew_when_sources_change(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked, path, lines = counted(monkeypatch), tmp_path / "out" / "log.txt", list[str]()
    blocks = blocks_of("poses", 120, 1)
    assert [(block.first, block.size) for block in blocks] == [(1, 50), (51, 50), (101, 20)]
    first = run(blocks[:1], Log(path, "a"), 1, lines.append, ThreadPoolExecutor)
    whole = run(blocks, Log(path, "a"), 1, lines.append, ThreadPoolExecutor)
    assert asked == blocks
    assert first == Outcome(Counter(fan=50), ())
    assert whole == Outcome(Counter(fan=120), ("pose 60 is wrong",))
    assert whole == run(blocks, Log(path, "a"), 1, lines.append, ThreadPoolExecutor)
    assert lines == ["1 blocks", "2 blocks\npose 60 is wrong", "3 blocks"]
    run(blocks, Log(path, "b"), 2, lines.append, ThreadPoolExecutor)
    assert sorted(asked) == sorted(blocks * 2)


def test_a_block_that_ends_its_process_is_told_and_the_next_gets_another(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def tried(block: Block) -> Outcome:
        if block.first == 51:
            raise BrokenProcessPool
        return Outcome(Counter(fan=block.size), ())

    made: list[int] = []

    def make_pool(workers: int) -> ThreadPoolExecutor:
        made.append(workers)
        return ThreadPoolExecutor(workers)

    monkeypatch.setitem(campaigns.CAMPAIGNS, "poses", (tried, 50))
    found = run(blocks_of("poses", 120, 1), Log(tmp_path / "log.txt", "a"), 1, lambda _: None, make_pool)
    assert found == Outcome(Counter(fan=70), ("poses from 51, 50: ended the process",))
    assert made == [1, 1]


def test_the_state_of_the_sources_follows_them(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in (*campaigns.SOURCES, "tests/core", "assets"):
        (tmp_path / name).mkdir(parents=True)
    for name in campaigns.OF_THE_TESTS:
        (tmp_path / "tests" / "core" / name).touch()
    (tmp_path / "assets" / "library.yaml").touch()
    monkeypatch.setattr(campaigns, "REPOSITORY", tmp_path)
    states = [campaigns.state_of_sources()]
    (tmp_path / "core" / "kernels" / "fan.py").write_text("x = 1\n", encoding="utf-8")
    states.append(campaigns.state_of_sources())
    (tmp_path / "tests" / "core" / "poses.py").write_text("x = 2\n", encoding="utf-8")
    states.append(campaigns.state_of_sources())
    assert len(set(states)) == 3
