"""Boxes are counted in short calls; where the calls are cut makes no difference."""

from dataclasses import replace

import numpy as np
import pytest

from riglens.core.scene import pog as pogs
from riglens.core.scene.boxes import BoxBatch, rotations_from_yaw
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog, build_pog
from tests.core.builders import Boxes

GRID = VoxelGrid(0.5, (8.0, 6.0, 4.0))


def random_boxes(seed: int, frames: int = 6, per_frame: int = 9, largest_m: float = 6.0) -> Boxes:
    random = np.random.default_rng(seed)
    count = frames * per_frame
    rotation = np.linalg.qr(random.normal(size=(count, 3, 3)))[0]
    return Boxes(
        np.repeat(np.arange(frames), per_frame),
        random.integers(0, 3, count).astype(np.uint8),
        random.uniform([-5, -4, -1], [5, 4, 5], (count, 3)),
        random.uniform(0.2, largest_m, (count, 3)),
        rotation * np.sign(np.linalg.det(rotation))[:, None, None],
        frames,
    )


def bits(pog: Pog) -> tuple[bytes, bytes]:
    return pog.index.words.tobytes(), pog.counts.tobytes()


@pytest.mark.parametrize("voxels", [1, 100, 1000, 20_000])
@pytest.mark.parametrize("boxes", [1, 2, 4096])
def test_calls_of_any_size_give_the_same_pog(
    monkeypatch: pytest.MonkeyPatch, voxels: int, boxes: int
) -> None:
    expected = [bits(build_pog(random_boxes(seed), GRID)) for seed in range(3)]
    monkeypatch.setattr(pogs, "VOXELS_PER_CALL", voxels)
    monkeypatch.setattr(pogs, "BOXES_PER_FRAME", boxes)
    assert [bits(build_pog(random_boxes(seed), GRID)) for seed in range(3)] == expected


def test_no_call_gets_more_than_its_share_unless_one_box_is_that_large(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sizes: list[int] = []
    inner = pogs.fill.fill_counts

    def heard(boxes: np.ndarray, *rest: object) -> None:
        sizes.append(int(pogs.voxels_within_reach(boxes, GRID).sum()))
        inner(boxes, *rest)

    monkeypatch.setattr(pogs.fill, "fill_counts", heard)
    monkeypatch.setattr(pogs, "VOXELS_PER_CALL", 2000)
    source = random_boxes(7, frames=3, per_frame=60, largest_m=30.0)
    build_pog(source, GRID)
    largest_box = 18 * 14 * 10
    assert len(sizes) > 20
    assert max(sizes) <= 2000 + largest_box


def test_the_estimate_covers_what_is_filled() -> None:
    source = random_boxes(3, frames=40, per_frame=1)
    for batch in source.batches():
        packed = pogs.packed_boxes(batch, np.ones(batch.cls.size, np.bool_))
        reach = pogs.voxels_within_reach(packed, GRID)
    for row in range(40):
        alone = Boxes(
            np.zeros(1, np.int64), batch.cls[row : row + 1], batch.centre_m[row : row + 1],
            batch.size_m[row : row + 1], batch.rotation[row : row + 1], 1,
        )  # fmt: skip
        assert build_pog(alone, GRID).index.count <= reach[row]


@pytest.mark.parametrize("seed", range(4))
def test_boxes_that_are_passed_over_would_add_nothing(monkeypatch: pytest.MonkeyPatch, seed: int) -> None:
    boxes = random_boxes(seed, frames=12, per_frame=40)
    boxes = replace(boxes, centre_m=boxes.centre_m * np.random.default_rng(seed).uniform(0.5, 6, (480, 1)))
    expected = bits(build_pog(boxes, GRID))
    passed_over = sum(int((~pogs.near_grid(batch, GRID)).sum()) for batch in boxes.batches())
    assert 50 < passed_over < 430
    monkeypatch.setattr(pogs, "near_grid", lambda batch, grid: np.ones(batch.cls.size, np.bool_))
    assert bits(build_pog(boxes, GRID)) == expected


def test_a_box_that_only_touches_a_voxel_by_its_corner_is_near() -> None:
    turned = rotations_from_yaw(np.array([np.pi / 4]))
    side_m = 2.0
    reach_m = side_m / np.sqrt(2)
    for centre_m in ([4 + reach_m, 0, 1], [0, -3 - reach_m, 1], [0, 0, -0.5], [0, 0, 4.5]):
        height_m = 1.0
        batch = BoxBatch(
            np.zeros(1, np.int64),
            np.zeros(1, np.uint8),
            np.array([centre_m], np.float64),
            np.array([[side_m, side_m, height_m]]),
            turned,
        )
        assert pogs.near_grid(batch, GRID).all(), centre_m
