"""Single frames come back as they were streamed, in any order, with bounded memory, and are read once."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

import riglens.core.view.frames as frames
from riglens.core.errors import Cancelled, InputError
from riglens.core.scene.boxes import BoxBatch
from riglens.core.view.frames import FrameStore
from tests.core.builders import Boxes, boxes_of


def town(count: int = 40) -> Boxes:
    """A box or more in every frame but each third."""
    rows = []
    for frame in range(count):
        for n in range(frame % 3):
            rows.append((frame, n, (frame + 0.25, -n, 0.8), (4.5, 1.9, 1.6), 0.1 * frame))
    return replace(boxes_of(*rows, frames=count + 5), split=(7, 8, 25))


@pytest.fixture
def store() -> Iterator[FrameStore]:
    kept = FrameStore(town())
    yield kept
    kept.close()


@pytest.mark.parametrize("order", [(0, 1, 2, 39), (39, 2, 0, 8), (8, 7, 8)])
def test_frames_come_back_in_any_order(store: FrameStore, order: tuple[int, ...]) -> None:
    source = town()
    for frame in order:
        found, rows = store.boxes(frame), source.frame == frame
        assert found is not None
        np.testing.assert_array_equal(found.cls, source.cls[rows])
        np.testing.assert_allclose(found.centre_m, source.centre_m[rows], atol=1e-5)
        np.testing.assert_allclose(found.size_m, source.size_m[rows], atol=1e-6)
        np.testing.assert_allclose(found.rotation, source.rotation[rows], atol=1e-6)


def test_frames_without_a_trace_in_the_data_have_no_boxes(store: FrameStore) -> None:
    for frame in (0, 3, 42, 10_000):
        found = store.boxes(frame)
        assert found is not None and len(found.cls) == 0


def test_the_data_are_read_only_as_far_as_needed(store: FrameStore) -> None:
    store.boxes(2)
    assert 2 < store.frames_read <= 8
    store.boxes(39)
    assert store.frames_read == 38 + 1  # the last frame with a box


def test_reading_stops_when_it_is_cancelled(store: FrameStore) -> None:
    with pytest.raises(Cancelled):
        store.boxes(39, cancel=lambda: True)
    assert store.frames_read == 0


def test_beyond_the_memory_frames_live_in_a_file(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(frames, "MEMORY_BYTES", 200)
    store = FrameStore(town())
    found = store.boxes(38)
    assert found is not None and len(found.cls) == 2
    assert store._file._rolled  # type: ignore[attr-defined]
    store.close()


def test_a_full_store_says_so_and_keeps_what_it_has() -> None:
    store = FrameStore(town(), max_boxes=5)
    late, early = store.boxes(39), store.boxes(2)
    assert store.is_full
    assert late is not None and len(late.cls) == 0
    assert early is not None and len(early.cls) == 2
    store.close()


def test_boxes_beyond_any_sensor_are_not_kept() -> None:
    store = FrameStore(
        boxes_of((0, 0, (400.0, 0, 1), (4, 2, 1.5), 0.0), (0, 1, (9.0, 0, 1), (2, 1, 2), 0), frames=1)
    )
    found = store.boxes(0)
    assert found is not None and found.cls.tolist() == [1]
    store.close()


def test_unsound_data_are_refused_where_they_are_reached() -> None:
    class Broken:
        def batches(self) -> Iterator[BoxBatch]:
            yield from town().batches()
            raise InputError("boxes.csv:9: column 'x': must be a finite number (got nan)")

    store = FrameStore(Broken())  # type: ignore[arg-type]
    assert store.boxes(5) is not None
    with pytest.raises(InputError, match="got nan"):
        store.boxes(100)
    store.close()
